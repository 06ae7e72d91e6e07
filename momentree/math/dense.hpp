#pragma once
// Dense linear algebra for set-up and analysis, not for steps: it allocates.
#include <vector>

namespace momentree {

/// Row-major.
struct DenseMatrix {
  int rows = 0, columns = 0;
  std::vector<double> numbers;

  DenseMatrix() = default;
  DenseMatrix(int rows_, int columns_)
      : rows(rows_), columns(columns_), numbers(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_)) {}
  double& operator()(int i, int j) {
    return numbers[static_cast<std::size_t>(i) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(j)];
  }
  double operator()(int i, int j) const {
    return numbers[static_cast<std::size_t>(i) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(j)];
  }
};
DenseMatrix operator*(const DenseMatrix& a, const DenseMatrix& b);
std::vector<double> operator*(const DenseMatrix& a, const std::vector<double>& x);

/// The x with the least |A x − b|, by Householder reflections with pivoted columns. Where columns depend on others, within
/// `tolerance` of the largest, their x is zero.
[[nodiscard]] std::vector<double> least_squares(DenseMatrix A, std::vector<double> b, double tolerance = 1e-13);

/// Eigenvalues of a symmetric matrix in ascending order, and the unit eigenvectors as columns, by Jacobi's rotations.
struct SymmetricEigen {
  std::vector<double> values;
  DenseMatrix vectors;
};
[[nodiscard]] SymmetricEigen symmetric_eigen(DenseMatrix A);

/// The lower triangle L of A = L Lᵀ, for a symmetric positive definite matrix.
[[nodiscard]] DenseMatrix cholesky(const DenseMatrix& A);

}  // namespace momentree
