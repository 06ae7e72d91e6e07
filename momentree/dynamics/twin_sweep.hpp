#pragma once
#include <momentree/joint/link.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

template <class T>
class Work;

/// The backward recursion over two stretches of the order that are of kinds alike (Segment::twin), both at once: what each
/// branch asks goes to its parent. `second` is that behind the other in the order. `Keep` as in the sweeps of single bodies.
template <bool Keep>
void twins_inboard(const Tree& tree, const Segment& second, bool falls, const double* p, Work<double>& work) noexcept;
/// The forward recursion. `base`: what roots get.
template <bool Keep>
void twins_outboard(const Tree& tree, const Segment& first, bool falls, const Outboard<double>& base, const double* p,
                    Work<double>& work) noexcept;

}  // namespace momentree
