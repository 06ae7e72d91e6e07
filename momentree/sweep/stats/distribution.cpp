#include <momentree/sweep/stats/distribution.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/sweep/stats/distribution_checks.hpp>
#include <momentree/sweep/stats/special_functions.hpp>

namespace momentree::sweep {
namespace {

constexpr double largest_double = std::numeric_limits<double>::max();

double quantile_of(const Uniform& d, double u) { return std::clamp(d.from + u * (d.to - d.from), d.from, d.to); }
double quantile_of(const Normal& d, double u) {
  if (!d.within) return d.mean + d.deviation * normal_quantile(u);
  const double low = (d.within->lowest - d.mean) / d.deviation, high = (d.within->highest - d.mean) / d.deviation;
  // The tail that holds more is computed from its own end, so that no digits are lost.
  const double below = normal_cdf(low) + u * (normal_cdf(high) - normal_cdf(low));
  const double above = normal_cdf(-high) + (1 - u) * (normal_cdf(-low) - normal_cdf(-high));
  const double z = below < above ? normal_quantile(below) : -normal_quantile(above);
  return std::clamp(d.mean + d.deviation * z, d.within->lowest, d.within->highest);
}
double quantile_of(const Lognormal& d, double u) { return std::exp(d.mean + d.deviation * normal_quantile(u)); }
double quantile_of(const Exponential& d, double u) { return -d.mean * std::log1p(-u); }
double quantile_of(const Weibull& d, double u) { return d.scale * std::pow(-std::log1p(-u), 1 / d.shape); }
double quantile_of(const Triangular& d, double u) {
  const double width = d.greatest - d.least, rise = (d.mode - d.least) / width, fall = (d.greatest - d.mode) / width;
  double value = d.least + width * std::sqrt(u * rise);
  if (u >= rise) {  // from the nearer end of this side, so that no digits are lost
    const double root = std::sqrt((1 - u) * fall);
    value = u - rise < 1 - u ? d.mode + width * (fall * (u - rise) / (fall + root)) : d.greatest - width * root;
  }
  return std::clamp(value, d.least, d.greatest);
}
double quantile_of(const Beta& d, double u) {
  const auto [x, y] = beta_quantile(d.a, d.b, u);
  const double width = d.within.highest - d.within.lowest;
  const double value = x < y ? d.within.lowest + width * x : d.within.highest - width * y;
  return std::clamp(value, d.within.lowest, d.within.highest);
}

double cdf_of(const Uniform& d, double x) { return (x - d.from) / (d.to - d.from); }
double cdf_of(const Normal& d, double x) {
  const double z = (x - d.mean) / d.deviation;
  if (!d.within) return normal_cdf(z);
  if (x <= d.within->lowest) return 0;
  if (x >= d.within->highest) return 1;
  const double low = (d.within->lowest - d.mean) / d.deviation, high = (d.within->highest - d.mean) / d.deviation;
  if (low > 0) return (normal_cdf(-low) - normal_cdf(-z)) / (normal_cdf(-low) - normal_cdf(-high));
  return (normal_cdf(z) - normal_cdf(low)) / (normal_cdf(high) - normal_cdf(low));
}
double cdf_of(const Lognormal& d, double x) { return x <= 0 ? 0 : normal_cdf((std::log(x) - d.mean) / d.deviation); }
double cdf_of(const Exponential& d, double x) { return -std::expm1(-x / d.mean); }
double cdf_of(const Weibull& d, double x) { return x <= 0 ? 0 : -std::expm1(-std::pow(x / d.scale, d.shape)); }
double cdf_of(const Triangular& d, double x) {
  const double width = d.greatest - d.least, rise = (d.mode - d.least) / width, fall = (d.greatest - d.mode) / width;
  if (x <= d.least) return 0;
  if (x >= d.greatest) return 1;
  if (x < d.mode) return (x - d.least) / width * ((x - d.least) / width) / rise;
  const double past = (x - d.mode) / width;
  return rise + past * (2 - past / fall);
}
double cdf_of(const Beta& d, double x) {
  const double width = d.within.highest - d.within.lowest;
  return beta_cdf(d.a, d.b, (x - d.within.lowest) / width, (d.within.highest - x) / width);
}

}  // namespace

Distribution::Distribution(Kind kind) : kind_(std::move(kind)) {
  std::visit([](const auto& d) { check_distribution(d); }, kind_);
  if (const auto* choice = std::get_if<Choice>(&kind_)) {
    double sum = 0;
    for (const double weight : choice->weights) cumulative_.push_back(sum += weight);
    for (double& share : cumulative_) share /= sum;
  }
}

double Distribution::quantile(double u) const {
  if (std::holds_alternative<Choice>(kind_)) {
    const auto found = std::lower_bound(cumulative_.begin(), cumulative_.end(), u);
    return static_cast<double>(found - cumulative_.begin());
  }
  const double value = std::visit(
      [&](const auto& d) {
        if constexpr (std::is_same_v<std::decay_t<decltype(d)>, Choice>)
          return 0.0;
        else
          return quantile_of(d, u);
      },
      kind_);
  return std::clamp(value, -largest_double, largest_double);
}

double Distribution::cdf(double x) const {
  if (std::holds_alternative<Choice>(kind_)) {
    if (!(x >= 0)) return 0;
    const double last = static_cast<double>(cumulative_.size() - 1);
    return cumulative_[static_cast<std::size_t>(std::min(std::floor(x), last))];
  }
  const double share = std::visit(
      [&](const auto& d) {
        if constexpr (std::is_same_v<std::decay_t<decltype(d)>, Choice>)
          return 0.0;
        else
          return cdf_of(d, x);
      },
      kind_);
  return std::clamp(share, 0.0, 1.0);
}

}  // namespace momentree::sweep
