#pragma once
// Position control: proportional and derivative, bounded.
#include <algorithm>

#include <momentree/dynamics/forces/effort.hpp>

namespace momentree::forces {

inline void add_position_control(const Site& s, const JointDrive::Pd& pd) noexcept {
  for (int i = 0; i < s.nv; ++i) {
    if (!s.on(i)) continue;
    const Signal *target = signal_of(pd.target, i), *speed = signal_of(pd.target_speed, i);
    const double position = target != nullptr ? target->value(s.t) : 0;
    const double rate = speed != nullptr ? speed->value(s.t) : target != nullptr ? target->rate(s.t) : 0;
    double effort = pd.kp.of(i) * (position - s.q[i]) + pd.kd.of(i) * (rate - s.u[i]);
    if (!pd.max_effort.empty()) effort = std::clamp(effort, -pd.max_effort.of(i), pd.max_effort.of(i));
    add_effort(s, i, effort);
  }
}

}  // namespace momentree::forces
