// Changes of springs between two points: no coordinate, momentum or velocity is affected.
#include <momentree/dynamics/forces/springs.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

Released apply(const BreakSpring& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const Released released{spring_energy(tree, state, workspace, change.spring.index)};
  tree.edit().break_spring(change.spring.index);
  state.replace(0, 0, {}, 0, 0, {}, tree);
  return released;
}

Released apply(const SetSpring& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  tree.edit().set_spring_law(change.spring.index, change.law);
  state.replace(0, 0, {}, 0, 0, {}, tree);
  return {};
}

}  // namespace momentree
