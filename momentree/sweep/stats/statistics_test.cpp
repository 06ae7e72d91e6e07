#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/statistics.hpp>

using namespace momentree::sweep;

namespace {

const double missing = std::numeric_limits<double>::quiet_NaN();

// A fixed row of a world: a draw, a coarse value with many ties, and one that is sometimes missing.
std::vector<double> row(std::uint64_t world) {
  const Random random(4, 4);
  const double u = random.uniform(world);
  return {1e6 + u, std::floor(5 * random.uniform(world + 1'000'000)), u < 0.1 ? missing : u < 0.11 ? INFINITY : -u};
}

void check_equal(const Statistics& a, const Statistics& b) {
  REQUIRE(a.worlds() == b.worlds());
  for (std::size_t i = 0; i < a.columns(); ++i) {
    const Summary one = a.summary(i), other = b.summary(i);
    CHECK(one.count == other.count);
    CHECK(one.missing == other.missing);
    CHECK(one.nonzero == other.nonzero);
    CHECK(one.mean == other.mean);
    CHECK(one.deviation == other.deviation);
    const auto same = [](const Extreme& x, const Extreme& y) { return x.value == y.value && x.world == y.world; };
    CHECK(std::equal(one.smallest.begin(), one.smallest.end(), other.smallest.begin(), other.smallest.end(), same));
    CHECK(std::equal(one.largest.begin(), one.largest.end(), other.largest.begin(), other.largest.end(), same));
  }
  CHECK(a.sample().worlds() == b.sample().worlds());
  CHECK(a.sample().column(0) == b.sample().column(0));
}

}  // namespace

TEST_CASE("results do not depend on the order of worlds, nor on how they are split") {
  constexpr std::uint64_t n = 20'000;
  const StatisticsOptions options{500, 7, 3};
  Statistics in_order(3, options), shuffled(3, options), merged(3, options);
  for (std::uint64_t i = 0; i < n; ++i) {
    in_order.add(i, row(i));
    const std::uint64_t world = permute(i, n, 1);
    shuffled.add(world, row(world));
  }
  std::vector<Statistics> parts(13, Statistics(3, options));
  for (std::uint64_t i = 0; i < n; ++i) parts[i * i % 13].add(i, row(i));
  for (const std::size_t i : {4, 12, 0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11}) merged.merge(parts[i]);
  check_equal(in_order, shuffled);
  check_equal(in_order, merged);
}

