// Changes of loop joints. A loop that is made is a plastic impact in the directions that it blocks; one that breaks changes no
// velocity.
#include <algorithm>

#include <momentree/dynamics/loop_workspace.hpp>
#include <momentree/dynamics/loops.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/velocities.hpp>

namespace momentree {

namespace {

// The tree has changed, but no coordinate.
void renew(const Tree& tree, State& state) { state.replace(0, 0, {}, 0, 0, {}, tree); }

std::size_t place_of(const Tree& tree, JointId joint) {
  std::size_t i = 0;
  while (i < tree.loops().size() && !(tree.loops()[i].id() == joint)) ++i;
  MT_REQUIRE(i < tree.loops().size(), "the loop joint is in the tree");
  return i;
}

}  // namespace

JointId apply(const MakeLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  if (state.variables() == Variables::momenta) {
    state.change_variables(Variables::velocities, {workspace.v.get(), state.y().size()});
    forward_dynamics(tree, state, workspace);
  }
  carry_momenta(tree, workspace);
  const int number = tree.add_loop(change.loop);
  renew(tree, state);
  state.set_turn(tree.loops().size() - 1, change.turn);
  settle_velocities(tree, state, workspace, change.loop.body);
  return {first_loop + number};
}

Released apply(const BreakLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const std::size_t place = place_of(tree, change.joint);
  const Released released{change.keeps_energy ? 0 : loop_energy(tree, workspace, static_cast<int>(place))};
  tree.remove_loop(change.joint.index - first_loop);
  renew(tree, state);
  state.remove_turn(place);
  return released;
}

Released apply(const SetLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const std::size_t place = place_of(tree, change.joint);
  const Released released{change.keeps_energy ? 0 : loop_energy(tree, workspace, static_cast<int>(place))};
  if (change.impact) carry_momenta(tree, workspace);
  tree.set_loop(change.joint.index - first_loop, change.to, change.parameters, change.held);
  renew(tree, state);
  state.set_turn(place, change.turn);
  if (change.impact) settle_velocities(tree, state, workspace, tree.loops()[place].body);
  return released;
}

}  // namespace momentree
