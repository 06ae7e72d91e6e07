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

}  // namespace momentree
