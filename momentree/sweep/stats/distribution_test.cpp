#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/sweep/stats/distribution.hpp>
#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/sampling_test_support.hpp>

using namespace momentree;
using namespace momentree::sweep;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// At least one of each kind, and its extreme shapes.
std::vector<Distribution> continuous() {
  return {Uniform{8, 24},
          Uniform{-1e-9, 1e9},
          Normal{1, 0.1},
          Normal{-1e6, 1e3},
          Normal{1, 0.5, Interval{0.5, 2}},
          Normal{0, 1, Interval{3, infinite}},
          Normal{0, 1, Interval{-infinite, -5}},
          Normal{5, 1, Interval{-3, 4}},
          Lognormal{0, 0.5},
          Lognormal{3, 2},
          Exponential{3},
          Weibull{2, 1.5},
          Weibull{2, 0.4},
          Weibull{10, 30},
          Triangular{0, 3, 10},
          Triangular{-1, -1, 2},
          Triangular{-1, 2, 2},
          Beta{2, 3},
          Beta{0.5, 0.5, {-1, 1}},
          Beta{0.2, 4, {10, 20}},
          Beta{300, 500, {0, 5}},
          Beta{40, 0.7}};
}

// How far x is from being the quantile of u, in units of what is allowed: 5e-13 and the rounding of x, which is a double.
double off_inverse(const Distribution& distribution, double u, double x) {
  const double below = distribution.cdf(std::nextafter(x, -infinite)), above = distribution.cdf(std::nextafter(x, infinite));
  return std::abs(distribution.cdf(x) - u) / (5e-13 * u + 4 * (above - below));
}

std::string refusal(const Distribution::Kind& kind) {
  try {
    return "accepted: " + Distribution(kind).text();
  } catch (const Error& error) {
    CHECK(error.where.empty());
    return error.problem;
  }
}

}  // namespace

TEST_CASE("draws have the distribution, its mean and its deviation") {
  std::uint64_t stream = 0;
  for (const Distribution& distribution : continuous()) {
    CAPTURE(distribution.text());
    std::vector<double> draws;
    const bool slow = std::holds_alternative<Beta>(distribution.kind());
    const std::size_t n = slow ? 30'000 : 100'000;
    ++stream;
    for (std::size_t i = 0; i < n; ++i) draws.push_back(distribution.quantile(Random(11, stream).uniform(i)));
    CHECK(distance_from(draws, [&](double x) { return distribution.cdf(x); }) < 1.95);
    // Midpoints of shares that halve towards both ends give the moments far more accurately than draws.
    const double mean = distribution.mean();
    double sum = 0, square = 0, mass = 0;
    for (int block = 2; block < 52; ++block)
      for (int i = 0; i < 100; ++i) {
        const double width = std::ldexp(1.0 / 100, -block), t = std::ldexp(1.0, -block) + (i + 0.5) * width;
        for (const double u : {t, 1 - t}) {
          const double x = distribution.quantile(u) - mean;
          sum += width * x;
          square += width * x * x;
          mass += width;
        }
      }
    CHECK(mass == doctest::Approx(1).epsilon(1e-12));
    CHECK(std::abs(sum) < 1e-4 * distribution.deviation());
    CHECK(std::sqrt(square) == doctest::Approx(distribution.deviation()).epsilon(1e-3));
  }
}

TEST_CASE("the quantile is the inverse of the probability, and increases") {
  for (const Distribution& distribution : continuous()) {
    CAPTURE(distribution.text());
    double before = -infinite;
    for (int i = 1; i < 2000; ++i) {
      const double u = i / 2000.0, x = distribution.quantile(u);
      REQUIRE(x >= before);
      before = x;
      CHECK(off_inverse(distribution, u, x) < 1);
    }
    for (const double u : {0x1p-53, 0x1p-40, 1e-6, 1 - 1e-6, 1 - 0x1p-40, 1 - 0x1p-53}) {
      const double x = distribution.quantile(u);
      REQUIRE(std::isfinite(x));
      CHECK(off_inverse(distribution, u, x) < 1);
    }
    CHECK(distribution.quantile(0x1p-53) <= distribution.quantile(1e-6));
    CHECK(distribution.quantile(1 - 0x1p-53) >= distribution.quantile(1 - 1e-6));
    CHECK(distribution.cdf(-1e300) == 0);
    CHECK(distribution.cdf(1e300) == 1);
  }
}

