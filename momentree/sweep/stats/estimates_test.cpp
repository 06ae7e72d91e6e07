#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/sweep/stats/estimates.hpp>
#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/special_functions.hpp>

using namespace momentree::sweep;

namespace {

const double missing = std::numeric_limits<double>::quiet_NaN();

std::vector<double> draws(std::uint64_t stream, std::size_t count) {
  std::vector<double> values;
  for (std::uint64_t i = 0; i < count; ++i) values.push_back(Random(6, stream).uniform(i));
  return values;
}

}  // namespace

TEST_CASE("quantiles are those of NumPy") {
  // np.quantile([3, 1, 4, 1, 5, 9, 2, 6], q)
  const auto values = sorted(std::vector<double>{3, 1, missing, 4, 1, 5, 9, INFINITY, 2, 6});
  CHECK(values.size() == 8);
  CHECK(quantile(values, 0) == 1);
  CHECK(quantile(values, 0.05) == doctest::Approx(1).epsilon(1e-15));
  CHECK(quantile(values, 0.25) == doctest::Approx(1.75).epsilon(1e-15));
  CHECK(quantile(values, 0.5) == doctest::Approx(3.5).epsilon(1e-15));
  CHECK(quantile(values, 0.9) == doctest::Approx(6.9).epsilon(1e-15));
  CHECK(quantile(values, 1) == 9);
  CHECK(quantile(std::vector<double>{7}, 0.3) == 7);
  CHECK(std::isnan(quantile({}, 0.5)));
}

TEST_CASE("histograms count every value in bins of equal, round width") {
  for (std::uint64_t number = 0; number < 3000; ++number) {
    const Random random(8, number);
    const double scale = std::pow(10, 20 * (random.uniform(0) - 0.5)),
                 shift = random.bits(1) % 3 ? scale * 5 * random.uniform(2) : 0;
    std::vector<double> values;
    for (std::uint64_t i = 0, n = 1 + random.bits(3) % 300; i < n; ++i) {
      const double z = normal_quantile(random.uniform(i + 4));
      values.push_back(shift + scale * (number % 4 == 0 ? std::exp(2 * z) : number % 4 == 1 ? std::floor(z) : z));
    }
    values = sorted(values);
    const Histogram result = histogram(values, 40);
    CAPTURE(number);
    REQUIRE(result.edges.size() == result.counts.size() + 1);
    REQUIRE(result.counts.size() <= 40);
    REQUIRE(std::accumulate(result.counts.begin(), result.counts.end(), std::uint64_t{0}) == values.size());
    REQUIRE(std::is_sorted(result.edges.begin(), result.edges.end()));
    REQUIRE(result.edges.front() <= values.front());
    REQUIRE(result.edges.back() >= values.back());
    const double width = result.edges[1] - result.edges[0];
    for (std::size_t i = 0; i < result.counts.size(); ++i) {
      REQUIRE(result.edges[i + 1] - result.edges[i] == doctest::Approx(width).epsilon(1e-6));
      const bool last = i + 1 == result.counts.size();
      const auto inside = std::count_if(values.begin(), values.end(), [&](double x) {
        return x >= result.edges[i] && (last ? x <= result.edges[i + 1] : x < result.edges[i + 1]);
      });
      REQUIRE(result.counts[i] == static_cast<std::uint64_t>(inside));
    }
  }
  const Histogram tenths = histogram(sorted(draws(1, 1000)));
  CHECK(tenths.edges == std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1});
  CHECK(histogram({}).counts.empty());
  CHECK(histogram(std::vector<double>{5, 5, 5}).counts == std::vector<std::uint64_t>{3});
  CHECK(histogram(std::vector<double>{0}).counts == std::vector<std::uint64_t>{1});
  const double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();
  for (const auto& extreme : {std::vector<double>{-huge, huge}, std::vector<double>{0, huge}, std::vector<double>{-tiny, tiny},
                              std::vector<double>{0, 1e-300}, std::vector<double>{-1, 0, 1e-9, 1e300}}) {
    const Histogram result = histogram(extreme);
    CHECK(std::accumulate(result.counts.begin(), result.counts.end(), std::uint64_t{0}) == extreme.size());
    for (const double edge : result.edges) CHECK(std::isfinite(edge));
  }
}

TEST_CASE("rank correlations, with ties and missing values") {
  // scipy.stats.spearmanr([1, 2, 2, 3, 5, 4], [2, 1, 4, 4, 4, 9]).statistic
  CHECK(*rank_correlation(std::vector<double>{1, 2, 2, missing, 3, 5, 4}, std::vector<double>{2, 1, 4, 0, 4, 4, 9}) ==
        doctest::Approx(0.6776452139970671).epsilon(1e-14));
  const auto x = draws(1, 1000), noise = draws(2, 1000);
  std::vector<double> rising, falling;
  for (const double value : x) rising.push_back(std::exp(9 * value));
  for (const double value : x) falling.push_back(-std::pow(value, 7));
  CHECK(*rank_correlation(x, rising) == doctest::Approx(1).epsilon(1e-14));
  CHECK(*rank_correlation(x, falling) == doctest::Approx(-1).epsilon(1e-14));
  CHECK(std::abs(*rank_correlation(x, noise)) < 0.11);
  CHECK(!rank_correlation(x, std::vector<double>(1000, 3.0)));
  CHECK(!rank_correlation(std::vector<double>{1, 2}, std::vector<double>{1, 2}));
  CHECK(!rank_correlation({}, {}));
}

