#pragma once
// Joint positions that bring points of bodies to given places.
#include <cstdint>
#include <optional>
#include <span>

#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// Where a body is to be: a point of it, or its orientation, or both.
struct KinematicTarget {
  BodyId body;
  Vec3 point{};                       ///< in the body's user frame (m)
  std::optional<Vec3> position{};     ///< of the point in the world (m)
  std::optional<Quat> orientation{};  ///< of the body's user frame in the world
  double weight = 1;                  ///< of this target beside others, if not all can be reached
};

struct KinematicsOptions {
  double tolerance = 1e-9;  ///< of positions (m) and orientations (rad)
  int iterations = 200;     ///< at most, for each attempt
  int attempts = 20;        ///< from the present configuration, then from random ones; with loops only from the present one
  std::uint64_t seed = 0;   ///< of these
};

struct KinematicSolution {
  bool reached = false;       ///< all targets, within the tolerance
  std::vector<double> q;      ///< in the order of State::q(): the nearest configuration that was found
  double position_error = 0;  ///< the largest distance that is left (m)
  double angle_error = 0;     ///< the largest angle that is left (rad)
  int iterations = 0, attempts = 0;
};

/// Solves for all joints that can move, within their hard stops, while loops stay closed: damped Gauss–Newton steps with the
/// Jacobians of the bodies. The world is not changed; contacts are not considered. Of the many solutions of a redundant mechanism
/// it is one near the start. Throws Error for a target without a position and an orientation, for the ground or a removed body,
/// and for a weight or numbers that are not positive or not finite.
[[nodiscard]] KinematicSolution inverse_kinematics(const World& world, std::span<const KinematicTarget> targets,
                                                   const KinematicsOptions& options = {});

}  // namespace momentree
