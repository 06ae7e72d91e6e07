#pragma once
// Random changes that exercise every variant of every joint kind.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/topology/change.hpp>
#include <tests/oracle/prng.hpp>

namespace momentree::oracle {

/// Breaks, locks and reverses joints at random, four times.
inline void rearrange(Prng& random, Tree& tree, State& state, Workspace<double>& workspace) {
  for (int i = 0; i < 4; ++i) {
    const int b = random.integer(0, tree.bodies() - 1);
    const int what = random.integer(0, 2);
    forward_dynamics(tree, state, workspace);
    if (what == 0 && can_break(tree, tree.inboard_joint({b})))
      apply(Break{tree.inboard_joint({b})}, tree, state, workspace);
    else if (what == 1 && floats(tree, {b}))
      apply(Reroot{{b}}, tree, state, workspace);
    else
      apply(Lock{tree.inboard_joint({b}), 1u << random.integer(0, 2)}, tree, state, workspace);
  }
}

}  // namespace momentree::oracle
