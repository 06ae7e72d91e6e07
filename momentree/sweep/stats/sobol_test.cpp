#include <array>
#include <cmath>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/sampling_test_support.hpp>
#include <momentree/sweep/stats/sobol.hpp>

using namespace momentree::sweep;

TEST_CASE("the first 4096 points are SciPy's, in all 64 dimensions") {
  // x = scipy.stats.qmc.Sobol(64, scramble=False, bits=52).random(4096)
  // ((x * 4096).astype(np.int64) * np.arange(4096)[:, None]).sum(0)
  constexpr std::array<std::uint64_t, 64> sums{
      17173578752, 17179870208, 17173578752, 17175675904, 17175675904, 17175675904, 17175675904, 17173578752,
      17173578752, 17173578752, 17177773056, 17173578752, 17175675904, 17173578752, 17173578752, 17177773056,
      17175675904, 17177773056, 17175675904, 17179870208, 17177773056, 17175675904, 17173578752, 17173578752,
      17175675904, 17177773056, 17177773056, 17173578752, 17179870208, 17177773056, 17173578752, 17175675904,
      17175675904, 17175675904, 17177773056, 17177773056, 17173578752, 17175675904, 17175675904, 17175675904,
      17175675904, 17175675904, 17177773056, 17173578752, 17173578752, 17177773056, 17177773056, 17175675904,
      17175675904, 17173578752, 17173578752, 17177773056, 17175675904, 17175675904, 17175675904, 17173578752,
      17173578752, 17173578752, 17173578752, 17173578752, 17177773056, 17173578752, 17173578752, 17175675904};
  for (int d = 0; d < 64; ++d) {
    std::uint64_t sum = 0;
    for (std::uint64_t i = 0; i < 4096; ++i) sum += i * (sobol_bits(i, d) >> 40);
    CAPTURE(d);
    CHECK(sum == sums[static_cast<std::size_t>(d)]);
  }
  struct Point {
    std::uint64_t index;
    int dimension;
    double x;
  };
  for (const Point& p : {Point{1, 63, 0.5}, Point{2, 7, 0.75}, Point{5, 20, 0.625}, Point{100, 1, 0.2578125},
                         Point{1000, 41, 0.2548828125}, Point{4095, 63, 0.553466796875}})
    CHECK(std::ldexp(static_cast<double>(sobol_bits(p.index, p.dimension)), -52) == p.x);
}

TEST_CASE("every aligned block of 2^m points has one point in each of 2^m intervals, scrambled or not") {
  for (int d = 0; d < sobol_dimensions; ++d)
    for (const int m : {1, 3, 8})
      for (const std::uint64_t block : {std::uint64_t{0}, std::uint64_t{5}, std::uint64_t{1} << 40}) {
        std::set<std::uint64_t> plain, scrambled;
        for (std::uint64_t i = 0; i < std::uint64_t{1} << m; ++i) {
          const std::uint64_t index = (block << m) + i;
          plain.insert(sobol_bits(index, d) >> (52 - m));
          scrambled.insert(static_cast<std::uint64_t>(std::ldexp(sobol(index, d, 9), m)));
        }
        REQUIRE(plain.size() == std::size_t{1} << m);
        REQUIRE(scrambled.size() == std::size_t{1} << m);
      }
}

TEST_CASE("a scrambled point is uniform over seeds, and its dimensions are independent") {
  std::vector<double> x, y;
  for (std::uint64_t seed = 0; seed < 50'000; ++seed) {
    x.push_back(sobol(3, 0, seed));
    y.push_back(sobol(3, 1, seed));
    REQUIRE((x.back() > 0 && x.back() < 1));
  }
  CHECK(distance_from(x, [](double t) { return t; }) < 1.95);
  CHECK(distance_from(y, [](double t) { return t; }) < 1.95);
  CHECK(std::abs(correlation_of(x, y)) < 3.3 / std::sqrt(50'000.0));
}

TEST_CASE("scrambling is nested: digits of two points are independent after the first that differs, and agree before") {
  struct Two {
    std::uint64_t first, second;
    int common;
  };
  for (const Two& two : {Two{0, 1, 0}, Two{0, 3, 1}, Two{4, 3, 2}}) {
    std::array<int, 30> equal{};
    constexpr int seeds = 4000;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      const auto a = static_cast<std::uint64_t>(std::ldexp(sobol(two.first, 0, seed), 30)),
                 b = static_cast<std::uint64_t>(std::ldexp(sobol(two.second, 0, seed), 30));
      for (std::size_t digit = 0; digit < 30; ++digit) equal[digit] += ((a ^ b) >> (29 - digit) & 1) == 0;
    }
    for (int digit = 0; digit < 30; ++digit) {
      CAPTURE(digit);
      const int count = equal[static_cast<std::size_t>(digit)];
      if (digit < two.common) CHECK(count == seeds);
      if (digit == two.common) CHECK(count == 0);
      if (digit > two.common) CHECK(std::abs(count - seeds / 2) < 130);
    }
  }
}

namespace {

// Squared L2-star discrepancy by Warnock's formula.
template <class Point>
double discrepancy(int n, int dimensions, Point&& point) {
  double single = 0, pairs = 0;
  for (int i = 0; i < n; ++i) {
    double product = 1;
    for (int d = 0; d < dimensions; ++d) product *= 1 - point(i, d) * point(i, d);
    single += product;
    for (int j = 0; j < n; ++j) {
      product = 1;
      for (int d = 0; d < dimensions; ++d) product *= 1 - std::max(point(i, d), point(j, d));
      pairs += product;
    }
  }
  return std::pow(3.0, -dimensions) - std::pow(2.0, 1 - dimensions) / n * single + pairs / n / n;
}

}  // namespace

TEST_CASE("the discrepancy is far below that of random points, and integrals converge faster") {
  const int n = 256, dimensions = 5;
  const auto table = [&](auto&& f) {
    std::vector<double> all;
    for (int i = 0; i < n; ++i)
      for (int d = 0; d < dimensions; ++d) all.push_back(f(static_cast<std::uint64_t>(i), d));
    return [all, dimensions](int i, int d) { return all[static_cast<std::size_t>(i * dimensions + d)]; };
  };
  const double expected = (std::pow(0.5, dimensions) - std::pow(1.0 / 3, dimensions)) / n;  // of random points
  double scrambled = 0, random = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    scrambled += discrepancy(n, dimensions, table([&](std::uint64_t i, int d) { return sobol(i, d, seed); })) / 8;
    random += discrepancy(n, dimensions,
                          table([&](std::uint64_t i, int d) { return Random(seed, static_cast<std::uint64_t>(d)).uniform(i); })) /
              8;
  }
  CHECK(scrambled < expected / 5);
  CHECK((random > expected / 2 && random < expected * 2));

  double sum = 0;
  for (std::uint64_t i = 0; i < 4096; ++i) {
    double product = 1;
    for (int d = 0; d < dimensions; ++d) product *= std::exp(sobol(i, d, 1));
    sum += product;
  }
  const double exact = std::pow(std::exp(1.0) - 1, dimensions);
  CHECK(std::abs(sum / 4096 / exact - 1) < 1e-4);  // random points: 1e-2
}
