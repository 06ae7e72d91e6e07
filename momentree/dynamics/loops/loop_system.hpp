#pragma once
// The steps of loops.hpp: positions and rows, the system of the rows, its solution, and its effect on the tree.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loop_kernels.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>

namespace momentree {

/// Axes of the joint's own child-side frame in the world; locks may turn that of the rows about its origin.
Mat3 loop_child_axes(const LoopPlace& place, const LoopLink& link) noexcept;
/// The joint's motion: the pose of its own child-side frame in its own parent-side frame.
Pose loop_pose(const LoopPlace& place, const LoopLink& link) noexcept;

/// The velocity of one DoF of a loop joint as a row; its residual is the coordinate, if the DoF has one.
LoopRow loop_dof_row(const Tree& tree, const Workspace<double>& workspace, int place, int dof) noexcept;

/// The inertial derivative of F and T of a row of a single DoF, at the places and velocities of the workspace.
struct LoopWrenchRate {
  Vec3 F{}, T{};
};
LoopWrenchRate loop_dof_rate(const Tree& tree, const Workspace<double>& workspace, int place, int dof) noexcept;

/// The wrench of springs, dampers, friction, efforts and drives of a loop joint on its child, in the joint's child-side frame,
/// and their effort along the DoFs; adds their power. At the places and velocities of the workspace.
Force<double> loop_joint_wrench(const Tree& tree, double t, const Workspace<double>& workspace, int place, double* effort,
                                Power* power = nullptr) noexcept;

/// The force along a locked DoF of a loop joint that holds it, as a stop on which it rests: without springs and drives. `size`:
/// of the forces of which it is the difference. Requires `accelerate`.
double loop_holding_force(const Tree& tree, double t, const Workspace<double>& workspace, int place, int dof,
                          double& size) noexcept;

/// Corrects only the velocities, at coordinates at which the loops are closed; those of locked DoFs stay. Writes the largest
/// velocity that is left open (m/s, rad/s) by link, if `open` is of that size.
void close_loop_velocities(const Tree& tree, double t, const double* q, double* u, Workspace<double>& workspace,
                           std::span<double> open) noexcept;

}  // namespace momentree

namespace momentree::detail {

/// The present angles of the loops' joints become the hints for the next ones.
void note_turns(const Tree& tree, Workspace<double>& workspace) noexcept;

/// q ← q + N(q) scale·δ.
void displace(const Tree& tree, const double* delta, double scale, double* q) noexcept;

/// Lays out the memory for the tree's present topology; forgets the chosen rows if that changed.
LoopWorkspace& loop_memory(const Tree& tree, Workspace<double>& workspace);

/// Poses of the bodies at the stops in workspace.bodies and, if `moving`, velocities from workspace.motions; then places and
/// all rows, or the chosen ones alone.
void place_loops(const Tree& tree, const double* q, Workspace<double>& workspace, bool moving,
                 LoopRows which = LoopRows::choose) noexcept;

/// Adds the extra efforts of a world of a batch to the joint forces, except along locked and driven DoFs.
void add_extra_efforts(const Tree& tree, const LoopWorkspace& loops, double* force) noexcept;

/// Sets prescribed motions of loop joints to time t (s); before place_loops.
void set_loop_motions(const Tree& tree, double t, Workspace<double>& workspace) noexcept;
/// The armatures keep the velocities that carry_armatures stored, in an impact that follows; those of new loops have their
/// present ones.
void keep_armatures(const Tree& tree, Workspace<double>& workspace) noexcept;

/// Adds the softness of armatures to A. In momenta it also finds their speeds before the evaluation.
void soften(LoopWorkspace& loops) noexcept;

/// Chooses independent rows from A of all rows: those whose pivots are above `tolerance`, relative to the rows' scales.
void choose_rows(const Tree& tree, LoopWorkspace& loops, double tolerance) noexcept;
/// Where the elements of A are for some of the rows, given in ascending order.
void lay_out(const Tree& tree, const std::vector<int>& rows, LoopLayout& layout);
/// H⁻¹ Jᵀ λ to workspace.a, for A λ = right(row); rows are chosen with that tolerance if it is positive. Evaluates (q, u), so
/// that places, rows and records are of these. `evaluate_damped`: with all rows, for (A + damping D²) λ = right(row), where D are
/// the sizes of the rows; damping is relative to the largest element of D⁻¹ A D⁻¹.
struct LoopCorrection {
  const Tree& tree;
  Workspace<double>& workspace;
  void evaluate(const double* q, const double* u, double tolerance) noexcept;
  void evaluate_kept(const double* q, const double* u) noexcept;
  void evaluate_damped(const double* q, const double* u, double damping) noexcept;
  template <class Right>
  void solve(const double* q, Right right) noexcept {
    solve_chosen<double>(*workspace.loops, right);
    finish(q);
  }

 private:
  void gather(const double* q, const double* u) noexcept;
  void finish(const double* q) noexcept;
};

}  // namespace momentree::detail
