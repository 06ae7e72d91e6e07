#pragma once
#include <momentree/math/vec.hpp>
namespace momentree {
/// Energies (J) and momenta (kg m/s, kg m²/s) of a whole world, world axes, angular momentum about the world's origin.
struct Totals {
  double kinetic = 0;    ///< including armatures
  double potential = 0;  ///< gravity (zero at the world's origin), springs and soft stops
  Vec3 linear{}, angular{};
};
}  // namespace momentree
