#pragma once
// (q, p) → (q̇, ṗ) in two recursions, O(n): the backward one (22)–(26), the forward one (27), (17), (21), (20).
#include <momentree/dynamics/rates_function.hpp>
#include <momentree/dynamics/workspace.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// One evaluation at packed arrays q (nq numbers) and p (nv), which nothing checks: writes work.v, work.qdot, work.pdot. Neither
/// allocates nor throws. Marks the work as of no state, and leaves records and angles of no use to others: use `forward_dynamics`
/// for what a change or a reader needs.
template <class T>
void evaluate_rates(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept;

/// The same by kernels that also keep the motion of every body in work.motions, records, and sines and cosines of the joints.
template <class T>
void evaluate_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept;

/// The same for a state of this tree: work then carries the state's stamp. A work that carries it already is left as it is. Stops
/// the program for a state of another tree, and for a work that was made for a smaller one.
void forward_dynamics(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// evaluate_rates, or evaluate_motions where forces will ask where joints and bodies are.
void evaluate_for_forces(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace) noexcept;

/// One evaluation with the forces at time t: pdot and power are whole then. Of no state, as evaluate_rates; worlds in which
/// motions are prescribed take the second recursion too, for the power of their drives. `generated`: code for this topology, run
/// instead of evaluate_rates where that would do; null: none.
void evaluate_stage(const Tree& tree, double t, const double* q, const double* p, Workspace<double>& workspace,
                    RatesFunction generated = nullptr) noexcept;

/// Joint forces of dampers, springs, efforts and all other elements at time t, added to pdot, which has s̈ of what is driven
/// instead; their power is work.power, but for that of prescribed motions. `resisting` false: without what resistance.hpp has.
void add_joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, bool resisting = true) noexcept;

/// The same forces τ (nv numbers), for velocities work.v; zero where a freedom is locked, s̈ where it is driven.
void joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, double* tau) noexcept;

/// The forces of springs and drives on the freedoms of b's joint (nv numbers) as if none were locked: what a stop must hold.
void unlocked_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, int b, double* force) noexcept;

/// The spring of body b's joint: writes its generalised force (nv numbers) and returns its energy (J). The joint must have one.
double joint_spring(const Tree& tree, const double* q, int b, double* force) noexcept;
/// The same at coordinates q of that joint alone.
double joint_spring_at(const Tree& tree, const double* q, int b, double* force) noexcept;

/// The effort that b's driven joint takes, beside its springs, dampers and friction (N m, N): work is
/// that of this evaluation, and accelerated.
double motion_effort(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept;

/// World poses and velocities of all bodies (kernel frames) into work.bodies; evaluates first where needed.
void locate_bodies(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// The same at coordinates q of no state, for the velocities that the last evaluation found there: after a stage. Writes
/// work.bodies alone.
void locate_stage(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept;

/// Coordinates and trigonometry of b's joint, as the last evaluation left them in the work.
inline JointState<double> joint_state(UncheckedTree tree, const double* q, const Workspace<double>& workspace, int b) noexcept {
  return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
}
inline JointState<double> joint_state(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept {
  static_cast<void>(tree.index(b));
  return joint_state(UncheckedTree(tree), q, workspace, b);
}
inline JointState<double> joint_state(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) noexcept {
  return joint_state(tree, state.q().data(), workspace, b);
}
/// The crossing of b's joint, with its placement, as the last evaluation found it.
DenseTransform<double> joint_transform_of(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept;
inline DenseTransform<double> joint_transform_of(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 int b) noexcept {
  return joint_transform_of(tree, state.q().data(), workspace, b);
}

extern template void evaluate_rates<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
extern template void evaluate_motions<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;

}  // namespace momentree
