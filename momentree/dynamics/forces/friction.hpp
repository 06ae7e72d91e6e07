#pragma once
// Dry friction, smoothed.
#include <cmath>

#include <momentree/dynamics/forces/site.hpp>

namespace momentree::forces {

inline Resistance friction(const JointFriction& f, int dof, double u) noexcept {
  const double coulomb = f.coulomb.of(dof);
  if (coulomb == 0) return {};
  const double speed = f.speed.of(dof), part = std::tanh(u / speed);
  return {-coulomb * part, coulomb / speed * (1 - part * part)};
}

inline void add_friction(const Site& s) noexcept {
  for (int i = 0; i < s.nv; ++i) {
    if (!s.on(i)) continue;
    const double force = friction(s.parameters.friction, i, s.u[i]).force;
    s.force[i] += force;
    s.power->dissipated -= force * s.u[i];
  }
}

}  // namespace momentree::forces
