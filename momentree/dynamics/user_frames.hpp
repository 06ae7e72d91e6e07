#pragma once
// User-level results of an evaluation: poses, motions and energies.
#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/motion.hpp>

namespace momentree {

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
