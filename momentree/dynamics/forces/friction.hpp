#pragma once
// Dry friction, smoothed.
#include <cmath>

#include <momentree/dynamics/forces/site.hpp>

namespace momentree::forces {

inline void add_friction(const Site& s) noexcept {
  const JointFriction& f = s.parameters.friction;
  for (int i = 0; i < s.nv; ++i) {
    const double coulomb = f.coulomb.of(i);
    if (coulomb == 0 || !s.on(i)) continue;
    const double force = coulomb * std::tanh(s.u[i] / f.speed.of(i));
    s.force[i] -= force;
    s.power->dissipated += force * s.u[i];
  }
}

}  // namespace momentree::forces
