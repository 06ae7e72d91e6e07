#include <momentree/contact/block_elimination.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <momentree/contact/indices.hpp>

namespace momentree::contact {

namespace {

// C −= A B, of sizes rows × inner and inner × columns. Told that they do not overlap, compilers use vector instructions.
template <class Rows, class Inner, class Columns>
void subtract(const double* __restrict A, const double* __restrict B, double* __restrict C, Rows rows, Inner inner,
              Columns columns) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k < inner; ++k)
      for (std::size_t j = 0; j < columns; ++j) C[i * columns + j] -= A[i * inner + k] * B[k * columns + j];
}
void subtract_product(const double* A, const double* B, double* C, std::size_t rows, std::size_t inner, std::size_t columns) {
  all_sized([&](auto m, auto l, auto n) { subtract(A, B, C, m, l, n); }, rows, inner, columns);
}

}  // namespace

void BlockElimination::clear(const std::vector<int>& sizes) {
  sizes_ = sizes;
  first_.resize(sizes.size() + 1), first_[0] = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) first_[i + 1] = first_[i] + at(sizes[i]);
  at_.assign(sizes.size() * sizes.size(), SIZE_MAX);
  if (neighbours_.size() < sizes.size()) neighbours_.resize(sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) neighbours_[i].clear();
}

void BlockElimination::connect(int one, int other) {
  if (one == other || at_[index(one, other)] != SIZE_MAX) return;
  at_[index(one, other)] = at_[index(other, one)] = 0;
  neighbours_[at(one)].push_back(other), neighbours_[at(other)].push_back(one);
}

// The block with the fewest unknowns in its neighbours comes next (Tinney & Walker 1967).
void BlockElimination::analyse() {
  const int n = static_cast<int>(sizes_.size());
  done_.assign(sizes_.size(), false);
  const auto unknowns_of = [&](int i) {
    int sum = 0;
    for (const int j : neighbours_[at(i)]) sum += sizes_[at(j)];
    return sum;
  };
  degree_.clear();
  for (int i = 0; i < n; ++i) degree_.push_back(unknowns_of(i));
  order_.clear();
  for (int k = 0; k < n; ++k) {
    int next = -1;
    for (int i = 0; i < n; ++i)
      if (!done_[at(i)] && (next < 0 || degree_[at(i)] < degree_[at(next)])) next = i;
    done_[at(next)] = true, order_.push_back(next);
    const std::vector<int>& around = neighbours_[at(next)];
    for (std::size_t i = 0; i < around.size(); ++i) {
      std::erase(neighbours_[at(around[i])], next);
      for (std::size_t j = 0; j < i; ++j) connect(around[i], around[j]);
    }
    for (const int i : around) degree_[at(i)] = unknowns_of(i);
  }
  std::size_t size = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (std::size_t& place = at_[index(i, j)]; i == j || place != SIZE_MAX)
        place = std::exchange(size, size + at(sizes_[at(i)]) * at(sizes_[at(j)]));
  values_.resize(size), pivots_.resize(first_.back());
}

void BlockElimination::reset() {
  std::fill(values_.begin(), values_.end(), 0.0);
  for (int i = 0; i < static_cast<int>(sizes_.size()); ++i)
    for (int k = 0; k < sizes_[at(i)]; ++k) block(i, i)[k * (sizes_[at(i)] + 1)] = 1;
}

// x becomes D⁻¹ x, with the factors of a block D of the diagonal.
void BlockElimination::solve_block(int own, double* x, std::size_t columns) const {
  const double* const D = values_.data() + at_[index(own, own)];
  const int* const pivots = pivots_.data() + first_[at(own)];
  const auto solve = [&](auto n, auto m) {
    for (std::size_t k = 0; k < n; ++k)
      if (at(pivots[k]) != k) std::swap_ranges(x + k * m, x + (k + 1) * m, x + at(pivots[k]) * m);
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t i = k + 1; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j) x[i * m + j] -= D[i * n + k] * x[k * m + j];
    for (std::size_t k = n; k-- > 0;) {
      for (std::size_t j = 0; j < m; ++j) x[k * m + j] *= D[k * n + k];  // it holds the inverse
      for (std::size_t i = 0; i < k; ++i)
        for (std::size_t j = 0; j < m; ++j) x[i * m + j] -= D[i * n + k] * x[k * m + j];
    }
  };
  all_sized(solve, at(sizes_[at(own)]), columns);
}

bool BlockElimination::factorise() {
  for (const int own : order_) {
    const std::size_t n = at(sizes_[at(own)]);
    double* const D = block(own, own);
    int* const pivots = pivots_.data() + first_[at(own)];
    for (std::size_t k = 0; k < n; ++k) {
      std::size_t largest = k;
      for (std::size_t i = k + 1; i < n; ++i)
        if (std::fabs(D[i * n + k]) > std::fabs(D[largest * n + k])) largest = i;
      pivots[k] = static_cast<int>(largest);
      if (largest != k) std::swap_ranges(D + k * n, D + (k + 1) * n, D + largest * n);
      if (!(std::fabs(D[k * n + k]) > 0) || !std::isfinite(D[k * n + k])) return false;
      D[k * n + k] = 1 / D[k * n + k];
      for (std::size_t i = k + 1; i < n; ++i) {
        const double factor = D[i * n + k] *= D[k * n + k];
        for (std::size_t j = k + 1; j < n; ++j) D[i * n + j] -= factor * D[k * n + j];
      }
    }
    for (const int j : neighbours_[at(own)]) solve_block(own, block(own, j), at(sizes_[at(j)]));
    for (const int i : neighbours_[at(own)])
      for (const int j : neighbours_[at(own)])
        subtract_product(block(i, own), block(own, j), block(i, j), at(sizes_[at(i)]), n, at(sizes_[at(j)]));
  }
  return true;
}

void BlockElimination::solve(double* x) const {
  const auto part = [&](int i) { return x + first_[at(i)]; };
  const auto of = [&](int i, int j) { return values_.data() + at_[index(i, j)]; };
  for (const int own : order_) {
    solve_block(own, part(own), 1);
    for (const int i : neighbours_[at(own)])
      subtract_product(of(i, own), part(own), part(i), at(sizes_[at(i)]), at(sizes_[at(own)]), 1);
  }
  for (std::size_t k = order_.size(); k-- > 0;) {
    const int own = order_[k];
    for (const int j : neighbours_[at(own)])
      subtract_product(of(own, j), part(j), part(own), at(sizes_[at(own)]), at(sizes_[at(j)]), 1);
  }
}

}  // namespace momentree::contact
