#pragma once
// What a rigid body is for dynamics.
#include <momentree/math/vec.hpp>

namespace momentree {

/// Mass (kg), centre of mass (m) and inertia about it (kg m²), in the axes of the body.
struct MassProperties {
  double mass = 0;
  Vec3 com{};
  Sym3 inertia{};
};

}  // namespace momentree
