#include <algorithm>
#include <cmath>

#include <momentree/sweep/stats/estimates.hpp>

namespace momentree::sweep {
namespace {

// 1, 2 or 5 times a power of ten.
struct RoundWidth {
  int digit, exponent;
  double times(double count) const {
    const double power = std::pow(10.0, std::abs(exponent));
    return exponent < 0 ? count * digit / power : count * digit * power;
  }
  RoundWidth next() const {
    return digit == 1 ? RoundWidth{2, exponent} : digit == 2 ? RoundWidth{5, exponent} : RoundWidth{1, exponent + 1};
  }
};

RoundWidth at_least(double width) {
  RoundWidth round{1, static_cast<int>(std::floor(std::log10(width))) - 1};
  while (round.times(1) < width * (1 - 1e-12)) round = round.next();
  return round;
}

std::vector<double> edges_of(std::span<const double> sorted, std::size_t most) {
  const double low = sorted.front(), high = sorted.back(), range = high - low, size = std::max(std::abs(low), std::abs(high));
  if (size > 1e300) return {low, high};
  if (range <= 1e-9 * size || size < 1e-290) {  // a constant, perhaps with rounding errors
    const double margin = size > 0 ? 0.05 * size : 0.5;
    return {low - margin, high + margin};
  }
  const double n = static_cast<double>(sorted.size()), limit = static_cast<double>(std::max<std::size_t>(most, 2));
  const double middle = quantile(sorted, 0.75) - quantile(sorted, 0.25);
  const double wanted = middle > 0 ? 2 * middle / std::cbrt(n) : range / (std::log2(n) + 1);
  RoundWidth width = at_least(std::max(0.7 * wanted, range / limit));
  const auto first = [&] { return std::floor(low / width.times(1) * (1 + 1e-15)); };
  const auto last = [&] { return std::ceil(high / width.times(1)); };
  while (last() - first() > limit) width = width.next();
  std::vector<double> edges;
  for (double i = first(); edges.size() < 2 || edges.back() < high; ++i) edges.push_back(width.times(i));
  while (edges.size() > 2 && edges[1] <= low) edges.erase(edges.begin());
  if (edges.front() > low) edges.front() = low;
  return edges;
}

}  // namespace

Histogram histogram(std::span<const double> sorted, std::size_t most) {
  Histogram result;
  if (sorted.empty()) return result;
  result.edges = edges_of(sorted, most);
  auto from = sorted.begin();
  for (std::size_t i = 1; i + 1 < result.edges.size(); ++i) {
    const auto to = std::lower_bound(from, sorted.end(), result.edges[i]);
    result.counts.push_back(static_cast<std::uint64_t>(to - from));
    from = to;
  }
  result.counts.push_back(static_cast<std::uint64_t>(sorted.end() - from));
  return result;
}

}  // namespace momentree::sweep
