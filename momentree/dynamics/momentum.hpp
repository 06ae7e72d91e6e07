#pragma once
// Momenta: of bodies, of what hangs on a joint, conjugate to the joints' velocities (12), (14), (19).
#include <span>

#include <momentree/dynamics/forward.hpp>
#include <momentree/tree/model.hpp>

namespace momentree {

/// p from v, both packed (nv), at coordinates q: one outward pass for Ω, one inward for Pb. Set-up only: allocates.
/// p = Eᵀ Pb + armature·v (19); where a motion is prescribed, the rate v.
void project_momentum(const Tree& tree, const double* q, const double* v, double* p);

/// Body b is new: adds its momentum to the p of its joint (which is set) and of all joints inboard, so that no velocity changes.
/// `parent`: velocity of its parent, kernel frame of the parent; v: of the new joint. Reads q, no work; p is the packed array.
void add_momentum(const Tree& tree, const double* q, int b, const Motion<double>& parent, const double* v, double* p) noexcept;

/// The state of a model's start values q, v, at time 0; joints whose motion is prescribed start where that says. The tree is as
/// it was compiled from this model.
[[nodiscard]] State start_state(const Model& model, const Tree& tree);

/// Articulated momentum Pb of body b (14): of b and all outboard bodies, kernel frame of b. The work must be of this state.
[[nodiscard]] Force<double> articulated_momentum(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 int b) noexcept;

/// Pose of body b's kernel frame in the world, O(depth); the work must be of this state.
[[nodiscard]] DenseTransform<double> locate_body(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 int b) noexcept;

/// (29): W, about the origin and in the axes of body b's kernel frame, leaves (sign −1) or joins (+1) what hangs on the ancestors
/// of b: their p change by sign·Eᵀ W. p is the packed array to change; O(depth). Reads q and the work's trigonometry alone, which
/// the caller knows to be of this state (p may be the state's own, under edit).
void shed_momentum(const Tree& tree, const State& state, const Workspace<double>& workspace, int b, Force<double> W, double sign,
                   double* p) noexcept;

/// p of b's joint changes by sign·Eᵀ W, but for locked and driven freedoms; p is the packed array, W in the kernel frame of b.
void absorb(const Tree& tree, int b, const JointState<double>& joint, const Force<double>& W, double sign, double* p) noexcept;
/// Writes Eᵀ W of b's joint (nv numbers), W in the kernel frame of b.
void project(const Tree& tree, int b, const JointState<double>& joint, const Force<double>& W, double* p) noexcept;
/// Momentum or wrench of body b: from its kernel frame to the user's frame of the body, and back.
Force<double> to_user_frame(const KernelFrame& frame, const Force<double>& P) noexcept;
Force<double> to_kernel_frame(const KernelFrame& frame, const Force<double>& P) noexcept;

}  // namespace momentree
