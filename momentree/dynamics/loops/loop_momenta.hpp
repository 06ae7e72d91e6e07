#pragma once
// Closed loops in momenta. Inside a step the state holds p* = p − Jᵀ σ, where σ are the impulses of the loops since the start of
// the step: every evaluation finds σ from J u = 0, and the same motion follows from p* + Jᵀ c for any c. The passes are those of
// the tree. Between them A σ = −b is solved, where A = J H⁻¹ Jᵀ and b = J H⁻¹ p* come from the records of the inward pass; then
//
//   ṗ* = τ + Eᵀ (Tb + F − Ω × P*) + Ėᵀ P*,   P* = Pb − Wb,
//
// where Wb is the momentum that the loops brought to the bodies outboard, and F, summed inward like Tb, the inertial derivative
// of the rows' unit wrenches times −σ. At the end of a step p = p* + Jᵀ σ is the state's momentum again: p = H u.
//
// A prescribed motion s(t) of a loop joint is a row J u = ds/dt. An armature I has the impulse −I (u_l − u_l0) since the start of
// the step, where its speed was u_l0: (A σ)_j + σ_j / I = u_l0 − b_j. It is no part of a state's momenta H u, from which u_l0
// follows. The rows of couplings have efforts instead of unit wrenches.
#include <momentree/dynamics/loops/loops.hpp>

namespace momentree {

/// q̇ and ṗ* at time t (s) with all forces: writes workspace.v, qdot, pdot and power. The workspace then belongs to no state.
/// `resistance`: with what resisting_forces computes of the joints of the tree; without it, power lacks the work of motions.
void evaluate_with_loops(const Tree& tree, double t, const double* q, const double* p, Workspace<double>& workspace,
                         LoopRows rows, bool resistance = true) noexcept;
/// The same for a state in momenta, whose stamp the workspace then carries.
void evaluate_state_with_loops(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// The velocities of momenta p at q, with the rows chosen last, to workspace.v. Rates are meaningless afterwards. Prescribed
/// motions of loop joints have the rates of the last evaluation.
void find_velocities_with_loops(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace,
                                ArmatureSpeeds armatures = ArmatureSpeeds::kept) noexcept;

/// Accelerations and multipliers of a state in momenta: see `accelerate`. The state must be evaluated.
void accelerate_with_loops(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// Closes the loops after a step that ended at t (s), as close_loops does, and makes p* the momenta p = H u of the result. The
/// momenta of a floating or pivoted root are first expressed at its corrected place, so that the total momentum stays.
[[nodiscard]] bool close_loops_in_momenta(const Tree& tree, double t, double* q, double* p, Workspace<double>& workspace,
                                          double& energy) noexcept;
/// Corrects coordinates of closed loops for as long as that helps: close to a singular position they are off by |φ| / clearance.
/// True if it changed them; the loops must then be closed again.
[[nodiscard]] bool close_coordinates_further(const Tree& tree, double t, double* q, const double* u,
                                             Workspace<double>& workspace) noexcept;
/// Adds ṗ* − ṗ to `rates`, which hold ṗ at the state that the last closing led to: the rates of the step's own p* there.
/// `impulses`: σ of that closing, by row. The workspace must be evaluated at this state.
void add_gauge_rates(const Tree& tree, const double* q, Workspace<double>& workspace, const double* impulses,
                     double* rates) noexcept;

}  // namespace momentree

namespace momentree::detail {

/// Between the passes, with the rows that loops.wanted says: σ, and what it adds to the records of the inward pass.
void solve_momenta_of_loops(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept;

/// The passes, and the articulated momenta P* of the bodies; Wb = Pb − P* is in loops.momenta.
void find_motions_with_loops(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace, LoopRows rows,
                             ArmatureSpeeds armatures) noexcept;
/// Wb of impulses σ by row, of the bodies at the stops, to loops.momenta; at the places of the workspace.
void sum_loop_momenta(const Tree& tree, const double* q, const Workspace<double>& workspace, const double* impulses) noexcept;

}  // namespace momentree::detail
