#pragma once
// Prescribed motion: the freedom follows a curve s(t), whatever effort that takes. It has no momentum of its own; in its place p
// holds ṡ, ṗ is s̈, and the equation integrates itself. After every step both are put where the curve says.
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

/// Coordinates and rates of driven freedoms as their motions have them at time t (s), in packed arrays.
inline void follow_motions(const Tree& tree, double t, double* q, double* p) noexcept {
  for (const int b : tree.driven_joints()) {
    const Curve::Point s = tree.motion(b).at(t);
    q[tree.first_q(b)] = s.value;
    p[tree.first_p(b)] = s.rate;
  }
}

/// s̈ in the place of each driven freedom in an array packed as p.
inline void put_accelerations(const Tree& tree, double t, double* to) noexcept {
  for (const int b : tree.driven_joints()) to[tree.first_p(b)] = tree.motion(b).at(t).acceleration;
}

/// Nothing there, for what asks about freedoms that have momenta.
inline void clear_driven(const Tree& tree, double* p) noexcept {
  for (const int b : tree.driven_joints()) p[tree.first_p(b)] = 0;
}

}  // namespace momentree
