#include <momentree/contact/linear.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace momentree::contact {

namespace {

std::ptrdiff_t signed_of(std::size_t i) { return static_cast<std::ptrdiff_t>(i); }

// Makes the largest element of each row 1.
void scale_rows(std::vector<double>& M, std::vector<double>& right) {
  const std::size_t n = right.size();
  for (std::size_t i = 0; i < n; ++i) {
    double most = 0;
    for (std::size_t j = 0; j < n; ++j) most = std::max(most, std::fabs(M[i * n + j]));
    if (!(most > 0)) continue;
    for (std::size_t j = 0; j < n; ++j) M[i * n + j] /= most;
    right[i] /= most;
  }
}

// Of rows that are scaled.
bool has_uneven_columns(const std::vector<double>& M, std::size_t n, double bound) {
  for (std::size_t j = 0; j < n; ++j) {
    double most = 0;
    for (std::size_t i = 0; i < n; ++i) most = std::max(most, std::fabs(M[i * n + j]));
    if (most > 0 && most <= 1 / bound) return true;
  }
  return false;
}

// Scales rows, and columns as well if their sizes are very different, until the largest element of each is near 1 (Ruiz). Returns
// the factors of the columns; none if they stay as they are.
std::vector<double> equilibrate(std::vector<double>& M, std::vector<double>& right) {
  constexpr int most_passes = 20;
  constexpr double uneven = 1e4;  // scaling changes which of two contradictory rows gives way: ordinary masses don't need it
  const std::size_t n = right.size();
  scale_rows(M, right);
  if (!has_uneven_columns(M, n, uneven)) return {};
  std::vector<double> factors(n, 1.0), of_row(n), of_column(n);
  for (int pass = 0; pass < most_passes; ++pass) {
    std::fill(of_row.begin(), of_row.end(), 0.0), std::fill(of_column.begin(), of_column.end(), 0.0);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        const double size = std::fabs(M[i * n + j]);
        of_row[i] = std::max(of_row[i], size), of_column[j] = std::max(of_column[j], size);
      }
    constexpr double bound = 4;
    bool even = true;
    for (std::vector<double>* most : {&of_row, &of_column})
      for (double& x : *most) {
        even = even && (!(x > 0) || (x > 1 / bound && x < bound));
        x = x > 0 ? 1 / std::sqrt(x) : 1;
      }
    if (even) break;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) M[i * n + j] *= of_row[i] * of_column[j];
      right[i] *= of_row[i], factors[i] *= of_column[i];
    }
  }
  scale_rows(M, right);
  return factors;
}

