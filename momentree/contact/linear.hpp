#pragma once
// Small dense linear systems that may be singular.
#include <cstddef>
#include <vector>

namespace momentree::contact {

/// The least solution x of M x = right, in `right`, by elimination with complete pivoting; M is overwritten. Rows are scaled so
/// that their largest elements are 1, columns too if their sizes are very different; pivots below `zero` then count as zero.
/// Unknowns that no equation connects are solved for one after the other. `rows`: an orthonormal basis of the rows of M, one
/// after the other; empty if the solution is unique. Returns false if a number is not finite.
[[nodiscard]] bool solve_linear(std::vector<double>& M, std::vector<double>& right, std::vector<std::size_t>& column_of,
                                double zero, std::vector<double>* rows = nullptr);

}  // namespace momentree::contact
