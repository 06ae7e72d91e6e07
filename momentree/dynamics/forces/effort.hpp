#pragma once
// Time-dependent efforts.
#include <momentree/dynamics/forces/site.hpp>

namespace momentree::forces {

inline void add_effort(const Site& s, int dof, double effort) noexcept {
  s.force[dof] += effort;
  s.power->work += effort * s.u[dof];
}

inline void add_efforts(const Site& s, const JointDrive& drive) noexcept {
  for (int i = 0; i < s.nv; ++i)
    if (s.on(i)) add_effort(s, i, signal_of(drive.effort, i)->value(s.t));
}

}  // namespace momentree::forces
