#pragma once
// What resists motion in joints, apart from everything else: for methods that take it implicitly.
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Of dampers c (N m s/rad, N s/m) per freedom (nv numbers, in the order of p); nothing where a motion is prescribed.
void joint_damping(const Tree& tree, double* damping) noexcept;

/// What else resists, per freedom (nv numbers each): its forces (N m, N) and how fast they grow against the velocity, −∂τ/∂u.
struct Resisting {
  double* dissipating;  ///< dry friction and soft stops
  double* giving;       ///< position control, which also gives
  double* slope;
};
/// At time t, coordinates q and velocities u. Zero where a motion is prescribed or a freedom is locked. Neither allocates nor
/// throws.
void resisting_forces(const Tree& tree, double t, const double* q, const double* u, const Resisting& to) noexcept;

/// Where Newton's method should linearise the resisting forces next, after `point` led to velocities u: there; but where a force
/// that is bounded was pushed from one bound past the other, at the velocity at which it is nothing. Writes `point`.
void move_point(const Tree& tree, double t, const double* q, const double* u, double* point) noexcept;

}  // namespace momentree
