#pragma once
// Motion as users see it: of a body, and of a whole world.
#include <momentree/math/vec.hpp>

namespace momentree {

/// A body's user frame: pose in the world, velocity of its origin (m/s) and angular velocity (rad/s), world axes.
struct BodyMotion {
  Pose pose;
  Vec3 linear, angular;
};

/// Velocity (m/s, world axes) of a point given in the body's user frame.
inline Vec3 velocity_of(const BodyMotion& motion, const Vec3& point) {
  return motion.linear + cross(motion.angular, rotation_matrix(motion.pose.rotation) * point);
}

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
