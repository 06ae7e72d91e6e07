#pragma once
// Random changes, for tests.
#include <momentree/dynamics/test_support.hpp>
#include <momentree/topology/change.hpp>

namespace momentree::test {

/// Breaks off a random body with probability `breaks`, or makes it the root of its floating mechanism; does nothing if neither is
/// possible.
inline void change_at_random(Tree& tree, State& state, Workspace<double>& workspace, Random& random, double breaks) {
  const BodyId b{random.below(tree.bodies())};
  forward_dynamics(tree, state, workspace);
  if (random.chance(breaks) && can_break(tree, tree.inboard_joint(b)))
    apply(Break{tree.inboard_joint(b)}, tree, state, workspace);
  else if (floats(tree, b) && tree.parent(b.index) >= 0)
    apply(Reroot{b}, tree, state, workspace);
}

}  // namespace momentree::test
