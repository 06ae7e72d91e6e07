#pragma once
// Interface to code that was generated for one topology, by generate/.
#include <functional>

namespace momentree {

class Tree;
enum class Variables : unsigned char;

/// Code for one topology with the results of evaluate_rates: reads q (nq numbers) and p (nv), writes v (nv), q̇ (nq) and ṗ (nv,
/// without joint forces), packed and in the units of State and Workspace. The arrays must not overlap.
using RatesFunction = void (*)(const double* q, const double* p, double* v, double* qdot, double* pdot) noexcept;

/// Code for one topology with the results of the passes in velocities: reads q (nq numbers), u and joint forces tau (nv; s̈ for a
/// prescribed motion), writes q̇ (nq) and u̇ (nv). The arrays must not overlap.
using VelocityRatesFunction = void (*)(const double* q, const double* u, const double* tau, double* qdot, double* udot) noexcept;

/// Code for one topology, for either variables of a state; null: the kernels run.
struct GeneratedRates {
  RatesFunction momenta = nullptr;
  VelocityRatesFunction velocities = nullptr;
  GeneratedRates() = default;
  GeneratedRates(RatesFunction of_momenta, VelocityRatesFunction of_velocities = nullptr)  // NOLINT(google-explicit-constructor)
      : momenta(of_momenta), velocities(of_velocities) {}
};

/// Returns the code for the tree's present topology and for states in these variables, or null to run the kernels. Called between
/// steps, after every change; may allocate and take time, must not throw.
using RatesProvider = std::function<GeneratedRates(const Tree&, Variables)>;

/// True if stages of steps use evaluate_rates. With forces on bodies, user functions or prescribed motions they need more results
/// than the rates, and generated code is not used.
bool stages_take_rates(const Tree& tree) noexcept;

}  // namespace momentree
