#include <momentree/sweep/stats/estimates.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <momentree/base/check.hpp>

namespace momentree::sweep {
namespace {

struct Pair {
  double x, y;
};

std::vector<Pair> finite_pairs(std::span<const double> x, std::span<const double> y) {
  MT_REQUIRE(x.size() == y.size(), "as many values of one column as of the other");
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i])) pairs.push_back({x[i], y[i]});
  return pairs;
}

// Ranks from 0, of equal values their average; minus the average of all ranks.
std::vector<double> centred_ranks(const std::vector<Pair>& pairs, double Pair::*side) {
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return pairs[a].*side < pairs[b].*side; });
  std::vector<double> ranks(pairs.size());
  for (std::size_t i = 0, end = 0; i < order.size(); i = end) {
    while (end < order.size() && pairs[order[end]].*side == pairs[order[i]].*side) ++end;
    const double rank = 0.5 * (static_cast<double>(i) + static_cast<double>(end) - static_cast<double>(order.size()));
    for (std::size_t j = i; j < end; ++j) ranks[order[j]] = rank;
  }
  return ranks;
}

double inner_product(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

}  // namespace

std::vector<double> sorted(std::span<const double> values) {
  std::vector<double> finite;
  for (const double value : values)
    if (std::isfinite(value)) finite.push_back(value);
  std::sort(finite.begin(), finite.end());
  return finite;
}

double quantile(std::span<const double> sorted, double share) {
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  if (below + 1 >= sorted.size()) return sorted.back();
  const double t = place - static_cast<double>(below);
  const double value = (1 - t) * sorted[below] + t * sorted[below + 1];
  return std::clamp(value, sorted[below], sorted[below + 1]);
}

std::optional<double> rank_correlation(std::span<const double> x, std::span<const double> y) {
  const std::vector<Pair> pairs = finite_pairs(x, y);
  if (pairs.size() < 3) return std::nullopt;
  const std::vector<double> a = centred_ranks(pairs, &Pair::x), b = centred_ranks(pairs, &Pair::y);
  const double aa = inner_product(a, a), bb = inner_product(b, b);
  if (aa == 0 || bb == 0) return std::nullopt;
  return std::clamp(inner_product(a, b) / std::sqrt(aa) / std::sqrt(bb), -1.0, 1.0);
}

std::optional<double> sobol_index(std::span<const double> x, std::span<const double> y) {
  std::vector<Pair> pairs = finite_pairs(x, y);
  if (pairs.size() < 10) return std::nullopt;
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.x < b.x; });
  const double n = static_cast<double>(pairs.size());
  double scale = 0, mean = 0, total = 0;
  for (const Pair& pair : pairs) scale = std::max(scale, std::abs(pair.y));
  if (scale == 0) return std::nullopt;
  for (Pair& pair : pairs) mean += (pair.y /= scale);  // so that squares stay within the range of numbers
  mean /= n;
  for (const Pair& pair : pairs) total += (pair.y - mean) * (pair.y - mean);
  if (total <= n * 1e-28) return std::nullopt;
  // Bins end where x changes, so that equal values are in one bin.
  const double bins = std::clamp(std::floor(std::sqrt(n)), 2.0, 64.0);
  double between = 0, count = 0;
  for (std::size_t i = 0, end = 0; i < pairs.size(); i = end) {
    double sum = 0;
    while (end < pairs.size() && (static_cast<double>(end - i) < n / bins || pairs[end].x == pairs[end - 1].x))
      sum += pairs[end++].y - mean;
    between += sum * sum / static_cast<double>(end - i);
    ++count;
  }
  if (count < 2) return std::nullopt;
  // Means of k bins of pure noise have k - 1 times the variance within bins as their sum of squares.
  const double within = n > count ? std::max(0.0, total - between) / (n - count) : 0;
  return std::clamp((between - (count - 1) * within) / total, 0.0, 1.0);
}

Interval wilson_interval(std::uint64_t successes, std::uint64_t trials) {
  if (trials == 0) return {0, 1};
  MT_REQUIRE(successes <= trials, "not more successes than trials");
  constexpr double z = 1.959963984540054;
  const double n = static_cast<double>(trials), p = static_cast<double>(successes) / n;
  const double middle = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n);
  return {successes == 0 ? 0 : std::max(0.0, middle - half), successes == trials ? 1 : std::min(1.0, middle + half)};
}

}  // namespace momentree::sweep
