#pragma once
#include <momentree/math/vec.hpp>
namespace momentree {
/// The equations of closed loops: their rows and how many of them are independent, and the largest |φ| (m, or sine of an angle).
struct LoopStatus {
  int rows = 0, rank = 0;
  double residual = 0;
};
/// Energies (J) and momenta (kg m/s, kg m²/s) of a whole world, world axes, angular momentum about the world's origin.
struct Totals {
  double kinetic = 0;    ///< including armatures
  double potential = 0;  ///< gravity (zero at the world's origin), springs and soft stops
  Vec3 linear{}, angular{};
  LoopStatus loops{};
};
}  // namespace momentree
