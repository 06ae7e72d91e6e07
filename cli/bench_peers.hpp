#pragma once
// Other engines on the same models: programs peer-* of bench/peers, which check their own results before they print a time.
#include <functional>
#include <string>
#include <vector>

namespace momentree::cli {

/// One model in one engine.
struct PeerRow {
  std::string engine, way, model;
  double ns_per_body = 0;
  double imbalance = 0;  ///< of the accelerations found: the largest force that is missing at a joint, as a share of the largest
};

/// Paths of the programs peer-* in a folder: ours first, the others by name. Throws Error where there are none.
std::vector<std::string> peer_programs(const std::string& folder);

/// Runs `program evaluate` and calls `row` with each line that it prints, until that returns false.
/// Throws Error if it can't be started, fails, or prints something else.
void peer_evaluations(const std::string& program, const std::function<bool(const PeerRow&)>& row);

}  // namespace momentree::cli
