#pragma once
// User-level motion of a body.
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

}  // namespace momentree
