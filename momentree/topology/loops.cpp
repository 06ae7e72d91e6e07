// Changes of loop joints. A loop that is made is a plastic impact in the directions that it blocks; one that breaks changes no
// velocity.
#include <algorithm>

#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/velocities.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

namespace {

// The tree has changed, but no coordinate.
void renew(const Tree& tree, State& state) { state.replace(0, 0, {}, 0, 0, {}, tree); }

std::size_t place_of(const Tree& tree, JointId joint) {
  const int place = tree.loops().place(joint);
  MT_REQUIRE(place >= 0, "the loop joint is in the tree");
  return static_cast<std::size_t>(place);
}

double energy_of(const Tree& tree, const Workspace<double>& workspace, std::size_t place) {
  const auto i = static_cast<int>(place);
  return loop_energy(tree, workspace, i) + loop_armature_energy(tree, workspace, i);
}

// The armature of a DoF that is locked stops with it.
double stopped_armatures(const Tree& tree, const Workspace<double>& workspace, std::size_t place, unsigned locked) {
  const Loop& loop = tree.loops()[place];
  double q[7] = {}, u[6] = {}, energy = 0;
  loop_coordinates(tree, workspace, static_cast<int>(place), q, u);
  for (int i = 0; i < info(loop.joint.kind).nv; ++i)
    if ((locked & ~loop.joint.locked) >> i & 1u) energy += 0.5 * loop.parameters.armature.of(i) * u[i] * u[i];
  return energy;
}

}  // namespace

JointId apply(const MakeLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  if (state.variables() == Variables::momenta) {
    state.change_variables(Variables::velocities, {workspace.v.get(), state.y().size()});
    forward_dynamics(tree, state, workspace);
  }
  carry_momenta(tree, workspace);
  const int number = tree.edit().add_loop(change.loop);
  renew(tree, state);
  state.set_turns(tree.loops().size() - 1, change.turns);
  settle_velocities(tree, state, workspace, change.loop.body);
  return {first_loop + number};
}

Released apply(const BreakLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const std::size_t place = place_of(tree, change.joint);
  const Released released{change.keeps_energy ? 0 : energy_of(tree, workspace, place)};
  tree.edit().remove_loop(change.joint.index - first_loop);
  renew(tree, state);
  state.remove_turns(place);
  return released;
}

Released apply(const EndCoupling& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  tree.edit().end_coupling(change.coupling.index);
  renew(tree, state);
  return {};
}

Released apply(const SetLoop& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const std::size_t place = place_of(tree, change.joint);
  Released released{change.keeps_energy ? 0 : energy_of(tree, workspace, place)};
  if (change.impact) carry_momenta(tree, workspace);
  if (change.keeps_energy) released.energy += stopped_armatures(tree, workspace, place, change.to.locked);
  tree.edit().set_loop(change.joint.index - first_loop, change.to, change.parameters, change.held);
  renew(tree, state);
  state.set_turns(place, change.turns);
  if (change.impact) settle_velocities(tree, state, workspace, tree.loops()[place].body);
  if (tree.loops()[place].driven()) {  // it begins where the joint is, up to a tolerance
    double energy = 0;
    const State::Edit edit = state.edit();
    const bool closed = close_loops(tree, edit.time, edit.q.data(), edit.u.data(), workspace, energy);
    static_cast<void>(closed);  // else the next step will say so
  }
  return released;
}

}  // namespace momentree
