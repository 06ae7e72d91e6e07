#pragma once
// The steps of loops.hpp: positions and rows, the system of the rows, its solution, and its effect on the tree.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loop_workspace.hpp>
#include <momentree/dynamics/loops.hpp>

namespace momentree {

/// A force F and torque T at the point x, world axes, as a wrench on a body in its kernel frame.
Force<double> on_body(const Kinematics<double>& body, const Vec3& F, const Vec3& T, const Vec3& x) noexcept;

/// The wrench of springs, dampers, friction, efforts and drives of a loop joint on its child, in the joint's child-side frame,
/// and their effort along the DoFs; adds their power. At the places and velocities of the workspace.
Force<double> loop_joint_wrench(const Tree& tree, double t, const Workspace<double>& workspace, int place, double* effort,
                                Power* power = nullptr) noexcept;

}  // namespace momentree

namespace momentree::detail {

/// Lays out the memory for the tree's present topology; forgets the chosen rows if that changed.
LoopWorkspace& loop_memory(const Tree& tree, Workspace<double>& workspace);

/// Poses of the bodies at the stops in workspace.bodies and, if `moving`, velocities from workspace.motions; then places and
/// rows.
void place_loops(const Tree& tree, const double* q, Workspace<double>& workspace, bool moving) noexcept;

/// The rows of couplings, part of place_loops.
void place_couplings(const Tree& tree, const double* q, Workspace<double>& workspace, bool moving) noexcept;

/// The scales of the rows, which choosing them needs; after gather_loops with all rows.
void scale_rows(const Tree& tree, Workspace<double>& workspace) noexcept;

/// Gathers A and b of the chosen rows from the records. With `all` of all rows.
void gather_loops(const Tree& tree, const double* q, Workspace<double>& workspace, const Motion<double>& base, bool all) noexcept;

/// Chooses independent rows from A of all rows, by a pivoted factorisation that stops at pivots below `tolerance` (relative to
/// the rows' scales).
void choose_rows(LoopWorkspace& loops, double tolerance) noexcept;
/// Cholesky factor of the chosen rows of A; solves A λ = right for them, in lambda.
void factorise_loops(LoopWorkspace& loops) noexcept;
template <class Right>
void solve_chosen(LoopWorkspace& loops, Right right) noexcept {
  const std::size_t n = loops.chosen.size();
  std::fill(loops.lambda.begin(), loops.lambda.end(), 0.0);
  double* const x = loops.b.data() + loops.rows.size();  // scratch behind b
  for (std::size_t i = 0; i < n; ++i) {
    double s = right(static_cast<std::size_t>(loops.chosen[i]));
    for (std::size_t j = 0; j < i; ++j) s -= loops.factor[i * n + j] * x[j];
    x[i] = s / loops.factor[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    double s = x[i];
    for (std::size_t j = i + 1; j < n; ++j) s -= loops.factor[j * n + i] * x[j];
    x[i] = s / loops.factor[i * n + i];
    loops.lambda[static_cast<std::size_t>(loops.chosen[i])] = x[i];
  }
}
/// Adds the multipliers' part to u0 and to the reduced bias wrenches of the bodies at the stops.
void apply_multipliers(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept;

/// H⁻¹ Jᵀ λ to workspace.a, for A λ = right(row); rows are chosen with that tolerance if it is positive. Evaluates (q, u), so
/// that places, rows and records are of these.
struct LoopCorrection {
  const Tree& tree;
  Workspace<double>& workspace;
  void evaluate(const double* q, const double* u, double tolerance) noexcept;
  template <class Right>
  void solve(const double* q, Right right) noexcept {
    solve_chosen(*workspace.loops, right);
    finish(q);
  }

 private:
  void finish(const double* q) noexcept;
};

}  // namespace momentree::detail