TEST_CASE("counts, moments and extremes against direct computation") {
  constexpr std::uint64_t n = 5000;
  Statistics statistics(3, {.kept = 100'000, .extremes = 4});
  std::vector<std::vector<Extreme>> columns(3);
  for (std::uint64_t world = 0; world < n; ++world) {
    const auto values = row(world);
    statistics.add(world, values);
    for (std::size_t i = 0; i < 3; ++i)
      if (std::isfinite(values[i])) columns[i].push_back({values[i], world});
  }
  CHECK(statistics.worlds() == n);
  for (std::size_t i = 0; i < 3; ++i) {
    auto& all = columns[i];
    const Summary summary = statistics.summary(i);
    CHECK(summary.count == all.size());
    CHECK(summary.missing == n - all.size());
    CHECK(summary.nonzero ==
          static_cast<std::uint64_t>(std::count_if(all.begin(), all.end(), [](const Extreme& e) { return e.value != 0; })));
    long double sum = 0, square = 0;
    for (const Extreme& one : all) sum += one.value;
    const long double mean = sum / static_cast<long double>(all.size());
    for (const Extreme& one : all) square += (one.value - mean) * (one.value - mean);
    CHECK(summary.mean == doctest::Approx(static_cast<double>(mean)).epsilon(1e-15));
    const double deviation = static_cast<double>(std::sqrt(square / static_cast<long double>(all.size() - 1)));
    CHECK(std::abs(summary.deviation / deviation - 1) < 1e-12);
    std::stable_sort(all.begin(), all.end(), [](const Extreme& a, const Extreme& b) { return a.value < b.value; });
    REQUIRE(summary.smallest.size() == 4);
    for (std::size_t k = 0; k < 4; ++k) {
      CHECK(summary.smallest[k].value == all[k].value);
      CHECK(summary.smallest[k].world == all[k].world);
    }
    std::stable_sort(all.begin(), all.end(), [](const Extreme& a, const Extreme& b) {
      return a.value > b.value || (a.value == b.value && a.world < b.world);
    });
    for (std::size_t k = 0; k < 4; ++k) {
      CHECK(summary.largest[k].value == all[k].value);
      CHECK(summary.largest[k].world == all[k].world);
    }
  }
  CHECK(statistics.summary(2).missing > 400);
}

TEST_CASE("statistics of no world and of one") {
  Statistics statistics(1);
  CHECK(statistics.summary(0).count == 0);
  CHECK(std::isnan(statistics.summary(0).mean));
  CHECK(statistics.summary(0).smallest.empty());
  statistics.add(9, std::vector<double>{-2.5});
  CHECK(statistics.summary(0).mean == -2.5);
  CHECK(std::isnan(statistics.summary(0).deviation));
  CHECK(statistics.summary(0).smallest[0].world == 9);
  CHECK(statistics.summary(0).largest[0].value == -2.5);
  statistics.add(10, std::vector<double>{missing});
  CHECK(statistics.summary(0).missing == 1);
}

TEST_CASE("a sample keeps all worlds up to its capacity, and then each with the same probability") {
  Sample sample(1, 100, 5);
  for (std::uint64_t i = 0; i < 100; ++i) sample.add(99 - i, std::vector<double>{static_cast<double>(99 - i)});
  CHECK(sample.complete());
  const auto column = sample.column(0);
  for (std::size_t i = 0; i < 100; ++i) CHECK(column[i] == static_cast<double>(i));
  for (std::uint64_t i = 100; i < 1000; ++i) sample.add(i, std::vector<double>{static_cast<double>(i)});
  CHECK(!sample.complete());
  CHECK(sample.size() == 100);
  CHECK(sample.offered() == 1000);
  const auto worlds = sample.worlds();
  const auto values = sample.column(0);
  for (std::size_t i = 0; i < 100; ++i) CHECK(values[i] == static_cast<double>(worlds[i]));

  std::vector<int> counts(20, 0);
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Sample small(0, 5, seed);
    for (std::uint64_t i = 0; i < 20; ++i) small.add(i, {});
    for (const std::uint64_t world : small.worlds()) ++counts[world];
  }
  double chi_square = 0;
  for (const int count : counts) chi_square += (count - 500.0) * (count - 500.0) / 500;
  CHECK(chi_square < 43.8);  // 19 degrees of freedom, 0.1 %; less for draws without replacement
}

TEST_CASE("sums are exact: cancellation, subnormal and huge numbers") {
  const double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();
  const auto moments = [](std::vector<double> values) {
    ExactMoments result;
    for (const double value : values) result.add(value);
    return result;
  };
  CHECK(moments({1e300, 1, -1e300, 3}).mean() == 1);
  CHECK(moments({huge, huge, huge, huge}).mean() == huge);
  CHECK(moments({huge, huge, huge, huge}).deviation() == 0);
  CHECK(moments({-huge, tiny, huge, tiny}).mean() == 0);  // half the smallest number rounds to 0
  CHECK(moments({tiny, tiny}).mean() == tiny);
  CHECK(moments({-tiny, tiny}).deviation() == tiny);
  CHECK(moments({0.1, 0.1, 0.1}).mean() == 0.1);
  CHECK(moments(std::vector<double>(999, 1e-310)).mean() == 1e-310);
  CHECK(moments({0.1, 0.1, 0.1}).deviation() == 0);
  CHECK(moments({1e15 + 1, 1e15 + 2, 1e15 + 3}).deviation() == 1);
  CHECK(moments({1e200, -1e200}).deviation() == doctest::Approx(std::sqrt(2) * 1e200).epsilon(1e-15));
  CHECK(moments({-3, -5}).mean() == -4);
  CHECK(moments({0, 0}).mean() == 0);

  ExactMoments all, half[2];
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    const double x = std::sinh(1400 * (Random(2, 2).uniform(i) - 0.5));
    all.add(x);
    half[Random(2, 3).bits(i) & 1].add(x);
  }
  half[1].add(half[0]);
  CHECK(half[1].count() == 10'000);
  CHECK(half[1].mean() == all.mean());
  CHECK(half[1].deviation() == all.deviation());
}
