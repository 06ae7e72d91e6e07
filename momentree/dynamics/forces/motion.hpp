#pragma once
// Prescribed motion: the DoF follows a curve s(t) with whatever effort that needs. It has no momentum of its own; in its place p
// holds ṡ and ṗ holds s̈, which the integration method integrates like any other. After every step q and ṡ are set to the curve.
#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

/// Sets coordinates and rates of driven DoFs to the values of their motions at time t (s), in packed arrays.
inline void follow_motions(const Tree& tree, double t, double* q, double* p) noexcept {
  for (const int b : tree.joints_with().motions) {
    const Curve::Point s = prescribed_motion(tree, b).at(t);
    q[tree.first_q(b)] = s.value;
    p[tree.first_p(b)] = s.rate;
  }
}

/// Writes s̈ to the place of each driven DoF in an array packed as p.
inline void put_accelerations(const Tree& tree, double t, double* to) noexcept {
  for (const int b : tree.joints_with().motions) to[tree.first_p(b)] = prescribed_motion(tree, b).at(t).acceleration;
}

/// Zeroes the places of driven DoFs, for code that considers only DoFs with momenta.
inline void clear_driven(const Tree& tree, double* p) noexcept {
  for (const int b : tree.joints_with().motions) p[tree.first_p(b)] = 0;
}

}  // namespace momentree