TEST_CASE("values stay within their limits") {
  const Distribution beta{Beta{0.01, 0.01, {0.1, 0.3}}}, normal{Normal{0, 1, Interval{0.1, 0.3}}}, uniform{Uniform{0.1, 0.3}},
      triangular{Triangular{0.1, 0.1, 0.3}};
  for (std::uint64_t i = 0; i < 20'000; ++i)
    for (const Distribution* distribution : {&beta, &normal, &uniform, &triangular}) {
      const double u = i == 0 ? 0x1p-53 : i == 1 ? 1 - 0x1p-53 : Random(5, 0).uniform(i), x = distribution->quantile(u);
      REQUIRE((x >= 0.1 && x <= 0.3));
    }
}

TEST_CASE("a choice gives indices in proportion to their weights") {
  const Distribution choice{Choice{{0, 1, 0, 2, 5, 0}}};
  std::vector<int> counts(6, 0);
  for (std::uint64_t i = 0; i < 80'000; ++i) ++counts[static_cast<std::size_t>(choice.quantile(Random(1, 1).uniform(i)))];
  CHECK(counts[0] + counts[2] + counts[5] == 0);
  CHECK(std::abs(counts[1] - 10'000) < 350);
  CHECK(std::abs(counts[3] - 20'000) < 450);
  CHECK(std::abs(counts[4] - 50'000) < 500);
  CHECK(choice.quantile(0x1p-53) == 1);
  CHECK(choice.quantile(1 - 0x1p-53) == 4);
  CHECK(choice.quantile(0.125) == 1);
  CHECK(choice.quantile(0.1250001) == 3);
  CHECK(choice.cdf(-0.5) == 0);
  CHECK(choice.cdf(0.5) == 0);
  CHECK(choice.cdf(1) == 0.125);
  CHECK(choice.cdf(3.9) == 0.375);
  CHECK(choice.cdf(100) == 1);
  CHECK(choice.mean() == doctest::Approx((1 + 6 + 20) / 8.0).epsilon(1e-14));
  CHECK(choice.deviation() == doctest::Approx(std::sqrt((1 + 18 + 80) / 8.0 - 27 * 27 / 64.0)).epsilon(1e-14));
}

TEST_CASE("texts of distributions") {
  CHECK(Distribution(Uniform{8, 24}).text() == "uniform 8 to 24");
  CHECK(Distribution(Normal{1, 0.1}).text() == "normal 1 ± 0.1");
  CHECK(Distribution(Normal{1, 0.1, Interval{0.5, 2}}).text() == "normal 1 ± 0.1 within 0.5 to 2");
  CHECK(Distribution(Lognormal{0, 0.5}).text() == "lognormal, logarithm 0 ± 0.5");
  CHECK(Distribution(Exponential{3}).text() == "exponential, mean 3");
  CHECK(Distribution(Weibull{2, 1.5}).text() == "Weibull, scale 2, shape 1.5");
  CHECK(Distribution(Triangular{0, 3, 10}).text() == "triangular 0 to 10, most likely 3");
  CHECK(Distribution(Beta{2, 3, {0, 5}}).text() == "beta 2, 3 within 0 to 5");
  CHECK(Distribution(Choice{{1, 2.5}}).text() == "choice with weights 1, 2.5");
}

TEST_CASE("impossible distributions are refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Distribution::Kind& kind : std::vector<Distribution::Kind>{Uniform{1, 1},
                                                                        Uniform{2, 1},
                                                                        Uniform{-1e308, 1.7e308},
                                                                        Uniform{0, infinite},
                                                                        Uniform{nan, 1},
                                                                        Normal{0, 0},
                                                                        Normal{0, -1},
                                                                        Normal{nan, 1},
                                                                        Normal{0, infinite},
                                                                        Normal{0, 1, Interval{1, 1}},
                                                                        Normal{0, 1, Interval{nan, 1}},
                                                                        Normal{0, 1, Interval{40, 50}},
                                                                        Normal{0, 1, Interval{-infinite, -40}},
                                                                        Lognormal{0, 0},
                                                                        Lognormal{800, 1},
                                                                        Lognormal{0, 90},
                                                                        Exponential{0},
                                                                        Exponential{-1},
                                                                        Exponential{nan},
                                                                        Weibull{0, 1},
                                                                        Weibull{1, 0},
                                                                        Weibull{1, 0.01},
                                                                        Triangular{0, -1, 1},
                                                                        Triangular{0, 2, 1},
                                                                        Triangular{0, 0, 0},
                                                                        Beta{0, 1},
                                                                        Beta{1, 1e7},
                                                                        Beta{1, 1, {2, 2}},
                                                                        Beta{nan, 1},
                                                                        Choice{},
                                                                        Choice{{0, 0}},
                                                                        Choice{{1, -1}},
                                                                        Choice{{nan}},
                                                                        Choice{{infinite}}})
    CHECK(refusal(kind).find("accepted") == std::string::npos);
  CHECK(refusal(Uniform{2, 1}) == "a uniform distribution does not end above its start");
  CHECK(refusal(Normal{0, infinite}) == "a normal distribution has a number that is not finite");
}
