#pragma once
// For the tests of this folder.
#include <algorithm>
#include <cmath>
#include <vector>

namespace momentree::sweep {

/// Kolmogorov–Smirnov statistic: the greatest distance between the draws and a continuous distribution, times √n. Above 1.95 once
/// in 1000 times for draws of that distribution.
template <class Cdf>
double distance_from(std::vector<double> draws, Cdf&& cdf) {
  std::sort(draws.begin(), draws.end());
  const double n = static_cast<double>(draws.size());
  double greatest = 0;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const double share = cdf(draws[i]), place = static_cast<double>(i);
    greatest = std::max({greatest, share - place / n, (place + 1) / n - share});
  }
  return greatest * std::sqrt(n);
}

inline double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

inline double correlation_of(const std::vector<double>& x, const std::vector<double>& y) {
  const double mx = mean_of(x), my = mean_of(y);
  double xy = 0, xx = 0, yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mx) * (y[i] - my);
    xx += (x[i] - mx) * (x[i] - mx);
    yy += (y[i] - my) * (y[i] - my);
  }
  return xy / std::sqrt(xx * yy);
}

}  // namespace momentree::sweep
