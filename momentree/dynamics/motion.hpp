#pragma once
// How a user sees a body move.
#include <momentree/math/vec.hpp>

namespace momentree {

/// A body's frame: pose in the world, velocity of its origin and angular velocity, world axes.
struct BodyMotion {
  Pose pose;
  Vec3 linear, angular;
};

/// Velocity of a point that is given in the body's frame, world axes.
inline Vec3 velocity_of(const BodyMotion& motion, const Vec3& point) {
  return motion.linear + cross(motion.angular, rotation_matrix(motion.pose.rotation) * point);
}

}  // namespace momentree
