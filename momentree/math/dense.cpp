#include <momentree/math/dense.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

DenseMatrix operator*(const DenseMatrix& a, const DenseMatrix& b) {
  DenseMatrix product(a.rows, b.columns);
  for (int i = 0; i < a.rows; ++i)
    for (int k = 0; k < a.columns; ++k)
      for (int j = 0; j < b.columns; ++j) product(i, j) += a(i, k) * b(k, j);
  return product;
}

std::vector<double> operator*(const DenseMatrix& a, const std::vector<double>& x) {
  std::vector<double> product(at(a.rows));
  for (int i = 0; i < a.rows; ++i)
    for (int j = 0; j < a.columns; ++j) product[at(i)] += a(i, j) * x[at(j)];
  return product;
}

std::vector<double> least_squares(DenseMatrix A, std::vector<double> b, double tolerance) {
  std::vector<int> order(at(A.columns));
  std::iota(order.begin(), order.end(), 0);
  const auto square_below = [&](int k, int column) {
    double sum = 0;
    for (int i = k; i < A.rows; ++i) sum += A(i, column) * A(i, column);
    return sum;
  };
  int rank = 0;
  double largest = 0;
  for (const int last = std::min(A.rows, A.columns); rank < last; ++rank) {
    const int k = rank;
    int pivot = k;
    double square = -1;
    for (int j = k; j < A.columns; ++j)
      if (const double s = square_below(k, order[at(j)]); s > square) square = s, pivot = j;
    const double length = std::sqrt(square);
    largest = std::max(largest, length);
    if (!(length > tolerance * largest)) break;
    std::swap(order[at(k)], order[at(pivot)]);
    const int column = order[at(k)];
    const double alpha = A(k, column) > 0 ? -length : length;
    // The reflection that takes the column to (alpha, 0, …): its vector replaces the column below the diagonal.
    A(k, column) -= alpha;
    const double half = -alpha * A(k, column);  // half the square of the vector
    const auto reflect = [&](auto element) {
      double sum = 0;
      for (int i = k; i < A.rows; ++i) sum += A(i, column) * element(i);
      for (int i = k; i < A.rows; ++i) element(i) -= sum / half * A(i, column);
    };
    for (int j = k + 1; j < A.columns; ++j) reflect([&](int i) -> double& { return A(i, order[at(j)]); });
    reflect([&](int i) -> double& { return b[at(i)]; });
    A(k, column) = alpha;
  }
  std::vector<double> x(at(A.columns));
  for (int k = rank; k-- > 0;) {
    double sum = b[at(k)];
    for (int j = k + 1; j < rank; ++j) sum -= A(k, order[at(j)]) * x[at(order[at(j)])];
    x[at(order[at(k)])] = sum / A(k, order[at(k)]);
  }
  return x;
}

SymmetricEigen symmetric_eigen(DenseMatrix A) {
  const int n = A.rows;
  DenseMatrix V(n, n);
  for (int i = 0; i < n; ++i) V(i, i) = 1;
  for (int sweep = 0; sweep < 60; ++sweep) {
    double off = 0, on = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) (i == j ? on : off) += A(i, j) * A(i, j);
    if (!(off > 1e-32 * on)) break;
    for (int p = 0; p < n; ++p)
      for (int q = p + 1; q < n; ++q) {
        if (A(p, q) == 0) continue;
        const double theta = (A(q, q) - A(p, p)) / (2 * A(p, q));
        const double t = (theta >= 0 ? 1 : -1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < n; ++k) {
          const double x = A(k, p), y = A(k, q);
          A(k, p) = c * x - s * y, A(k, q) = s * x + c * y;
        }
        for (int k = 0; k < n; ++k) {
          const double x = A(p, k), y = A(q, k), v = V(k, p), w = V(k, q);
          A(p, k) = c * x - s * y, A(q, k) = s * x + c * y;
          V(k, p) = c * v - s * w, V(k, q) = s * v + c * w;
        }
      }
  }
  std::vector<int> order(at(n));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) { return A(i, i) < A(j, j); });
  SymmetricEigen eigen{std::vector<double>(at(n)), DenseMatrix(n, n)};
  for (int k = 0; k < n; ++k) {
    eigen.values[at(k)] = A(order[at(k)], order[at(k)]);
    for (int i = 0; i < n; ++i) eigen.vectors(i, k) = V(i, order[at(k)]);
  }
  return eigen;
}

DenseMatrix cholesky(const DenseMatrix& A) {
  DenseMatrix L(A.rows, A.rows);
  for (int i = 0; i < A.rows; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = A(i, j);
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = i == j ? std::sqrt(sum) : sum / L(j, j);
    }
  return L;
}

}  // namespace momentree
