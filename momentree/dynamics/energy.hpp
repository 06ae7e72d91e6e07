#pragma once
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/totals.hpp>
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

/// Energies and momenta of the whole world, summed over the bodies (never p·u/2). Locates the bodies if needed.
[[nodiscard]] Totals totals(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// Energy of b's joint (J): potential energy of the spring and the soft stops, and kinetic energy of the armature. It leaves with
/// the joint's DoFs. Requires a workspace evaluated on this state.
[[nodiscard]] double joint_energy(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) noexcept;

/// Pose of the user frame of body b in the world, from that of its kernel frame.
[[nodiscard]] Pose user_pose(const Tree& tree, const Mat3& R, const Vec3& r, int b) noexcept;
inline Pose user_pose(const Tree& tree, const Kinematics<double>& body, int b) noexcept {
  return user_pose(tree, body.R, body.r, b);
}
inline Pose user_pose(const Tree& tree, const DenseTransform<double>& body, int b) noexcept {
  return user_pose(tree, body.R, body.r, b);
}

/// Pose and velocities (m/s, rad/s) of the user frame of body b, world axes.
[[nodiscard]] BodyMotion user_motion(const Tree& tree, const Kinematics<double>& body, int b) noexcept;

}  // namespace momentree
