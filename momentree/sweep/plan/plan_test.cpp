#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/sweep/plan/plan.hpp>
#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/sampling_test_support.hpp>

using namespace momentree;
using namespace momentree::sweep;

namespace {

using Rows = std::vector<std::vector<double>>;

std::vector<double> row_of(const Plan& plan, std::uint64_t world) {
  std::vector<double> row(plan.size());
  plan.values(world, row);
  return row;
}
/// The values of all worlds, by component.
Rows columns_of(const Plan& plan) {
  Rows columns(plan.size());
  for (std::uint64_t world = 0; world < plan.worlds(); ++world) {
    const auto row = row_of(plan, world);
    for (std::size_t i = 0; i < row.size(); ++i) columns[i].push_back(row[i]);
  }
  return columns;
}

Variable sampled(std::string key, Sampling how, std::vector<Distribution> components) {
  return {std::move(key), Sampled{how, std::move(components)}};
}

std::string refusal(std::vector<Variable> variables, std::optional<std::uint64_t> worlds = {},
                    std::vector<Correlation> correlations = {}) {
  try {
    const Plan plan(std::move(variables), worlds, 0, std::move(correlations));
    return "accepted";
  } catch (const Error& error) {
    return error.problem + "; " + error.hint;
  }
}

}  // namespace

TEST_CASE("without a number of worlds, every combination occurs once, and the last variable varies fastest") {
  const Plan plan({{"a", ListValues{2}},
                   sampled("u", Sampling::random, {Uniform{0, 1}}),
                   {"b", RangeValues{0, 1, 11}},
                   {"c", RangeValues{5, -5, 3}}},
                  {}, 1);
  CHECK(plan.worlds() == 66);
  CHECK(plan.size() == 4);
  std::set<double> draws;
  for (std::uint64_t world = 0; world < 66; ++world) {
    const auto row = row_of(plan, world);
    CHECK(row[0] == static_cast<double>(world / 33));
    CHECK(row[2] == static_cast<double>(world / 3 % 11) / 10);
    CHECK(row[3] == 5 - 5.0 * static_cast<double>(world % 3));
    draws.insert(row[1]);
  }
  CHECK(draws.size() == 66);
  const Plan nothing({}, {}, 1);
  CHECK(nothing.worlds() == 1);
  CHECK(nothing.size() == 0);
  CHECK(Plan({{"a", RangeValues{3, 4, 1}}}, {}, 0).worlds() == 1);
  CHECK(row_of(Plan({{"a", RangeValues{3, 4, 1}}}, {}, 0), 0)[0] == 3);
}

TEST_CASE("ranges have exact ends and evenly spaced values") {
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const double from = std::sinh(40 * (Random(1, 1).uniform(i) - 0.5)), to = std::sinh(40 * (Random(1, 2).uniform(i) - 0.5));
    const std::size_t count = 2 + Random(1, 3).bits(i) % 50;
    const Plan plan({{"a", RangeValues{from, to, count}}}, {}, 0);
    CHECK(row_of(plan, 0)[0] == from);
    CHECK(row_of(plan, count - 1)[0] == to);
    for (std::size_t k = 0; k < count; ++k) {
      const long double t = static_cast<long double>(k) / static_cast<long double>(count - 1);
      const long double exact = from * (1 - t) + to * t, size = std::max(std::abs(from), std::abs(to));
      REQUIRE(std::abs(row_of(plan, k)[0] - exact) <= 4e-16L * size);
    }
  }
}

