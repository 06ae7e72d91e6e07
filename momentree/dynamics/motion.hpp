#pragma once
// How a user sees a body move.
#include <momentree/math/vec.hpp>

namespace momentree {

/// A body's frame: pose in the world, velocity of its origin and angular velocity, world axes.
struct BodyMotion {
  Pose pose;
  Vec3 linear, angular;
};

}  // namespace momentree
