#pragma once
// Stops that give way: max(0, k x + c ẋ) against what has passed one by x. The spring's energy is in the potential; what else the
// stop takes is the damper's: also what it lets go of in a spring that is still compressed, because it never pulls. There the
// power has a bend that no motion shows: so a step counts all that the stop takes, and at its end what is stored less (see
// `stored`).
#include <algorithm>

#include <momentree/dynamics/forces/site.hpp>

namespace momentree::forces {

/// How far a freedom has passed a stop: positive beyond the upper one, negative beyond the lower one.
inline double passed(const JointLimits& limits, int dof, double q) noexcept {
  return q - std::clamp(q, limits.lower_of(dof), limits.upper_of(dof));
}

inline Resistance soft_stop(const JointLimits& limits, int dof, double q, double u) noexcept {
  const double x = passed(limits, dof, q), damping = limits.damping.of(dof);
  if (x == 0) return {};
  const double force = limits.stiffness.of(dof) * x + damping * u;
  if (force * x < 0) return {};
  return {-force, damping};
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

/// Energy in all soft stops at packed coordinates q (J).
inline double stored(const Tree& tree, const double* q) noexcept {
  double energy = 0;
  for (const int b : tree.forced_joints()) {
    const JointParameters* p = tree.parameters(b);
    if (p != nullptr && p->limits.soft()) energy += soft_stop_energy(*p, info(tree.kind(b)).nv, q + tree.first_q(b));
  }
  return energy;
}

}  // namespace momentree::forces
