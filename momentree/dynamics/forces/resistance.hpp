#pragma once
// The forces that resist motion in joints, separate from all others: for methods that treat them implicitly.
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Damping coefficients c (N m s/rad, N s/m) per DoF (nv numbers, in the order of p); zero for a prescribed motion.
void joint_damping(const Tree& tree, double* damping) noexcept;

/// The other resisting forces per DoF (nv numbers each): their values (N m, N) and the sum of their slopes −∂τ/∂u.
struct Resisting {
  double* dissipating;  ///< dry friction and soft stops
  double* giving;       ///< position control, which may also add energy
  double* slope;
  double* stiffness = nullptr;  ///< of the slopes −∂τ/∂q; null: not of interest
};
/// Evaluates them at time t (s), coordinates q and velocities u. Zero for prescribed motions and locked DoFs. Neither allocates
/// nor throws.
void resisting_forces(const Tree& tree, double t, const double* q, const double* u, const Resisting& to) noexcept;

/// The next linearisation point of Newton's method for the resisting forces, after `point` led to velocities u: it is u, but for
/// a bounded force that went from one bound past the other, the velocity at which the force is zero. Writes `point`.
void move_point(const Tree& tree, double t, const double* q, const double* u, double* point) noexcept;

}  // namespace momentree
