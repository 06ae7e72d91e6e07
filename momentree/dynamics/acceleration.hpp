#pragma once
// Accelerations and joint wrenches: the paper's second recursion (30)–(51), with its corrections. It reuses M̂, G and the factors
// of Mj from the first recursion; O(n), one inward and one outward pass.
#include <momentree/dynamics/forward.hpp>
#include <momentree/model/body_force.hpp>

namespace momentree {

/// Computes the accelerations u̇ of all joints in workspace.a (packed as p; zero for locked DoFs, s̈ for a prescribed motion);
/// for every body a′ = Ω̇ − E u̇ in workspace.inboard_accelerations and, of the wrench Tr = M̂ a′ + Ŵ of its inboard joint, Ŵ in
/// workspace.reduced_bias_wrenches. Evaluates the state first if needed; a workspace that already has the accelerations is left
/// unchanged. Neither allocates nor throws.
void accelerate(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// A joint's wrench on its declared child, about the origin of the child's user frame, in
/// its axes. `reaction` is everything that the declared parent exerts through the joint: constraint, drive, spring and damping.
/// Requires `accelerate` on this state.
[[nodiscard]] Wrench reaction(const Tree& tree, const State& state, const Workspace<double>& workspace, JointId joint) noexcept;

/// The part of `reaction` that does no work on the joint's DoFs: the load on its bearings. It is `reaction` less the force that
/// the joint transmits along its DoFs, Eᵀ Tr = τ − armature·u̇, whatever causes it (drive, spring, damper, armature). That force
/// is taken to act as follows: about the axis as a pure torque (revolute, helical, cylindrical), along the axis as a force
/// (prismatic, cylindrical), as a torque in the plane of the two axes (universal), as any torque (ball); planar: a force in the
/// plane through the origin of the joint's child side and a torque normal to the plane; free: force and torque about that origin.
/// The force that holds a locked DoF is a constraint force and remains.
[[nodiscard]] Wrench bearing_reaction(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                      JointId joint) noexcept;

/// Effort along each DoF of a joint, of drive, spring, damping and friction together (nv numbers, N m or N): Eᵀ Tr +
/// armature·u̇ = τ. For a prescribed motion it is the effort that the motion needs; for a locked DoF, the effort that holds it.
void joint_effort(const Tree& tree, const State& state, const Workspace<double>& workspace, JointId joint,
                  double* effort) noexcept;

/// Time derivatives of a body's user-level velocities: of the velocity of its user frame's origin (m/s²) and of its angular
/// velocity (rad/s²), world axes.
struct BodyAcceleration {
  Vec3 linear{}, angular{};
};
/// Requires `locate_bodies` and `accelerate` on this state.
[[nodiscard]] BodyAcceleration body_acceleration(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 BodyId body) noexcept;

}  // namespace momentree
