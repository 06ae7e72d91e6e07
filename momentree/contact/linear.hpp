#pragma once
// Small dense linear systems that may be singular.
#include <cstddef>
#include <vector>

namespace momentree::contact {

/// Which solution of a singular, consistent system.
enum class Solution : unsigned char {
  basic,  ///< unknowns without a pivot are zero
  least   ///< the one of least norm
};

/// Solves M x = right in place (x in `right`) by elimination with complete pivoting; M is overwritten. Rows are scaled
/// so that their largest elements are 1, columns too if their sizes are very different; pivots below `zero` then count as zero.
/// Unknowns that no equation connects are solved for one after the other. `rows`, with the least solution: an orthonormal basis
/// of the rows of M, one after the other; empty if the solution is unique. Returns false if a number is not finite.
[[nodiscard]] bool solve_linear(std::vector<double>& M, std::vector<double>& right, std::vector<std::size_t>& column_of,
                                Solution which = Solution::basic, double zero = 1e-12, std::vector<double>* rows = nullptr);

}  // namespace momentree::contact
