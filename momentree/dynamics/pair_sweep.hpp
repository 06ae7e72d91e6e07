#pragma once
#include <momentree/joint/link_constants.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

template <class T>
class Workspace;

/// Backward recursion over a pair of kernel runs (KernelRun::pair) at once; adds each branch's contribution to its parent.
/// `second` is the later of the two in the order. `Keep` as in the passes over single bodies.
template <bool Keep>
void pairs_inboard(const Tree& tree, const KernelRun& second, bool has_gravity, const double* p,
                   Workspace<double>& workspace) noexcept;
/// The forward recursion. `base`: the ground's velocity and gravity, the input of roots.
template <bool Keep>
void pairs_outboard(const Tree& tree, const KernelRun& first, bool has_gravity, const Outboard<double>& base, const double* p,
                    Workspace<double>& workspace) noexcept;

}  // namespace momentree
