#pragma once
// Accelerations and joint wrenches: the paper's second recursion (30)–(51), with its corrections. It reuses M̂, G and the factors
// of Mj that the first one left; O(n), one pass in and one out.
#include <momentree/dynamics/forward.hpp>

namespace momentree {

/// Accelerations u̇ of all joints in work.a (packed as p; zero where a freedom is locked, s̈ where its motion is prescribed); of
/// every body a′ = Ω̇ − E u̇ in work.approaches and, of the wrench Tr = M̂ a′ + W of its joint, W in work.demands. Evaluates the
/// state first where needed; a work that has them already is left as it is. Neither allocates nor throws.
void accelerate(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// The same passes for any scalar, at coordinates q: after evaluate_motions there, and with the joint forces τ (s̈ where a motion
/// is prescribed) in work.a; where forces act on bodies, with T of every body in work.loads.
template <class T>
void evaluate_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept;

/// Ω̇ of body b, less gravity, in its kernel frame (39); the work must be accelerated, or come from evaluate_accelerations.
Motion<double> felt_acceleration(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept;

/// Tr, the whole wrench of b's joint on b, in its kernel frame (44), (32); likewise.
Force<double> transmitted_wrench(const Tree& tree, const Workspace<double>& workspace, int b) noexcept;

/// A joint's wrench on its declared child: force (N) in `l`, torque (N m) in `h`, about the origin of the child's user frame, in
/// its axes. The joint is that which body b carries; where it is carried in reverse, the child is b's parent in the tree.
/// `reaction` is all that the declared parent exerts through the joint: constraint, drive, spring and damping. The work must be
/// of this state, and accelerated.
[[nodiscard]] Force<double> reaction(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                     JointId joint) noexcept;

/// The part of `reaction` that does no work on the joint's freedoms: what its bearings carry. Taken away is the force that the
/// joint transmits along its freedoms, Eᵀ Tr = τ − rotor·u̇, which acts as follows, whatever makes it (drive, spring, damper,
/// rotor): about the axis as a pure torque (revolute, helical, cylindrical), along the axis as a force (prismatic, cylindrical),
/// as a torque in the plane of the two axes (universal), as any torque (ball); planar: a force in the plane through the origin
/// of the joint's child side and a torque across it; free: force and torque about that origin. What holds a locked freedom is a
/// constraint and stays.
[[nodiscard]] Force<double> pure_reaction(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                          JointId joint) noexcept;

/// What acts along each freedom of b's joint, drive, spring, damping and friction together (nv numbers, N m or N): Eᵀ Tr +
/// rotor·u̇ = τ. Where the motion is prescribed, that is the effort which it takes; where a freedom is locked, what holds it.
void joint_effort(const Tree& tree, const State& state, const Workspace<double>& workspace, JointId joint,
                  double* effort) noexcept;

/// Time derivatives of what a user sees of a body's motion: the velocity of its frame's origin (m/s²) and its angular velocity
/// (rad/s²), world axes.
struct BodyAcceleration {
  Vec3 linear{}, angular{};
};
/// The work must be of this state, located and accelerated.
[[nodiscard]] BodyAcceleration body_acceleration(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 BodyId body) noexcept;

extern template void evaluate_accelerations<double>(const Tree&, const double*, Workspace<double>&) noexcept;

}  // namespace momentree
