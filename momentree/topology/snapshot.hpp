#pragma once
// The whole state of a world of mechanisms as a value: to go back to, and to branch from.
#include <vector>

#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Topology, time, coordinates, momenta. A world restored from it goes on with the very bits that it would have had: across any
/// number of changes, also in another tree compiled from the same model.
struct Snapshot {
  Topology topology;
  double time = 0;
  std::vector<double> q, p;  ///< packed, as in the state
};

[[nodiscard]] Snapshot take_snapshot(const Tree& tree, const State& state);

/// The tree was compiled from the same model as that which the snapshot was taken of. Work that was evaluated before is stale
/// afterwards, even where nothing had changed.
void restore(const Snapshot& snapshot, Tree& tree, State& state);

}  // namespace momentree