// Brings M into upper trapezoidal form; returns its rank.
std::size_t eliminate(std::vector<double>& M, std::vector<double>& right, std::vector<std::size_t>& column_of, double zero) {
  const std::size_t n = right.size();
  std::size_t rank = 0;
  for (; rank < n; ++rank) {
    std::size_t row = rank, column = rank;
    for (std::size_t i = rank; i < n; ++i)
      for (std::size_t j = rank; j < n; ++j)
        if (std::fabs(M[i * n + j]) > std::fabs(M[row * n + column])) row = i, column = j;
    const double pivot = M[row * n + column];
    if (!(std::fabs(pivot) > zero)) break;
    if (row != rank) {
      std::swap_ranges(M.begin() + signed_of(row * n), M.begin() + signed_of(row * n + n), M.begin() + signed_of(rank * n));
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
  return rank;
}

// Solves with the upper triangle of that rank, for the column of numbers x.
void back_substitute(const std::vector<double>& M, std::size_t n, std::size_t rank, double* x) {
  for (std::size_t i = rank; i-- > 0;) {
    double sum = x[i];
    for (std::size_t j = i + 1; j < rank; ++j) sum -= M[i * n + j] * x[j];
    x[i] = sum / M[i * n + i];
  }
}

// An orthonormal basis of the rows of [U F], divided by the factors of the columns, if there are any: by Gram and Schmidt, twice.
std::vector<double> row_space(const std::vector<double>& M, std::size_t n, std::size_t rank, const std::vector<double>& factors) {
  std::vector<double> rows(rank * n, 0.0);
  for (std::size_t k = rank; k-- > 0;) {  // the last ones are the shortest
    double* const own = rows.data() + k * n;
    for (std::size_t i = k; i < n; ++i) own[i] = M[k * n + i];
    for (std::size_t i = 0; i < factors.size(); ++i) own[i] /= factors[i];
    double size = 0;
    for (std::size_t i = 0; i < n; ++i) size = std::max(size, std::fabs(own[i]));
    for (std::size_t i = 0; i < n; ++i) own[i] /= size;
    for (int pass = 0; pass < 2; ++pass)
      for (std::size_t l = k + 1; l < rank; ++l) {
        const double* const other = rows.data() + l * n;
        double along = 0;
        for (std::size_t i = 0; i < n; ++i) along += own[i] * other[i];
        for (std::size_t i = 0; i < n; ++i) own[i] -= along * other[i];
      }
    double square = 0;
    for (std::size_t i = 0; i < n; ++i) square += own[i] * own[i];
    for (std::size_t i = 0; i < n; ++i) own[i] /= std::sqrt(square);
  }
  return rows;
}

// Leaves the part in a space with that basis.
void project(const std::vector<double>& rows, std::vector<double>& x) {
  const std::size_t n = x.size();
  const std::vector<double> from = x;
  std::fill(x.begin(), x.end(), 0.0);
  for (std::size_t k = 0; k < rows.size() / n; ++k) {
    const double* const own = rows.data() + k * n;
    double along = 0;
    for (std::size_t i = 0; i < n; ++i) along += from[i] * own[i];
    for (std::size_t i = 0; i < n; ++i) x[i] += along * own[i];
  }
}

// Unknowns that equations connect, by the number of one of them.
bool find_blocks(const std::vector<double>& M, std::size_t n, std::vector<std::size_t>& block_of) {
  block_of.assign(n, SIZE_MAX);
  std::vector<std::size_t> open;
  for (std::size_t first = 0; first < n; ++first) {
    if (block_of[first] != SIZE_MAX) continue;
    open.push_back(first), block_of[first] = first;
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      for (std::size_t j = 0; j < n; ++j)
        if (block_of[j] == SIZE_MAX && (M[i * n + j] != 0 || M[j * n + i] != 0)) block_of[j] = first, open.push_back(j);
    }
  }
  return std::any_of(block_of.begin(), block_of.end(), [](std::size_t block) { return block != 0; });
}

bool solve_whole(std::vector<double>& M, std::vector<double>& right, std::vector<std::size_t>& column_of, double zero,
                 std::vector<double>& rows) {
  const std::size_t n = right.size();
  column_of.resize(n);
  for (std::size_t i = 0; i < n; ++i) column_of[i] = i;
  const std::vector<double> by_column = equilibrate(M, right);
  const std::size_t rank = eliminate(M, right, column_of, zero);
  back_substitute(M, n, rank, right.data());
  for (std::size_t i = rank; i < n; ++i) right[i] = 0;
  std::vector<double> factors(by_column.size());
  for (std::size_t i = 0; i < factors.size(); ++i) factors[i] = by_column[column_of[i]];
  for (std::size_t i = 0; i < std::min(rank, factors.size()); ++i) right[i] *= factors[i];
  rows.clear();
  if (rank < n) {
    const std::vector<double> found = row_space(M, n, rank, factors);
    project(found, right);
    rows.resize(found.size());
    for (std::size_t i = 0; i < found.size(); ++i) rows[i / n * n + column_of[i % n]] = found[i];
  }
  for (const double x : right)
    if (!std::isfinite(x)) return false;
  for (std::size_t i = 0; i < n; ++i)  // back to the order of the unknowns
    while (column_of[i] != i) {
      const std::size_t other = column_of[i];
      std::swap(right[i], right[other]);
      std::swap(column_of[i], column_of[other]);
    }
  return true;
}

}  // namespace

bool solve_linear(std::vector<double>& M, std::vector<double>& right, std::vector<std::size_t>& column_of, double zero,
                  std::vector<double>* rows) {
  const std::size_t n = right.size();
  std::vector<std::size_t> block_of;
  std::vector<double> own_rows;
  if (!find_blocks(M, n, block_of)) return solve_whole(M, right, column_of, zero, rows != nullptr ? *rows : own_rows);
  std::vector<double> block, own_right;
  std::vector<std::size_t> own;
  bool redundant = false;
  if (rows != nullptr) rows->clear();
  for (std::size_t first = 0; first < n; ++first) {
    if (block_of[first] != first) continue;
    own.clear(), block.clear(), own_right.clear();
    for (std::size_t i = first; i < n; ++i)
      if (block_of[i] == first) own.push_back(i), own_right.push_back(right[i]);
    for (const std::size_t i : own)
      for (const std::size_t j : own) block.push_back(M[i * n + j]);
    if (!solve_whole(block, own_right, column_of, zero, own_rows)) return false;
    for (std::size_t i = 0; i < own.size(); ++i) right[own[i]] = own_right[i];
    if (rows == nullptr) continue;
    redundant = redundant || !own_rows.empty();
    if (own_rows.empty()) {  // all rows of the identity
      own_rows.assign(own.size() * own.size(), 0.0);
      for (std::size_t i = 0; i < own.size(); ++i) own_rows[i * own.size() + i] = 1;
    }
    for (std::size_t k = 0; k < own_rows.size(); k += own.size()) {
      rows->resize(rows->size() + n, 0.0);
      for (std::size_t i = 0; i < own.size(); ++i) (*rows)[rows->size() - n + own[i]] = own_rows[k + i];
    }
  }
  if (rows != nullptr && !redundant) rows->clear();
  return true;
}

}  // namespace momentree::contact
