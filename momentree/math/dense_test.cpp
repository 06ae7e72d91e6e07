#include <momentree/math/dense.hpp>

#include <cmath>
#include <random>

#include <doctest/doctest.h>

using namespace momentree;

namespace {

DenseMatrix random_matrix(int rows, int columns, std::mt19937& random) {
  DenseMatrix A(rows, columns);
  for (double& each : A.numbers) each = std::uniform_real_distribution<double>(-1, 1)(random);
  return A;
}
DenseMatrix transposed(const DenseMatrix& A) {
  DenseMatrix T(A.columns, A.rows);
  for (int i = 0; i < A.rows; ++i)
    for (int j = 0; j < A.columns; ++j) T(j, i) = A(i, j);
  return T;
}
double largest(const std::vector<double>& x) {
  double most = 0;
  for (const double each : x) most = std::max(most, std::fabs(each));
  return most;
}

}  // namespace

TEST_CASE("least squares: what is left is perpendicular to all columns, also where these depend on each other") {
  std::mt19937 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    const int rows = 1 + static_cast<int>(random() % 9), columns = 1 + static_cast<int>(random() % 9);
    const int rank = 1 + static_cast<int>(random() % 9);
    const DenseMatrix A = trial % 2 == 0 ? random_matrix(rows, columns, random)
                                         : random_matrix(rows, rank, random) * random_matrix(rank, columns, random);
    const std::vector<double> b = random_matrix(rows, 1, random).numbers, x = least_squares(A, b);
    std::vector<double> left = A * x;
    for (std::size_t i = 0; i < left.size(); ++i) left[i] -= b[i];
    CAPTURE(trial);
    CHECK(largest(transposed(A) * left) < 1e-11 * (1 + largest(x)));
  }
}

TEST_CASE("eigenvectors of symmetric matrices, and their Cholesky factors") {
  std::mt19937 random(8);
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 1 + static_cast<int>(random() % 12);
    const DenseMatrix half = random_matrix(n, n, random), A = half * transposed(half);
    const SymmetricEigen eigen = symmetric_eigen(A);
    DenseMatrix scaled = eigen.vectors;
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) scaled(i, k) *= eigen.values[static_cast<std::size_t>(k)];
    const DenseMatrix again = scaled * transposed(eigen.vectors), unit = transposed(eigen.vectors) * eigen.vectors;
    const DenseMatrix L = cholesky(A), product = L * transposed(L);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        CHECK(again(i, j) == doctest::Approx(A(i, j)).epsilon(1e-12));
        CHECK(std::fabs(unit(i, j) - (i == j ? 1 : 0)) < 1e-13);
        CHECK(product(i, j) == doctest::Approx(A(i, j)).epsilon(1e-12));
        if (j > i) CHECK(L(i, j) == 0);
      }
    for (int k = 1; k < n; ++k) CHECK(eigen.values[static_cast<std::size_t>(k)] >= eigen.values[static_cast<std::size_t>(k - 1)]);
  }
}
