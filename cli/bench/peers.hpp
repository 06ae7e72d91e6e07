#pragma once
// Other engines on the same models: programs peer-* of bench/peers, which check their own results before they print a time.
#include <functional>
#include <string>
#include <vector>

#include <momentree/text/json_writer.hpp>

namespace momentree::cli {

/// One model in one engine.
struct PeerRow {
  std::string engine, way, model;
  double ns_per_body = 0;
  double imbalance = 0;  ///< of the accelerations found: the largest unbalanced force at a joint, relative to the largest force
};

/// Paths of the programs peer-* in a folder: momentree's first, the others by name. Throws Error if there are none.
std::vector<std::string> peer_programs(const std::string& folder);

/// Runs `program evaluate FILE…` and calls `row` with each line of its output, until that returns false. The files are models
/// (cli/bench/peer_links.hpp); without files, the program uses its built-in models. Throws Error if it cannot be started, fails,
/// or prints anything else.
void peer_evaluations(const std::string& program, const std::vector<std::string>& files,
                      const std::function<bool(const PeerRow&)>& row);

/// All rows of all programs, until the user interrupts. A program that fails on one of the files is left out there with a
/// message; throws Error if a program fails on its built-in models.
std::vector<PeerRow> measure_peers(const std::vector<std::string>& programs, const std::vector<std::string>& files);

/// Nanoseconds per body: a column for each model, a row for each method of an engine, momentree's first.
std::string peers_table(const std::vector<PeerRow>& rows);
/// Writes the member `peers` of a document.
void write_peers(io::JsonWriter& json, const std::vector<PeerRow>& rows);

}  // namespace momentree::cli
