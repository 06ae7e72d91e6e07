#pragma once
// Soft stops: force max(0, k x + c ẋ) against a penetration x. The spring's energy is potential energy; everything else that the
// stop absorbs is dissipated, including the energy of a spring that is still compressed when the force drops to zero (it never
// pulls). The power has a kink there that does not show in the motion. So a step integrates all power absorbed by the stop and
// subtracts the stored energy at its end (see `stored`).
#include <algorithm>

#include <momentree/dynamics/forces/site.hpp>

namespace momentree::forces {

/// Penetration of a stop by a DoF (rad, m): positive beyond the upper one, negative beyond the lower one.
inline double passed(const JointLimits& limits, int dof, double q) noexcept {
  return q - std::clamp(q, limits.lower_of(dof), limits.upper_of(dof));
}

inline Resistance soft_stop(const JointLimits& limits, int dof, double q, double u) noexcept {
  const double x = passed(limits, dof, q), damping = limits.damping.of(dof);
  if (x == 0) return {};
  const double force = limits.stiffness.of(dof) * x + damping * u;
  if (force * x < 0) return {};
  return {-force, damping, limits.stiffness.of(dof)};
}

inline void add_soft_stop(const Site& s) noexcept {
  for (int i = 0; i < s.nv; ++i) {
    if (!s.on(i)) continue;
    const double force = soft_stop(s.parameters.limits, i, s.q[i], s.u[i]).force;
    s.force[i] += force;
    s.power->dissipated -= force * s.u[i];
  }
}

inline double soft_stop_energy(const JointParameters& parameters, int nv, const double* q) noexcept {
  double energy = 0;
  for (int i = 0; i < nv; ++i) {
    const double x = passed(parameters.limits, i, q[i]);
    energy += 0.5 * parameters.limits.stiffness.of(i) * x * x;
  }
  return energy;
}

/// Energy stored in all soft stops at packed coordinates q (J).
inline double stored(const Tree& tree, const double* q) noexcept {
  double energy = 0;
  for (const int b : tree.joints_with().forces) {
    const JointParameters* p = tree.parameters(b);
    if (p != nullptr && p->limits.soft()) energy += soft_stop_energy(*p, info(tree.kind(b)).nv, q + tree.first_q(b));
  }
  return energy;
}

}  // namespace momentree::forces
