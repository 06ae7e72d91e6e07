#pragma once
// Position control: proportional-derivative, with bounded effort.
#include <cmath>

#include <momentree/dynamics/forces/effort.hpp>

namespace momentree::forces {

/// The unbounded effort at velocity u (N m, N).
inline double asked(const JointDrive::Pd& pd, int dof, double t, double q, double u) noexcept {
  const Signal *target = signal_of(pd.target, dof), *speed = signal_of(pd.target_speed, dof);
  const double position = target != nullptr ? target->value(t) : 0;
  const double rate = speed != nullptr ? speed->value(t) : target != nullptr ? target->rate(t) : 0;
  return pd.kp.of(dof) * (position - q) + pd.kd.of(dof) * (rate - u);
}

inline Resistance position_control(const JointDrive::Pd& pd, int dof, double t, double q, double u) noexcept {
  const double effort = asked(pd, dof, t, q, u), most = pd.max_effort.of(dof, HUGE_VAL);
  const bool bounded = std::fabs(effort) > most;
  return {bounded ? std::copysign(most, effort) : effort, bounded ? 0 : pd.kd.of(dof), bounded ? 0 : pd.kp.of(dof)};
}

inline void add_position_control(const Site& s, const JointDrive::Pd& pd) noexcept {
  for (int i = 0; i < s.nv; ++i)
    if (s.on(i)) add_effort(s, i, position_control(pd, i, s.t, s.q[i], s.u[i]).force);
}

}  // namespace momentree::forces
