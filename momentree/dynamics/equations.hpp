#pragma once
// The equations of motion as matrices, M(q) v̇ + c(q, v) = τ: for controllers, optimisation, and comparison with other programs.
// The engine itself neither forms nor solves them.
//
// Arrays are packed like p: nv = tree.nv() numbers in the order of joint numbers, those of a body's inboard joint from
// tree.first_p(b) on. Velocities are those of workspace.v: rates of the coordinates, except for ball and free joints (see
// docs/models.md). Units: rad/s, m/s; rad/s², m/s²; N m, N.
//
// Locked DoFs take no part: they have v̇ = 0, c = 0, τ = 0, and in M a one on the diagonal, so that M stays positive definite and
// solving with it leaves them at rest. DoFs with a prescribed motion are DoFs like any other here; their τ is the effort that the
// motion needs.
//
// All functions evaluate or locate the state first if needed, like totals(); none allocates or throws. They overwrite the scratch
// arrays of the second recursion but leave all results in the workspace valid. A state of another tree and a workspace made for a
// smaller one stop the program.
#include <momentree/dynamics/forward.hpp>

namespace momentree {

/// M(q), nv × nv, row-major, symmetric and positive definite; including armatures. The momenta are p = M v, except that p of a
/// prescribed motion is its rate instead. O(nv²) for the zeros, and O(depth) for each DoF.
void mass_matrix(const Tree& tree, const State& state, Workspace<double>& workspace, double* M) noexcept;

/// u = M⁻¹ r, nv numbers each: the accelerations that efforts r cause beside all others, or the velocities that momenta r have.
/// DoFs that are locked or have a prescribed motion get zero, whatever r is there: they are held. O(n), with the factors of the
/// first recursion and without M; about 0.6 of the time of an evaluation in space. `r` and `u` may be the same array.
void solve_mass(const Tree& tree, const State& state, Workspace<double>& workspace, const double* r, double* u) noexcept;

/// M⁻¹, nv × nv, row-major, symmetric: solve_mass() for each unit vector, O(nv n). Rows and columns of DoFs that are locked or
/// have a prescribed motion are zero; the rest is the inverse of the rest of M.
void inverse_mass_matrix(const Tree& tree, const State& state, Workspace<double>& workspace, double* inverse) noexcept;

/// c(q, v), nv numbers: M v̇ + c = τ. It contains centrifugal, Coriolis and gyroscopic forces, gravity, and the forces on bodies
/// (BodyForce and functions), all as effort that balances them: at rest under gravity, c is the effort that holds the mechanism,
/// and a force that pushes a joint forwards makes c smaller. It contains no joint effort: no drive, spring, damper, friction or
/// stop. O(n), by one outward and one inward pass without a division.
void bias(const Tree& tree, const State& state, Workspace<double>& workspace, double* c) noexcept;

/// M a + c, nv numbers: the joint efforts with which the joints would accelerate by `a` (nv numbers; ignored for locked DoFs).
/// O(n), without M, as `bias`. `a` and `effort` may be the same array.
void inverse_dynamics(const Tree& tree, const State& state, Workspace<double>& workspace, const double* a,
                      double* effort) noexcept;

/// τ, nv numbers: the sum of all joint efforts along each DoF. Constant efforts, drives and functions, springs, dampers, friction
/// and soft stops; for a prescribed motion also the effort that it needs. Calls the functions that drive joints.
void efforts(const Tree& tree, const State& state, Workspace<double>& workspace, double* tau) noexcept;

/// Jacobian of a point that is fixed in `body`, given in its user frame (m): 6 × nv, row-major, world axes. Rows 0 to 2 times v
/// are the velocity of the point (m/s), rows 3 to 5 the angular velocity of the body (rad/s). A force and a torque on the body at
/// that point have the generalised forces Jᵀ (force; torque). Columns of locked DoFs, and of joints that are not between the body
/// and its root, are zero. The ground has a Jacobian of zeros; a removed body stops the program.
void point_jacobian(const Tree& tree, const State& state, Workspace<double>& workspace, BodyId body, Vec3 point,
                    double* J) noexcept;

}  // namespace momentree
