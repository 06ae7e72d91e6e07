#pragma once
// Stops that give way: max(0, k x + c ẋ) against what has passed one by x. The spring's part is in the potential; what else the
// stop does is the damper's: also where it lets go of a spring that is still compressed, because it never pulls.
#include <algorithm>

#include <momentree/dynamics/forces/site.hpp>

namespace momentree::forces {

/// How far a freedom has passed a stop: positive beyond the upper one, negative beyond the lower one.
inline double passed(const JointLimits& limits, int freedom, double q) noexcept {
  return q - std::clamp(q, limits.lower_of(freedom), limits.upper_of(freedom));
}

inline void add_soft_stop(const Site& s) noexcept {
  const JointLimits& limits = s.parameters.limits;
  for (int i = 0; i < s.nv; ++i) {
    const double x = s.on(i) ? passed(limits, i, s.q[i]) : 0;
    if (x == 0) continue;
    const double spring = limits.stiffness.of(i) * x;
    double force = spring + limits.damping.of(i) * s.u[i];
    if (force * x < 0) force = 0;
    s.force[i] -= force;
    s.power->dissipated += (force - spring) * s.u[i];
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

}  // namespace momentree::forces
