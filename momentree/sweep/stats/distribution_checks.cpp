#include <momentree/sweep/stats/distribution_checks.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include <momentree/base/error.hpp>
#include <momentree/sweep/stats/special_functions.hpp>

namespace momentree::sweep {
namespace {

void expect(bool right, const char* problem, const char* hint) {
  if (!right) throw_error({problem, "", hint});
}
void expect_finite(const char* kind, std::initializer_list<double> numbers) {
  for (const double number : numbers)
    if (!std::isfinite(number)) throw_error({std::string(kind) + " distribution has a number that is not finite", "", ""});
}
bool spans(double from, double to) { return from < to && std::isfinite(to - from); }

}  // namespace

void check_distribution(const Uniform& d) {
  expect_finite("a uniform", {d.from, d.to});
  expect(spans(d.from, d.to), "a uniform distribution does not end above its start",
         "write the smaller value first; for a single value, write the value alone");
}

void check_distribution(const Normal& d) {
  expect_finite("a normal", {d.mean, d.deviation});
  expect(d.deviation > 0, "the deviation of a normal distribution is not positive", "for a single value, write the value alone");
  if (!d.within) return;
  expect(d.within->lowest < d.within->highest, "the limits of a normal distribution are not in ascending order",
         "write the smaller limit first");
  const double low = (d.within->lowest - d.mean) / d.deviation, high = (d.within->highest - d.mean) / d.deviation;
  const double share = low > 0 ? normal_cdf(-low) - normal_cdf(-high) : normal_cdf(high) - normal_cdf(low);
  expect(share > 1e-300, "a normal distribution has no values between its limits",
         "its limits are more than 37 deviations from its mean, or too close together");
}

void check_distribution(const Lognormal& d) {
  expect_finite("a lognormal", {d.mean, d.deviation});
  expect(d.deviation > 0, "the deviation of a lognormal distribution is not positive", "");
  expect(std::abs(d.mean) + 9 * d.deviation < 700, "a lognormal distribution has values outside the range of numbers",
         "its mean and deviation are those of the natural logarithm of the values");
}

void check_distribution(const Exponential& d) {
  expect_finite("an exponential", {d.mean});
  expect(d.mean > 0, "the mean of an exponential distribution is not positive", "");
}

void check_distribution(const Weibull& d) {
  expect_finite("a Weibull", {d.scale, d.shape});
  expect(d.scale > 0 && d.shape > 0, "the scale or the shape of a Weibull distribution is not positive", "");
  expect(d.shape >= 0.05, "the shape of a Weibull distribution is below 0.05", "common shapes are between 0.5 and 5");
}

void check_distribution(const Triangular& d) {
  expect_finite("a triangular", {d.least, d.mode, d.greatest});
  expect(spans(d.least, d.greatest) && d.least <= d.mode && d.mode <= d.greatest,
         "the least, most likely and greatest values of a triangular distribution are not in ascending order", "");
}

void check_distribution(const Beta& d) {
  expect_finite("a beta", {d.a, d.b, d.within.lowest, d.within.highest});
  expect(std::min(d.a, d.b) >= 1e-3 && std::max(d.a, d.b) <= 1e6, "a shape of a beta distribution is not between 0.001 and 1e6",
         "common shapes are between 0.5 and 10");
  expect(spans(d.within.lowest, d.within.highest), "the limits of a beta distribution are not in ascending order",
         "write the smaller limit first");
}

void check_distribution(const Choice& d) {
  expect(!d.weights.empty(), "a choice has no weights", "give one weight per value");
  double sum = 0;
  for (const double weight : d.weights) {
    expect(weight >= 0 && std::isfinite(weight), "a weight of a choice is negative or not finite", "");
    sum += weight;
  }
  expect(sum > 0 && std::isfinite(sum), "the weights of a choice do not have a positive sum", "");
}

}  // namespace momentree::sweep
