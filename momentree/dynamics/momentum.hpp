#pragma once
// Momenta: of bodies, of what hangs on a joint, conjugate to the joints' velocities (12), (14), (19).
#include <span>

#include <momentree/dynamics/work.hpp>
#include <momentree/tree/model.hpp>

namespace momentree {

/// p from v, both packed (nv), at coordinates q: one outward pass for Ω, one inward for Pb. Set-up only: allocates.
/// p = Eᵀ Pb + armature·v (19).
void project_momentum(const Tree& tree, const double* q, const double* v, double* p);

/// The state of a model's start values q, v, at time 0.
State start_state(const Model& model, const Tree& tree);

/// Articulated momentum Pb of body b (14): of b and all outboard bodies, kernel frame of b. O(depth); the work must be of this
/// state.
Force<double> articulated_momentum(const Tree& tree, const State& state, const Work<double>& work, int b) noexcept;

/// Placement and motion of body b's kernel frame in the world, O(depth); the work must be of this state.
Kinematics<double> locate_body(const Tree& tree, const State& state, const Work<double>& work, int b) noexcept;

/// (29): W, about the origin and in the axes of body b's kernel frame, leaves (sign −1) or joins (+1) what hangs on the ancestors
/// of b: their p change by sign·Eᵀ W. p is the packed array to change; O(depth). Reads q and the work's trigonometry alone, which
/// the caller knows to be of this state (p may be the state's own, under edit).
void shed_momentum(const Tree& tree, const State& state, const Work<double>& work, int b, Force<double> W, double sign,
                   double* p) noexcept;

/// Coordinates and trigonometry of b's joint, as the last evaluation left them in the work.
inline JointState<double> joint_state(const Tree& tree, const State& state, const Work<double>& work, int b) noexcept {
  return {state.q().data() + tree.first_q(b), work.cos.get() + tree.first_angle(b), work.sin.get() + tree.first_angle(b)};
}
/// The crossing of b's joint, with its placement.
DenseCrossing<double> joint_crossing(const Tree& tree, const State& state, const Work<double>& work, int b) noexcept;
/// Writes Eᵀ W of b's joint (nv numbers), W in the kernel frame of b.
void project(const Tree& tree, int b, const JointState<double>& joint, const Force<double>& W, double* p) noexcept;
/// The sum of all bodies' momenta over each joint: Pb of every body, by body number, kernel frames. One inward pass; locates
/// first.
void articulated_momenta(const Tree& tree, const State& state, Work<double>& work, Force<double>* Pb) noexcept;

/// Momentum or wrench of body b: from its kernel frame to the user's frame of the body, and back.
Force<double> to_user_frame(const KernelFrame& frame, const Force<double>& P) noexcept;
Force<double> to_kernel_frame(const KernelFrame& frame, const Force<double>& P) noexcept;

}  // namespace momentree
