#pragma once
// Topology changes: bookkeeping in canonical momenta. Each applies at any instant to (tree, state), reads a work that was
// evaluated on this very state, allocates nothing and solves for no impulse.
#include <momentree/dynamics/work.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Full failure of the inboard joint of `body` (paper, section 4.1): the body and all outboard ones become a mechanism of their
/// own. The ancestors shed its momentum (29); the new root's momentum is its articulated momentum; no velocity changes.
struct Break {
  Body body;
};

/// What a change let go that is not in the bodies any more: energy of the joint's spring and rotor (J).
struct Released {
  double energy = 0;
};

/// Applies a change. Requires work.evaluated == state.stamp() (call forward_dynamics first); afterwards the work is stale.
/// The joint must be there: breaking a free joint to the ground is a developer's mistake (the events check before).
Released apply(const Break& change, Tree& tree, State& state, const Work<double>& work) noexcept;

/// True where the inboard joint of `body` is there to be broken: not already a free joint to the ground.
bool can_break(const Tree& tree, Body body) noexcept;

}  // namespace momentree