TEST_CASE("first-order Sobol indices of the Ishigami function and of a sum") {
  constexpr std::size_t n = 20'000;
  const double pi = 3.14159265358979;
  std::vector<std::vector<double>> x{draws(1, n), draws(2, n), draws(3, n), draws(4, n)};
  std::vector<double> y, sum;
  for (std::size_t i = 0; i < n; ++i) {
    for (auto& column : x) column[i] = pi * (2 * column[i] - 1);
    y.push_back(std::sin(x[0][i]) + 7 * std::pow(std::sin(x[1][i]), 2) + 0.1 * std::pow(x[2][i], 4) * std::sin(x[0][i]));
    sum.push_back(1e8 + x[0][i] + 2 * x[1][i] + 3 * x[2][i]);
  }
  CHECK(*sobol_index(x[0], y) == doctest::Approx(0.3139).epsilon(0.05));  // closed forms: 0.3139, 0.4424, 0, 0
  CHECK(*sobol_index(x[1], y) == doctest::Approx(0.4424).epsilon(0.05));
  CHECK(*sobol_index(x[2], y) < 0.01);
  CHECK(*sobol_index(x[3], y) < 0.01);
  for (const std::size_t i : {0, 1, 2}) {
    const double share = static_cast<double>((i + 1) * (i + 1)) / 14;
    CHECK(*sobol_index(x[i], sum) == doctest::Approx(share).epsilon(0.06));
  }
}

TEST_CASE("Sobol indices of few worlds are not biased, and lists are bins by themselves") {
  double noise = 0, linear = 0;
  for (std::uint64_t repeat = 0; repeat < 200; ++repeat) {
    const auto a = draws(10 + 2 * repeat, 100), b = draws(11 + 2 * repeat, 100);
    noise += *sobol_index(a, b) / 200;
    std::vector<double> y;
    for (std::size_t i = 0; i < 100; ++i) y.push_back(a[i] + b[i]);
    linear += *sobol_index(a, y) / 200;
  }
  CHECK(noise < 0.06);  // the mean of what is cut off at 0
  CHECK(linear == doctest::Approx(0.5).epsilon(0.05));

  const auto a = draws(1, 9000), b = draws(2, 9000);
  std::vector<double> list, y;
  for (std::size_t i = 0; i < 9000; ++i) {
    list.push_back(std::floor(3 * a[i]));
    y.push_back((list[i] == 1 ? 1 : 0) + (b[i] < 0.5 ? 1 : 0));  // variances 2/9 and 1/4
  }
  CHECK(*sobol_index(list, y) == doctest::Approx(8.0 / 17).epsilon(0.05));
  CHECK(*sobol_index(list, list) == doctest::Approx(1).epsilon(1e-14));
  CHECK(!sobol_index(list, std::vector<double>(9000, 0.1)));
  CHECK(!sobol_index(std::vector<double>(9000, 0.1), list));
  CHECK(!sobol_index(std::vector<double>{1, 2, 3}, std::vector<double>{1, 2, 3}));
}

TEST_CASE("Wilson's interval") {
  // scipy.stats.binomtest(k, n).proportion_ci(method="wilson")
  struct Case {
    std::uint64_t successes, trials;
    double low, high;
  };
  for (const Case& c :
       {Case{0, 10, 0.0, 0.27753279986288926}, Case{3, 10, 0.10779126740630102, 0.6032218525388546},
        Case{10, 10, 0.7224672001371109, 1.0}, Case{1, 1, 0.20654931437723745, 1.0},
        Case{500, 1000, 0.4690696003681042, 0.5309303996318958}, Case{2, 1000000, 5.484723095960564e-07, 7.29295638857263e-06},
        Case{123456789, 1000000000, 0.1234364016192789, 0.12347717927367159}}) {
    const Interval found = wilson_interval(c.successes, c.trials);
    CHECK(found.lowest == doctest::Approx(c.low).epsilon(1e-13));
    CHECK(found.highest == doctest::Approx(c.high).epsilon(1e-13));
  }
  CHECK(wilson_interval(0, 0).lowest == 0);
  CHECK(wilson_interval(0, 0).highest == 1);
  CHECK(wilson_interval(0, 7).lowest == 0);
  CHECK(wilson_interval(7, 7).highest == 1);
}
