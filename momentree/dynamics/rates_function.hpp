#pragma once
// Where code that was generated for one topology comes in; generate/ makes it.
#include <functional>

namespace momentree {

class Tree;

/// Code for one topology that finds what evaluate_rates finds: of q (nq numbers) and p (nv), v (nv), q̇ (nq) and ṗ (nv, without
/// joint forces), packed and in the units of State and Work. Arrays must not overlap.
using RatesFunction = void (*)(const double* q, const double* p, double* v, double* qdot, double* pdot) noexcept;

/// Gives the code for what the tree is now, or null: the kernels themselves are then run. Asked between steps, after every
/// change; it may allocate and take its time, and must not throw.
using RatesProvider = std::function<RatesFunction(const Tree&)>;

/// Whether stages of steps take evaluate_rates: where forces act on bodies, functions act or motions are prescribed they need
/// more of the kernels than rates, and generated code is of no use.
bool stages_take_rates(const Tree& tree) noexcept;

}  // namespace momentree
