#pragma once
// The whole state of a world of mechanisms as a value: to return to, and to branch from.
#include <vector>

#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Topology, time, coordinates, momenta or velocities. A world restored from it continues bit for bit as the original would:
/// across any number of changes, also in another tree compiled from the same model.
struct Snapshot {
  Topology topology;
  double time = 0;
  std::vector<double> q, y;  ///< packed, as in the state
  std::vector<Turns> turns;  ///< of loops: State::turns()
  Variables variables = Variables::momenta;
};

[[nodiscard]] Snapshot take_snapshot(const Tree& tree, const State& state);

/// The tree must be compiled from the same model as the one of the snapshot. Workspaces evaluated before become stale, even if
/// nothing had changed.
void restore(const Snapshot& snapshot, Tree& tree, State& state);

}  // namespace momentree
