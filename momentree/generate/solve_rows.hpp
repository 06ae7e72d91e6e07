#pragma once
// The rows of closed loops in code for one mechanism.

namespace momentree {

/// A row whose pivot is too small depends on the others: it is left out.
[[maybe_unused]] inline double inverse_pivot(double pivot, double least) { return pivot > least ? 1 / pivot : 0.0; }

/// Solves A x = b for n rows by a factorisation L D L^T, in place. A has of each row the elements from column begin[row] to the
/// diagonal; that of column j is at A[row[row] + j].
[[maybe_unused]] inline void solve_rows(int n, const int* begin, const int* row, const double* least, double* A, const double* b,
                                        double* x) {
  for (int i = 0; i < n; ++i) {
    double* const w = A + row[i];
    for (int j = begin[i]; j < i; ++j)
      for (int k = begin[i] > begin[j] ? begin[i] : begin[j]; k < j; ++k) w[j] -= w[k] * A[row[j] + k];
    double pivot = w[i], sum = b[i];
    for (int j = begin[i]; j < i; ++j) {
      const double l = w[j] * A[row[j] + j];
      pivot -= w[j] * l;
      w[j] = l;
      sum -= l * x[j];
    }
    w[i] = inverse_pivot(pivot, least[i]);
    x[i] = sum;
  }
  for (int i = 0; i < n; ++i) x[i] *= A[row[i] + i];
  for (int i = n; i-- > 0;)
    for (int j = begin[i]; j < i; ++j) x[j] -= A[row[i] + j] * x[i];
}

}  // namespace momentree
