#pragma once
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/totals.hpp>
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

/// Energies and momenta of the whole world, from the bodies (never as p·u/2). Locates the bodies where needed.
[[nodiscard]] Totals totals(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// Potential energy of the spring and the soft stops and kinetic energy of the rotor of b's joint (J): what leaves with its
/// freedoms.
/// The work must be of this state.
[[nodiscard]] double joint_energy(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) noexcept;

/// Pose of the user's frame of body b in the world, from that of its kernel frame.
[[nodiscard]] Pose user_pose(const Tree& tree, const Mat3& R, const Vec3& r, int b) noexcept;
inline Pose user_pose(const Tree& tree, const Kinematics<double>& body, int b) noexcept {
  return user_pose(tree, body.R, body.r, b);
}
inline Pose user_pose(const Tree& tree, const DenseTransform<double>& body, int b) noexcept {
  return user_pose(tree, body.R, body.r, b);
}

/// Pose and velocities of the user's frame of body b, world axes.
[[nodiscard]] BodyMotion user_motion(const Tree& tree, const Kinematics<double>& body, int b) noexcept;

}  // namespace momentree
