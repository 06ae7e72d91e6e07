#pragma once
// Velocities as the state between events: (q, u) → (q̇, u̇) by an articulated-body pass in which nothing cancels, and the
// velocities after a change, which every body's own momentum determines.
#include <optional>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loops.hpp>

namespace momentree {

/// The passes for any scalar, at packed arrays q (nq numbers) and u (nv), which are not checked. The first one writes workspace.v
/// and qdot, and of every body the bias that its velocity causes; `Keep`: also its motion, for forces that read motions, and
/// what changes and readers of accelerations need. Neither throws; the first stage of a topology allocates its machine code. The
/// workspace then belongs to no state.
template <class T, bool Keep>
void sweep_velocities(const Tree& tree, const T* q, const T* u, Workspace<T>& workspace) noexcept;
/// The other two: from joint forces τ in workspace.a (zero for locked DoFs, s̈ for a prescribed motion) to accelerations there.
/// `base`: acceleration of the ground, against gravity. With Keep also the records, a′ and Ŵ of all bodies.
template <class T, bool Keep>
void solve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept;
/// The inward pass alone, which closed loops complete before the outward pass.
template <class T, bool Keep>
void reduce_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept;
template <class T, bool Keep>
void resolve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept;

/// One stage of an integrator at time t (s), with all forces: writes workspace.v, qdot, a (u̇) and power. For driven DoFs u holds
/// the prescribed rate and u̇ its derivative. The workspace then belongs to no state. `generated`: code for this topology that
/// replaces the passes where possible; may be null.
void evaluate_velocity_stage(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                             VelocityRatesFunction generated = nullptr) noexcept;

/// The same with closed loops by generated code, if its rows are those that were chosen in the workspace; returns false, and does
/// nothing, if they are not. Requires stages_take_loop_rates and set-up of the loops in the workspace for this topology.
[[nodiscard]] bool evaluate_loop_stage(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                                       const GeneratedRates& generated) noexcept;
/// The same, and it keeps what readers of accelerations need. Loops with chosen, or with kept rows.
void evaluate_velocities_keeping(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                                 LoopRows rows) noexcept;

/// The same without the forces of contacts.
void evaluate_velocities_without_contacts(const Tree& tree, double t, const double* q, const double* u,
                                          Workspace<double>& workspace, LoopRows rows) noexcept;

/// The same for a state, whose stamp the workspace then carries as evaluated and accelerated. Also writes the articulated momenta
/// Pb of all bodies and workspace.p.
void evaluate_velocity_state(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// ṗ of a state in velocities, to workspace.pdot; evaluates the state first if needed. With loops also of a state in momenta, to
/// workspace.p, because its rates ṗ* in workspace.pdot are without the multipliers.
void find_momentum_rates(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// The momenta p of velocities u, and of every body Pb in workspace.motions, whose velocities are those of u: one inward sum,
/// (14) and (19). Requires sweep_velocities with Keep. For driven DoFs p is the prescribed rate, for frozen ones zero.
void sum_momenta(const Tree& tree, const double* q, Workspace<double>& workspace, double* p) noexcept;

/// Velocities u (nv numbers, in place) after a change, at coordinates q: the joints transmit impulses, and every body keeps its
/// own momentum up to these, so that no digits are lost in long chains. In: u of DoFs with armature, as before the change, and
/// the rates of driven DoFs; workspace.carried, the momentum M Ω of every body before the change, in its present kernel frame.
/// Overwrites everything else in the workspace. Loop joints with a prescribed motion have its rate at `time` (s), and armatures
/// the velocities that carry_armatures stored; without a time, u and carried are changes of velocities and momenta by an impulse.
void project_velocities(const Tree& tree, const double* q, double* u, Workspace<double>& workspace,
                        std::optional<double> time = {}) noexcept;

extern template void sweep_velocities<double, false>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
extern template void sweep_velocities<double, true>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
extern template void reduce_accelerations<double, true>(const Tree&, const double*, Workspace<double>&) noexcept;
extern template void resolve_accelerations<double, true>(const Tree&, const double*, Workspace<double>&,
                                                         const Motion<double>&) noexcept;
extern template void solve_accelerations<double, false>(const Tree&, const double*, Workspace<double>&,
                                                        const Motion<double>&) noexcept;
extern template void solve_accelerations<double, true>(const Tree&, const double*, Workspace<double>&,
                                                       const Motion<double>&) noexcept;

}  // namespace momentree
