#pragma once
// The equations of motion of a world, linearised about its present state.
#include <momentree/math/dense.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// ẋ = A x + B u for small changes x = (δq, δv) of the state, nv numbers each in the order of v, and small efforts u along the
/// DoFs (N m, N). δq is a displacement like v·dt: of ball and free joints a rotation (rad) and a translation (m) in child axes.
/// Rows and columns of DoFs that are locked, rest on a stop, or have a prescribed motion are zero. With closed loops and
/// couplings, changes x that these do not allow count as the nearest ones that they do.
struct Linearization {
  int nv = 0;
  DenseMatrix A;           ///< 2nv × 2nv
  DenseMatrix B;           ///< 2nv × nv
  DenseMatrix projection;  ///< 2nv × 2nv: of x onto the changes that are allowed; without loops and locks the identity
};

/// The exact derivatives, with all forces: O(n) for each DoF. Throws Error where there are none: for closed contacts and taut
/// cables, for joints that close loops and have forces, motions, armatures or locks of their own, and for functions, of which
/// only values are known.
[[nodiscard]] Linearization linearize(const World& world);

}  // namespace momentree
