#pragma once
// Interface to code that was generated for one topology, by generate/.
#include <functional>
#include <span>

namespace momentree {

class Tree;
enum class Variables : unsigned char;

/// Code for one topology with the results of evaluate_rates: reads q (nq numbers) and p (nv), writes v (nv), q̇ (nq) and ṗ (nv,
/// without joint forces), packed and in the units of State and Workspace. The arrays must not overlap.
using RatesFunction = void (*)(const double* q, const double* p, double* v, double* qdot, double* pdot) noexcept;

/// Code for one topology with the results of the passes in velocities: reads q (nq numbers), u and joint forces tau (nv; s̈ for a
/// prescribed motion), writes q̇ (nq) and u̇ (nv). The arrays must not overlap.
using VelocityRatesFunction = void (*)(const double* q, const double* u, const double* tau, double* qdot, double* udot) noexcept;

/// Inputs and outputs of code for closed loops besides coordinates and rates.
struct LoopCalls {
  const double* least_pivots;  ///< by chosen row: a row whose pivot is not larger is left out
  double* lambda;              ///< written: the multipliers, by chosen row
  double* effort;  ///< written: along the joints of Tree::driven_joints(), in their order, all that is not a constraint
  /// Forces in a loop joint, and the rows of its single DoFs that are not expressions. `loop`: its place in Tree::loops();
  /// `place`: the numbers of its LoopPlace. Writes `answers` numbers: force and torque on the child about its frame, world axes;
  /// then of each row F, T, drift and softness.
  void (*joint)(const LoopCalls* calls, int loop, const double* place, int answers, double* answer) noexcept;
};

/// The number of answers about a loop joint with so many rows.
constexpr int loop_answers(int rows) { return 6 + 8 * rows; }

/// Code for one topology with closed loops or couplings and one choice of independent rows, in velocities. As
/// VelocityRatesFunction; behind the nv joint forces, tau has the accelerations of the prescribed motions of loop joints, in the
/// order of their rows.
using LoopRatesFunction = void (*)(const double* q, const double* u, const double* tau, const LoopCalls* calls, double* qdot,
                                   double* udot) noexcept;

/// Code for one topology, for either variables of a state; null: the kernels run.
struct GeneratedRates {
  RatesFunction momenta = nullptr;
  VelocityRatesFunction velocities = nullptr;
  LoopRatesFunction loops = nullptr;  ///< with closed loops
  std::span<const int> rows{};        ///< the chosen rows of `loops`, which must live as long as the code
  GeneratedRates() = default;
  GeneratedRates(RatesFunction of_momenta, VelocityRatesFunction of_velocities = nullptr)  // NOLINT(google-explicit-constructor)
      : momenta(of_momenta), velocities(of_velocities) {}
};

/// Returns the code for the tree's present topology and for states in these variables, or null to run the kernels. `rows`: with
/// closed loops, the rows that are chosen as independent at the present state, in ascending order; otherwise empty. Called
/// between steps, after every change, and where other rows are chosen; may allocate, take time, and throw: it is then asked
/// again.
using RatesProvider = std::function<GeneratedRates(const Tree&, Variables, std::span<const int> rows)>;

/// True if stages of steps use evaluate_rates. With forces on bodies, user functions or prescribed motions they need more results
/// than the rates, and generated code is not used.
bool stages_take_rates(const Tree& tree) noexcept;
/// True if stages of steps use generated code with closed loops: in velocities, without forces on bodies and user functions.
bool stages_take_loop_rates(const Tree& tree, Variables variables) noexcept;

}  // namespace momentree
