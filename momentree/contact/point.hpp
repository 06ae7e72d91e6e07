#pragma once
// The law of a single contact point, solved exactly.
#include <momentree/contact/system.hpp>

namespace momentree::contact {

/// Finds r = (N, t1, t2) of one point with w = b + A r (A: 3×3, row by row). Returns false if none is found: where A is singular,
/// some are missed.
[[nodiscard]] bool solve_point(const double* A, const double* b, const PointLaw& law, double* r);

}  // namespace momentree::contact
