#pragma once
// What rows have of bodies and joints, in tables, in memory and on pages.
#include <array>
#include <limits>

#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// Position (m), quaternion (w, x, y, z), linear velocity (m/s) and angular velocity (rad/s) of the body's frame, world axes; NaN
/// for a body that is not in the world.
inline std::array<double, 13> body_numbers(const World& world, BodyId body) {
  std::array<double, 13> numbers;
  numbers.fill(std::numeric_limits<double>::quiet_NaN());
  if (!world.alive(body)) return numbers;
  const auto& [pose, v, w] = world.motions()[static_cast<std::size_t>(body.index)];
  const Vec3& x = pose.position;
  const Quat& q = pose.rotation;
  return {x.x, x.y, x.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z};
}

/// Force (N), then torque (N m).
inline std::array<double, 6> wrench_numbers(const Wrench& w) {
  return {w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z};
}

}  // namespace momentree::io
