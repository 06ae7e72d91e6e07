#pragma once
// Inertia of a point mass.
#include <momentree/math/vec.hpp>

namespace momentree {

/// m (|d|² 1 − d dᵀ) of a mass m (kg) at d (m), about the origin (kg m²).
inline Sym3 point_inertia(double m, const Vec3& d) {
  return {m * (d.y * d.y + d.z * d.z),
          m * (d.x * d.x + d.z * d.z),
          m * (d.x * d.x + d.y * d.y),
          -m * d.x * d.y,
          -m * d.x * d.z,
          -m * d.y * d.z};
}

}  // namespace momentree
