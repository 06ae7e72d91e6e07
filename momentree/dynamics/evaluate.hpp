#pragma once
// Both recursions and the joint forces, as integrators and topology changes use them.
#include <limits>

#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/steps/rates_function.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/joint_transforms.hpp>
#include <momentree/joint/kernels.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// One evaluation at packed arrays q (nq numbers) and p (nv), which are not checked: writes workspace.v, qdot and pdot. Neither
/// allocates nor throws. The workspace then belongs to no state, and its records and angles must not be read by others: use
/// `forward_dynamics` for topology changes and readers.
template <class T>
void evaluate_rates(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept;

/// The same, with kernels that also store the motion of every body in workspace.motions, the records, and sines and cosines of
/// the joints.
template <class T>
void evaluate_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept;

/// The two passes of evaluate_motions; between them the records may change.
template <class T>
void reduce_momenta(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept;
template <class T>
void resolve_momenta(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept;

/// evaluate_rates, or evaluate_motions if forces will read poses or motions of joints and bodies.
void evaluate_for_forces(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace) noexcept;

/// One stage of an integrator at time t (s), with all forces: completes pdot and power. The workspace then belongs to no state.
/// With prescribed motion it runs the second recursion, too, for the power of the drives. `generated`: code for this topology
/// that replaces evaluate_rates where possible; may be null.
void evaluate_stage(const Tree& tree, double t, const double* q, const double* p, Workspace<double>& workspace,
                    RatesFunction generated = nullptr) noexcept;

/// Adds the joint forces of dampers, springs, efforts and all other elements at time t to pdot (for driven DoFs pdot becomes s̈);
/// workspace.power is their power, except that of prescribed motions. `resisting` false: without the forces of resistance.hpp.
void add_joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, bool resisting = true) noexcept;

/// The same forces τ (nv numbers), for the velocities in workspace.v; zero for locked DoFs, s̈ for driven ones.
void joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, double* tau) noexcept;
/// In addition returns their power, except that of prescribed motions, and writes the forces on driven DoFs other than the
/// motion's own effort to `passive`, by body.
Power joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, double* tau,
                   double* passive) noexcept;

/// Forces of springs and drives on the DoFs of b's joint (nv numbers) as if none were locked: the load on a stop.
void unlocked_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, int b, double* force) noexcept;

/// Spring of body b's joint, which must have one: writes the generalised force (nv numbers) and returns the energy (J).
double joint_spring(const Tree& tree, const double* q, int b, double* force) noexcept;
/// The same, with only that joint's coordinates q. T: double, or a Dual.
template <class T>
T joint_spring_at(const Tree& tree, const T* q, int b, T* force) noexcept;

/// Effort of the prescribed motion of b's joint, in addition to springs, dampers and friction (N m, N). Requires the
/// accelerations of this evaluation.
double motion_effort(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept;

/// Like locate_bodies, but after a stage, at coordinates q that belong to no state, with the velocities of that evaluation.
/// Writes only workspace.bodies.
void locate_stage(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept;

inline Force<double> as_force(const Wrench& wrench) { return {wrench.force, wrench.torque}; }

/// The passes of `accelerate` for any scalar, at coordinates q. Requires evaluate_motions at q and p, the joint forces τ (s̈ for
/// a prescribed motion) in workspace.a and, if forces act on bodies, T of every body in workspace.loads.
template <class T>
void evaluate_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept;

/// M⁻¹ r at coordinates q, for one more right-hand side, in place: `u` holds r, packed as p. DoFs that are locked or have a
/// prescribed motion get zero. Requires evaluate_motions at q. Overwrites the scratch of the second recursion.
/// `begin`, `end`: only for the mechanism whose bodies have these places in the tree's order; only its numbers of `u` are then
/// read and written.
template <class T>
void solve_with_factors(const Tree& tree, const T* q, Workspace<T>& workspace, T* u, int begin = 0,
                        int end = std::numeric_limits<int>::max()) noexcept;

/// Ω̇ of body b less gravity, in its kernel frame (39). Requires accelerate or evaluate_accelerations.
Motion<double> felt_acceleration(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept;

/// Tr, the whole wrench of b's inboard joint on b, in b's kernel frame (44), (32). The same requirement.
Force<double> transmitted_wrench(const Tree& tree, const Workspace<double>& workspace, int b) noexcept;

/// Coordinates and trigonometry of b's joint, from the last evaluation of the workspace.
template <class T>
JointState<T> joint_state(UncheckedTree tree, const T* q, const Workspace<T>& workspace, int b) noexcept {
  return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
}
inline JointState<double> joint_state(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept {
  static_cast<void>(tree.index(b));
  return joint_state(UncheckedTree(tree), q, workspace, b);
}
inline JointState<double> joint_state(const Tree& tree, const State& state, const Workspace<double>& workspace, int b) noexcept {
  return joint_state(tree, state.q().data(), workspace, b);
}
/// Transform of b's joint including its placement, from the last evaluation of the workspace.
DenseTransform<double> joint_transform_of(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept;
inline DenseTransform<double> joint_transform_of(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                                 int b) noexcept {
  return joint_transform_of(tree, state.q().data(), workspace, b);
}

extern template void evaluate_rates<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
extern template void evaluate_motions<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
extern template void reduce_momenta<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
extern template void resolve_momenta<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
extern template void evaluate_accelerations<double>(const Tree&, const double*, Workspace<double>&) noexcept;
extern template void solve_with_factors<double>(const Tree&, const double*, Workspace<double>&, double*, int, int) noexcept;

}  // namespace momentree
