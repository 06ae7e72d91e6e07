#include <momentree/topology/snapshot.hpp>

#include <momentree/base/check.hpp>
#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

Snapshot take_snapshot(const Tree& tree, const State& state) {
  MT_REQUIRE(state.topology() == tree.revision(), foreign_state);
  return {tree.topology(), state.time(), {state.q().begin(), state.q().end()}, {state.p().begin(), state.p().end()}};
}

void restore(const Snapshot& snapshot, Tree& tree, State& state) {
  tree.restore(snapshot.topology);
  MT_REQUIRE(static_cast<int>(snapshot.q.size()) == tree.nq() && static_cast<int>(snapshot.p.size()) == tree.nv(),
             "the coordinates and momenta are of this topology");
  state.assign(snapshot.time, snapshot.q, snapshot.p, tree);
}

}  // namespace momentree