TEST_CASE("with a number of worlds, lists and ranges are drawn evenly") {
  const Plan plan({{"a", ListValues{4}}, {"b", RangeValues{1, 2, 5}}}, 40'000, 3);
  CHECK(plan.worlds() == 40'000);
  const Rows columns = columns_of(plan);
  for (int k = 0; k < 4; ++k) CHECK(std::abs(std::count(columns[0].begin(), columns[0].end(), k) - 10'000) < 300);
  for (int k = 0; k < 5; ++k) CHECK(std::abs(std::count(columns[1].begin(), columns[1].end(), 1 + k / 4.0) - 8000) < 270);
  CHECK(std::abs(correlation_of(columns[0], columns[1])) < 0.0165);
}

TEST_CASE("a Latin hypercube has one world in each stratum of each component") {
  for (const std::uint64_t worlds : {1, 2, 3, 5, 10, 64, 65, 100, 1000, 4099}) {
    const Plan plan({sampled("x", Sampling::latin, {Uniform{0, 1}, Normal{0, 1}, Exponential{2}}),
                     sampled("y", Sampling::latin, {Uniform{0, 1}})},
                    worlds, 5);
    const Rows columns = columns_of(plan);
    const std::vector<Distribution> distributions{Uniform{0, 1}, Normal{0, 1}, Exponential{2}, Uniform{0, 1}};
    for (std::size_t c = 0; c < columns.size(); ++c) {
      std::vector<int> hits(worlds, 0);
      for (const double value : columns[c]) {
        const double u = distributions[c].cdf(value);
        REQUIRE((u > 0 && u < 1));
        ++hits[static_cast<std::size_t>(u * static_cast<double>(worlds))];
      }
      CHECK(std::count(hits.begin(), hits.end(), 1) == static_cast<long>(worlds));
    }
    if (worlds >= 1000) {
      CHECK(std::abs(correlation_of(columns[0], columns[3])) < 0.1);
      CHECK(std::abs(correlation_of(columns[0], columns[1])) < 0.1);
    }
  }
  // The largest plans: no rounding leads out of (0, 1).
  const Plan large({sampled("x", Sampling::latin, {Uniform{0, 1}})}, std::uint64_t{1} << 48, 5);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const double u = row_of(large, Random(0, 0).bits(i) >> 16)[0];
    REQUIRE((u > 0 && u < 1));
    REQUIRE(std::fmod(std::ldexp(u, 52), 2) == 1);  // one of 8 places inside a stratum
  }
}

TEST_CASE("a Latin hypercube estimates means better than random draws") {
  const auto error = [](Sampling how) {
    double square = 0;
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const Plan plan({sampled("x", how, {Exponential{1}, Normal{0, 1}})}, 200, seed);
      const Rows columns = columns_of(plan);
      square += std::pow(mean_of(columns[0]) - 1, 2) + std::pow(mean_of(columns[1]), 2);
    }
    return std::sqrt(square / 100);
  };
  CHECK(error(Sampling::random) == doctest::Approx(1 / std::sqrt(200)).epsilon(0.25));
  CHECK(error(Sampling::latin) < 0.01);
  CHECK(error(Sampling::sobol) < 0.02);
}

TEST_CASE("values of a world depend on the seed and its number alone") {
  const auto make = [](std::uint64_t seed) {
    return Plan({sampled("x", Sampling::random, {Normal{0, 1}, Normal{0, 1}}),
                 sampled("y", Sampling::latin, {Uniform{0, 1}}),
                 sampled("z", Sampling::sobol, {Uniform{0, 1}, Uniform{0, 1}}),
                 {"l", ListValues{7}}},
                1000, seed, {{0, 4, 0.5}});
  };
  const Plan a = make(8), b = make(8), c = make(9);
  int equal = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const std::uint64_t world = permute(i, 1000, 3);
    CHECK(row_of(a, world) == row_of(b, world));
    const auto one = row_of(a, world), other = row_of(c, world);
    for (std::size_t k = 0; k < 5; ++k) equal += one[k] == other[k];
  }
  CHECK(equal == 0);
}

TEST_CASE("random draws of a variable do not change when others are added") {
  const Plan alone({sampled("x", Sampling::random, {Normal{0, 1}})}, 100, 8);
  const Plan more(
      {{"l", ListValues{7}}, sampled("y", Sampling::random, {Uniform{0, 1}}), sampled("x", Sampling::random, {Normal{0, 1}})},
      200, 8);
  for (std::uint64_t world = 0; world < 100; ++world) CHECK(row_of(alone, world)[0] == row_of(more, world)[2]);
}

TEST_CASE("correlations are attained, and every component keeps its distribution") {
  for (const Sampling how : {Sampling::random, Sampling::sobol}) {
    const std::vector<Distribution> distributions{Normal{5, 2}, Lognormal{0, 1}, Uniform{0, 1}, Normal{-1, 0.1}, Exponential{1}};
    const Plan plan({sampled("x", how, distributions)}, 20'000, 4, {{0, 3, 0.8}, {3, 1, -0.5}, {2, 1, 0.6}, {0, 1, -0.3}});
    const Rows columns = columns_of(plan);
    for (std::size_t i = 0; i < 5; ++i) {
      CAPTURE(i);
      CHECK(distance_from(columns[i], [&](double x) { return distributions[i].cdf(x); }) < 1.95);
    }
    CHECK(correlation_of(columns[0], columns[3]) == doctest::Approx(0.8).epsilon(0.02));
    Rows normal = columns;  // undo the margins
    for (double& x : normal[1]) x = std::log(x);
    CHECK(correlation_of(normal[1], normal[3]) == doctest::Approx(-0.5).epsilon(0.04));
    CHECK(correlation_of(normal[0], normal[1]) == doctest::Approx(-0.3).epsilon(0.07));
    // Of uniform margins: 6/π asin(ρ/2)
    for (double& x : normal[1]) x = distributions[1].cdf(std::exp(x));
    CHECK(correlation_of(normal[1], normal[2]) == doctest::Approx(6 / 3.14159265358979 * std::asin(0.3)).epsilon(0.03));
    CHECK(std::abs(correlation_of(columns[2], columns[4])) < 0.025);
    CHECK(std::abs(correlation_of(columns[0], columns[2])) < 0.025);
  }
}

TEST_CASE("impossible plans are refused") {
  const auto normal = [](std::string key, Sampling how = Sampling::random) {
    return sampled(std::move(key), how, {Normal{0, 1}});
  };
  CHECK(refusal({{"a", ListValues{0}}}) == "'a' has no values; give at least one");
  CHECK(refusal({{"a", RangeValues{0, 1, 0}}}) == "'a' has no values; give at least one");
  CHECK(refusal({{"a", RangeValues{0, INFINITY, 3}}}) == "'a' has a range that is not finite; ");
  CHECK(refusal({sampled("a", Sampling::random, {})}) == "'a' has no distribution; give one, or one per component");
  CHECK(refusal({{"a", ListValues{2}}, {"a", ListValues{3}}}) == "'a' is varied twice; remove one of them");
  CHECK(refusal({normal("a")}, 0) == "a sweep has from 1 to 2^48 worlds; ");
  CHECK(refusal({normal("a")}, (std::uint64_t{1} << 48) + 1) == "a sweep has from 1 to 2^48 worlds; ");
  CHECK(refusal({normal("a")}, std::uint64_t{1} << 48) == "accepted");
  CHECK(refusal({{"a", ListValues{1u << 30}}, {"b", ListValues{1u << 30}}, {"c", ListValues{1u << 30}}})
            .find("more combinations") != std::string::npos);
  CHECK(refusal({{"a", ListValues{1u << 24}}, {"b", ListValues{1u << 24}}}) == "accepted");
  CHECK(refusal({sampled("a", Sampling::sobol, std::vector<Distribution>(64, Uniform{0, 1}))}, 10) == "accepted");
  CHECK(
      refusal({sampled("a", Sampling::sobol, std::vector<Distribution>(65, Uniform{0, 1}))}, 10).find("64 dimensions, and 65") !=
      std::string::npos);
  const std::vector<Variable> three{normal("a"),
                                    sampled("v", Sampling::sobol, {Normal{0, 1}, Normal{0, 1}}),
                                    normal("h", Sampling::latin),
                                    {"l", ListValues{2}}};
  CHECK(refusal(three, 9, {{0, 1, 0.5}, {1, 2, 0.5}}) == "accepted");
  CHECK(refusal(three, 9, {{1, 1, 0.5}}) == "a correlation of 'v.0' with itself; name two different values");
  CHECK(refusal(three, 9, {{0, 2, 1}}) == "the correlation of 'a' and 'v.1' is not between -1 and 1; both ends are excluded");
  CHECK(refusal(three, 9, {{0, 2, std::nan("")}}).find("not between") != std::string::npos);
  CHECK(refusal(three, 9, {{0, 2, 0.1}, {2, 0, 0.1}}) == "the correlation of 'a' and 'v.1' is given twice; remove one");
  CHECK(refusal(three, 9, {{0, 2, 0.1}, {0, 2, 0.1}}) == "the correlation of 'a' and 'v.1' is given twice; remove one");
  CHECK(refusal(three, 9, {{0, 3, 0.1}}).find("'h' is part of a Latin hypercube") != std::string::npos);
  CHECK(refusal(three, 9, {{4, 0, 0.1}}).find("'l' is a list or a range") != std::string::npos);
  CHECK(refusal(three, 9, {{0, 1, 0.9}, {0, 2, 0.9}, {1, 2, -0.9}}).find("the correlations contradict each other") !=
        std::string::npos);
  CHECK(refusal(three, 9, {{0, 1, 0.9}, {0, 2, 0.9}}).find("the correlations contradict each other") != std::string::npos);
}

namespace {

// A random plan, from random numbers of its number.
struct RandomPlan {
  std::uint64_t number, index = 0;
  std::uint64_t below(std::uint64_t n) { return Random(77, number).bits(index++) % n; }
  double real(double from, double to) { return from + (to - from) * Random(77, number).uniform(index++); }
  Distribution distribution() {
    switch (below(9)) {
      case 0: return Uniform{real(-9, 0), real(0.1, 9)};
      case 1: return Normal{real(-9, 9), real(0.01, 9)};
      case 2: return Normal{real(-9, 9), real(0.5, 9), Interval{real(-9, 0), real(0.1, 9)}};
      case 3: return Lognormal{real(-2, 2), real(0.01, 2)};
      case 4: return Exponential{real(0.01, 9)};
      case 5: return Weibull{real(0.01, 9), real(0.2, 9)};
      case 6: return Triangular{real(-9, 0), real(0, 1), real(1.1, 9)};
      case 7: return Beta{real(0.05, 9), real(0.05, 9), {real(-9, 0), real(0.1, 9)}};
      default: return Choice{std::vector<double>(1 + below(6), real(0.1, 1))};
    }
  }
  Variable variable(std::size_t i) {
    const std::string key = "k" + std::to_string(i);
    const std::uint64_t kind = below(5);
    if (kind == 0) return {key, ListValues{1 + below(5)}};
    if (kind == 1) return {key, RangeValues{real(-9, 9), real(-9, 9), 1 + below(5)}};
    std::vector<Distribution> components;
    for (std::uint64_t c = 1 + below(3); c > 0; --c) components.push_back(distribution());
    return sampled(key, static_cast<Sampling>(kind - 2), std::move(components));
  }
};

}  // namespace

TEST_CASE("10,000 random plans: values are possible, and the same in any order") {
  int refused = 0;
  for (std::uint64_t number = 0; number < 10'000; ++number) {
    RandomPlan random{number};
    std::vector<Variable> variables;
    for (std::size_t i = random.below(5); variables.size() < i;) variables.push_back(random.variable(variables.size()));
    std::vector<const Distribution*> distributions;  // by component
    std::vector<std::size_t> free;                   // may be correlated
    for (const Variable& variable : variables) {
      const auto* drawn = std::get_if<Sampled>(&variable.values);
      if (!drawn) distributions.push_back(nullptr);
      for (std::size_t c = 0; drawn && c < drawn->components.size(); ++c) {
        if (drawn->how != Sampling::latin) free.push_back(distributions.size());
        distributions.push_back(&drawn->components[c]);
      }
    }
    std::vector<Correlation> correlations;
    for (std::size_t i = 1; i < free.size(); ++i)
      if (random.below(2)) correlations.push_back({free[i - 1], free[i], random.real(-0.99, 0.99)});
    std::optional<std::uint64_t> worlds;
    if (random.below(2)) worlds = 1 + random.below(random.below(2) ? 10 : 1'000'000'000'000);
    try {
      const Plan plan(variables, worlds, number, correlations);
      CAPTURE(number);
      REQUIRE(plan.size() == distributions.size());
      for (int i = 0; i < 4; ++i) {
        const std::uint64_t world = i == 0 ? 0 : i == 1 ? plan.worlds() - 1 : random.below(plan.worlds());
        const auto row = row_of(plan, world);
        REQUIRE(row == row_of(Plan(plan), world));
        for (std::size_t c = 0; c < row.size(); ++c) {
          REQUIRE(std::isfinite(row[c]));
          if (!distributions[c]) continue;
          const double share = distributions[c]->cdf(row[c]);
          REQUIRE((share > 0 || distributions[c]->cdf(std::nextafter(row[c], INFINITY)) > 0));
          if (const auto* choice = std::get_if<Choice>(&distributions[c]->kind()))
            REQUIRE(row[c] < static_cast<double>(choice->weights.size()));
        }
      }
    } catch (const Error& error) {
      REQUIRE(error.problem.find("contradict") != std::string::npos);  // a chain of correlations with zeros between its ends
      ++refused;
    }
  }
  CHECK(refused < 2000);
}
