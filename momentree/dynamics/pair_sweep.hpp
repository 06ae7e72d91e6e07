#pragma once
#include <momentree/joint/link_constants.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

template <class T>
class Workspace;

/// The backward recursion over two stretches of the order that are of kinds alike (Segment::twin), both at once: what each
/// branch asks goes to its parent. `second` is that behind the other in the order. `Keep` as in the sweeps of single bodies.
template <bool Keep>
void pairs_inboard(const Tree& tree, const KernelRun& second, bool has_gravity, const double* p,
                   Workspace<double>& workspace) noexcept;
/// The forward recursion. `base`: what roots get.
template <bool Keep>
void pairs_outboard(const Tree& tree, const KernelRun& first, bool has_gravity, const Outboard<double>& base, const double* p,
                    Workspace<double>& workspace) noexcept;

}  // namespace momentree
