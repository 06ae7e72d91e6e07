// Forces of redundant contacts, against random samples of what they can be.
#include <momentree/contact/shared_forces.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <tests/oracle/prng.hpp>

using namespace momentree::contact;
using momentree::oracle::Prng;

namespace {

struct Problem {
  std::vector<double> x, null, rows;
  std::vector<ForceCone> cones;
  std::vector<double> with(const std::vector<double>& y) const {
    std::vector<double> all = x;
    for (std::size_t k = 0; k < y.size(); ++k)
      for (std::size_t i = 0; i < x.size(); ++i) all[i] += y[k] * null[k * x.size() + i];
    return all;
  }
};

double dot(const double* a, const double* b, std::size_t n) {
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}
double norm(const std::vector<double>& x) { return std::sqrt(dot(x.data(), x.data(), x.size())); }
double margin(const Problem& problem, const std::vector<double>& x) {
  double least = HUGE_VAL;
  for (const ForceCone& cone : problem.cones) least = std::min(least, cone.margin(x));
  return least;
}

// x is the least of x + Zᵀ y.
Problem random_problem(Prng& random, int contacts, std::size_t open) {
  Problem problem;
  for (int c = 0; c < contacts; ++c) {
    const double friction = c % 3 == 2 ? 0 : random.uniform(0.1, 1);
    problem.cones.push_back({problem.x.size(), friction});
    problem.x.push_back(random.uniform(-0.2, 1));
    for (int k = 0; k < 2 && friction > 0; ++k) problem.x.push_back(random.uniform(-0.5, 0.5));
  }
  const std::size_t n = problem.x.size();
  for (std::size_t k = 0; k < open; ++k) {
    std::vector<double> own(n);
    for (double& v : own) v = random.uniform(-1, 1);
    for (int pass = 0; pass < 2; ++pass)
      for (std::size_t l = 0; l < k; ++l) {
        const double along = dot(own.data(), problem.null.data() + l * n, n);
        for (std::size_t i = 0; i < n; ++i) own[i] -= along * problem.null[l * n + i];
      }
    const double size = norm(own);
    for (std::size_t i = 0; i < n; ++i) problem.null.push_back(own[i] / size);
  }
  for (std::size_t k = 0; k < n; ++k) {  // the rest of an orthonormal basis
    std::vector<double> own(n, 0.0);
    own[k] = 1;
    for (int pass = 0; pass < 2; ++pass)
      for (const std::vector<double>* basis : {&problem.null, &problem.rows})
        for (std::size_t l = 0; l < basis->size(); l += n) {
          const double along = dot(own.data(), basis->data() + l, n);
          for (std::size_t i = 0; i < n; ++i) own[i] -= along * (*basis)[l + i];
        }
    const double size = norm(own);
    if (problem.rows.size() + problem.null.size() == n * n || size < 1e-2) continue;
    for (std::size_t i = 0; i < n; ++i) problem.rows.push_back(own[i] / size);
  }
  REQUIRE(problem.rows.size() + problem.null.size() == n * n);
  for (std::size_t k = 0; k < open; ++k) {
    const double along = dot(problem.x.data(), problem.null.data() + k * n, n);
    for (std::size_t i = 0; i < n; ++i) problem.x[i] -= along * problem.null[k * n + i];
  }
  return problem;
}

}  // namespace

TEST_CASE("of all forces that contacts can exert the least are chosen; where they can exert none, those that lack least") {
  Prng random(71);
  int possible = 0, impossible = 0;
  for (int k = 0; k < 400; ++k) {
    const std::size_t open = 1 + static_cast<std::size_t>(k % 4);
    const Problem problem = random_problem(random, 2 + k % 5, open);
    std::vector<double> chosen = problem.x;
    SharedForces shared;
    const bool can = shared.choose(chosen, problem.rows, problem.cones);
    const double found = shared.margin();
    CHECK(can == (found > 0));
    double size = 0;
    for (const double v : problem.x) size = std::max(size, std::fabs(v));
    const std::size_t n = problem.x.size();
    std::vector<double> y(open);
    for (std::size_t j = 0; j < open; ++j) y[j] = dot(chosen.data(), problem.null.data() + j * n, n);
    CHECK(norm(chosen) * norm(chosen) == doctest::Approx(norm(problem.x) * norm(problem.x) + norm(y) * norm(y)).epsilon(1e-12));
    (found > 0 ? possible : impossible) += 1;
    if (found > 0)
      CHECK(margin(problem, chosen) >= -1e-15);
    else
      CHECK(margin(problem, chosen) == doctest::Approx(found * size).epsilon(1e-5));
    // Near and far, no other forces have a larger margin, or are possible and smaller.
    for (int sample = 0; sample < 300; ++sample) {
      std::vector<double> other = y;
      const double reach = std::pow(10.0, random.uniform(-5, 1));
      for (double& v : other) v += reach * random.uniform(-1, 1);
      const std::vector<double> x = problem.with(other);
      const double m = margin(problem, x);
      CHECK(std::min(m / size, 1.0) <= found + 1e-9);
      if (m >= 0) CHECK(norm(x) >= norm(chosen) * (1 - 1e-7));
    }
  }
  CHECK(possible > 50);
  CHECK(impossible > 50);
}

TEST_CASE("forces that contacts can hardly exert are found: at the limit of their friction, which is the same everywhere") {
  Prng random(5);
  for (int k = 0; k < 300; ++k) {
    CAPTURE(k);
    const int contacts = random.integer(4, 10);
    Problem problem = random_problem(random, contacts, static_cast<std::size_t>(random.integer(1, 4)));
    const std::size_t open = problem.null.size() / problem.x.size();
    const double inside = std::pow(10.0, random.uniform(-8, -1)), friction = random.uniform(0.1, 1);
    for (ForceCone& cone : problem.cones) {  // forces that are possible, by that much
      const double along = random.uniform(0, 6.28), normal = random.uniform(0, 1);
      double* const x = problem.x.data() + cone.normal;
      x[0] = normal + inside;
      if (!(cone.friction > 0)) continue;
      cone.friction = friction;
      x[1] = friction * normal * std::cos(along), x[2] = friction * normal * std::sin(along);
    }
    std::vector<double> y(open);
    for (std::size_t j = 0; j < open; ++j)
      y[j] = -dot(problem.x.data(), problem.null.data() + j * problem.x.size(), problem.x.size());
    problem.x = problem.with(y);  // the least of them
    double size = 0;
    for (const double v : problem.x) size = std::max(size, std::fabs(v));
    std::vector<double> chosen = problem.x;
    SharedForces shared;
    CHECK(shared.choose(chosen, problem.rows, problem.cones));
    CHECK(margin(problem, chosen) >= -1e-12 * size);
    CHECK(shared.margin() >= std::min(0.9 * inside / size, 1.0));
  }
}

TEST_CASE("forces that press against each other at will have the largest margin") {
  // Between two walls: N1 − N2 = 1.
  std::vector<double> x{0.5, -0.5};
  const std::vector<double> rows{std::sqrt(0.5), -std::sqrt(0.5)};
  const std::vector<ForceCone> cones{{0, 0}, {1, 0}};
  SharedForces shared;
  CHECK(shared.choose(x, rows, cones));
  CHECK(x[0] == doctest::Approx(1).epsilon(1e-12));
  CHECK(std::fabs(x[1]) < 1e-12);
  CHECK(shared.margin() == 1);
}
