#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>

#include <momentree/sweep/stats/distribution.hpp>
#include <momentree/sweep/stats/special_functions.hpp>

namespace momentree::sweep {
namespace {

struct TwoMoments {
  double mean, deviation;
};

// Of the standard normal distribution between two limits, by Gauss–Legendre quadrature with 8 points on 128 intervals: the closed
// form cancels for narrow limits and far from the mean.
TwoMoments truncated_moments(double low, double high) {
  const double nearest = low > 0 ? low : high < 0 ? high : 0, reach = 40 / std::max(1.0, std::abs(nearest));
  const double from = std::max(low, nearest - reach), to = std::min(high, nearest + reach);
  constexpr std::array<double, 4> nodes{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr std::array<double, 4> weights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const auto integral = [&](auto&& f) {  // f of the distance from `nearest`, weighted with the density
    double sum = 0;
    for (int panel = 0; panel < 128; ++panel)
      for (int node = 0; node < 8; ++node) {
        const auto at = static_cast<std::size_t>(node / 2);
        const double t = (panel + 0.5 + (node % 2 ? 0.5 : -0.5) * nodes[at]) / 128;
        const double z = (from - nearest) + t * (to - from);
        sum += weights[at] * f(z) * std::exp(-z * (0.5 * z + nearest));
      }
    return sum;
  };
  const double mass = integral([](double) { return 1; });
  const double mean = integral([](double z) { return z; }) / mass;
  const double variance = integral([&](double z) { return (z - mean) * (z - mean); }) / mass;
  return {nearest + mean, std::sqrt(variance)};
}

TwoMoments moments_of(const Uniform& d) { return {d.from + (d.to - d.from) / 2, (d.to - d.from) / std::sqrt(12.0)}; }
TwoMoments moments_of(const Normal& d) {
  if (!d.within) return {d.mean, d.deviation};
  const auto [mean, deviation] =
      truncated_moments((d.within->lowest - d.mean) / d.deviation, (d.within->highest - d.mean) / d.deviation);
  return {d.mean + d.deviation * mean, d.deviation * deviation};
}
TwoMoments moments_of(const Lognormal& d) {
  const double square = d.deviation * d.deviation, mean = std::exp(d.mean + square / 2);
  return {mean, mean * std::sqrt(std::expm1(square))};
}
TwoMoments moments_of(const Exponential& d) { return {d.mean, d.mean}; }
TwoMoments moments_of(const Weibull& d) {
  const double mean = d.scale * std::tgamma(1 + 1 / d.shape);
  return {mean, mean * std::sqrt(gamma_variance(1 / d.shape))};
}
TwoMoments moments_of(const Triangular& d) {
  const double width = d.greatest - d.least, mode = (d.mode - d.least) / width;
  return {d.least + width * ((1 + mode) / 3), width * std::sqrt((1 - mode + mode * mode) / 18)};
}
TwoMoments moments_of(const Beta& d) {
  const double n = d.a + d.b, width = d.within.highest - d.within.lowest;
  return {d.within.lowest + width * (d.a / n), width * std::sqrt(d.a * d.b / (n + 1)) / n};
}
TwoMoments moments_of(const Choice& d) {
  double sum = 0, mean = 0, square = 0;
  for (const double weight : d.weights) sum += weight;
  for (std::size_t i = 0; i < d.weights.size(); ++i) mean += static_cast<double>(i) * (d.weights[i] / sum);
  for (std::size_t i = 0; i < d.weights.size(); ++i) {
    const double off = static_cast<double>(i) - mean;
    square += off * off * (d.weights[i] / sum);
  }
  return {mean, std::sqrt(square)};
}

std::string short_text(double number) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return {buffer.data(), end};
}
std::string range_text(double from, double to) { return short_text(from) + " to " + short_text(to); }
std::string normal_text(double mean, double deviation) { return short_text(mean) + " ± " + short_text(deviation); }

std::string text_of(const Uniform& d) { return "uniform " + range_text(d.from, d.to); }
std::string text_of(const Normal& d) {
  const std::string text = "normal " + normal_text(d.mean, d.deviation);
  return d.within ? text + " within " + range_text(d.within->lowest, d.within->highest) : text;
}
std::string text_of(const Lognormal& d) { return "lognormal, logarithm " + normal_text(d.mean, d.deviation); }
std::string text_of(const Exponential& d) { return "exponential, mean " + short_text(d.mean); }
std::string text_of(const Weibull& d) { return "Weibull, scale " + short_text(d.scale) + ", shape " + short_text(d.shape); }
std::string text_of(const Triangular& d) {
  return "triangular " + range_text(d.least, d.greatest) + ", most likely " + short_text(d.mode);
}
std::string text_of(const Beta& d) {
  return "beta " + short_text(d.a) + ", " + short_text(d.b) + " within " + range_text(d.within.lowest, d.within.highest);
}
std::string text_of(const Choice& d) {
  std::string text = "choice with weights ";
  for (std::size_t i = 0; i < d.weights.size(); ++i) text += (i ? ", " : "") + short_text(d.weights[i]);
  return text;
}

}  // namespace

double Distribution::mean() const {
  return std::visit([](const auto& d) { return moments_of(d).mean; }, kind_);
}
double Distribution::deviation() const {
  return std::visit([](const auto& d) { return moments_of(d).deviation; }, kind_);
}
std::string Distribution::text() const {
  return std::visit([](const auto& d) { return text_of(d); }, kind_);
}

}  // namespace momentree::sweep
