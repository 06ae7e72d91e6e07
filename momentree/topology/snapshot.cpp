#include <momentree/topology/snapshot.hpp>

#include <momentree/base/check.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

Snapshot take_snapshot(const Tree& tree, const State& state) {
  MT_REQUIRE(state.topology() == tree.revision(), foreign_state);
  return {tree.topology(), state.time(),     {state.q().begin(), state.q().end()}, {state.y().begin(), state.y().end()},
          state.turns(),   state.variables()};
}

void restore(const Snapshot& snapshot, Tree& tree, State& state) {
  tree.edit().restore(snapshot.topology);
  MT_REQUIRE(static_cast<int>(snapshot.q.size()) == tree.nq() && static_cast<int>(snapshot.y.size()) == tree.nv(),
             "the coordinates and momenta or velocities are of this topology");
  state.assign(snapshot.time, snapshot.q, snapshot.y, tree);
  state.set_turns(snapshot.turns);
  if (state.variables() != snapshot.variables) state.change_variables(snapshot.variables, snapshot.y);
}

}  // namespace momentree
