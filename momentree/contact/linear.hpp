#pragma once
// Small dense linear systems that may be singular.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace momentree::contact {

/// Solves M x = right in place (x in `right`) by elimination with complete pivoting; M is overwritten. Of a singular but
/// consistent system the solution in which the unknowns without a pivot are zero. Returns false if a number is not finite.
[[nodiscard]] inline bool solve_linear(std::vector<double>& M, std::vector<double>& right, std::vector<std::size_t>& column_of) {
  const std::size_t n = right.size();
  column_of.resize(n);
  for (std::size_t i = 0; i < n; ++i) column_of[i] = i;
  // Rows of very different sizes are of the same importance.
  for (std::size_t i = 0; i < n; ++i) {
    double most = 0;
    for (std::size_t j = 0; j < n; ++j) most = std::max(most, std::fabs(M[i * n + j]));
    if (!(most > 0)) continue;
    for (std::size_t j = 0; j < n; ++j) M[i * n + j] /= most;
    right[i] /= most;
  }
  constexpr double zero = 1e-12;  // pivots of redundant rows
  std::size_t rank = 0;
  for (; rank < n; ++rank) {
    std::size_t row = rank, column = rank;
    for (std::size_t i = rank; i < n; ++i)
      for (std::size_t j = rank; j < n; ++j)
        if (std::fabs(M[i * n + j]) > std::fabs(M[row * n + column])) row = i, column = j;
    const double pivot = M[row * n + column];
    if (!(std::fabs(pivot) > zero)) break;
    if (row != rank) {
      std::swap_ranges(M.begin() + static_cast<std::ptrdiff_t>(row * n), M.begin() + static_cast<std::ptrdiff_t>(row * n + n),
                       M.begin() + static_cast<std::ptrdiff_t>(rank * n));
      std::swap(right[row], right[rank]);
    }
    if (column != rank) {
      for (std::size_t i = 0; i < n; ++i) std::swap(M[i * n + column], M[i * n + rank]);
      std::swap(column_of[column], column_of[rank]);
    }
    for (std::size_t i = rank + 1; i < n; ++i) {
      const double factor = M[i * n + rank] / pivot;
      if (factor == 0) continue;
      for (std::size_t j = rank; j < n; ++j) M[i * n + j] -= factor * M[rank * n + j];
      right[i] -= factor * right[rank];
    }
  }
  for (std::size_t i = rank; i-- > 0;) {
    double sum = right[i];
    for (std::size_t j = i + 1; j < rank; ++j) sum -= M[i * n + j] * right[j];
    right[i] = sum / M[i * n + i];
    if (!std::isfinite(right[i])) return false;
  }
  for (std::size_t i = rank; i < n; ++i) right[i] = 0;
  // Back to the order of the unknowns.
  for (std::size_t i = 0; i < n; ++i)
    while (column_of[i] != i) {
      const std::size_t other = column_of[i];
      std::swap(right[i], right[other]);
      std::swap(column_of[i], column_of[other]);
    }
  return true;
}

}  // namespace momentree::contact
