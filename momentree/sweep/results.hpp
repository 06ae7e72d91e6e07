#pragma once
// The tables of a finished sweep: worlds.csv, worlds.jsonl, failures.jsonl. Rows are in the order of the worlds, whatever the
// order in which they were computed.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <momentree/sweep/journal.hpp>
#include <momentree/sweep/machines/encoding.hpp>
#include <momentree/sweep/sweep.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::sweep {

struct Row {
  std::uint64_t world = 0;
  std::vector<double> values;  ///< of the plan
  WorldResult result;
};

/// Calls `visit` with each world in order; false ends it. Throws Error if the journal cannot be read. Needs the memory of one
/// chunk and of an index of all chunks.
void for_each_row(const Sweep& sweep, const Journal& journal, const std::function<bool(const Row&)>& visit);

/// The command that runs one world again: `momentree sweep p.toml --world 3`.
std::string replay_command(const Sweep& sweep, std::uint64_t world);
/// The scenario of a world alone, until its own end: `momentree run s.toml --set 'a.b="2 kg"'`.
std::string run_command(const Sweep& sweep, std::uint64_t world);
/// "done" or "failed: why".
std::string status_of(const WorldResult& result);

/// Writes lines of the tables. The columns are `world`, the varied values, the measures and `status`.
class RowWriter {
 public:
  explicit RowWriter(const Sweep& sweep) : sweep_(sweep), columns_(parameter_columns(sweep)) {}
  void csv_header(std::string& text) const;
  void csv(const Row& row, std::string& text) const;
  /// One object on a line, with the same members; null: absent.
  void json(const Row& row, std::string& text) const;
  /// A line of failures.jsonl: the world, why it failed, its values, and the command that runs it again.
  void failure(const Row& row, std::string& text) const;

 private:
  void varied_json(const Row& row, io::JsonWriter& json) const;

  const Sweep& sweep_;
  std::vector<ParameterColumn> columns_;
};

}  // namespace momentree::sweep
