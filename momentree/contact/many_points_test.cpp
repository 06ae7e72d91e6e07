// Impulses at many points by sweeps: against the exact solver where both apply, and what must hold whatever the sweeps reach.
#include <algorithm>
#include <climits>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/impact.hpp>
#include <momentree/contact/many_points.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

// Bodies of six degrees of freedom with random mass matrices, and random points between them and the ground. `pairs`: point i
// is between the same bodies as point i + pairs.
ManyPoints random_points(Prng& random, int bodies, int points, double friction, double restitution, int pairs = INT_MAX) {
  ManyPoints all;
  all.clear(6 * bodies, bodies);
  std::vector<std::vector<double>> inverse;
  for (int b = 0; b < bodies; ++b) {
    std::vector<double> factor(36), M(36, 0.0);
    for (double& x : factor) x = random.uniform(-1, 1);
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) {
        for (std::size_t k = 0; k < 6; ++k) M[6 * i + j] += factor[6 * i + k] * factor[6 * j + k];
        if (i == j) M[6 * i + j] += 0.3;
      }
    inverse.push_back(M);
  }
  std::vector<double> u(6 * static_cast<std::size_t>(bodies));
  for (double& x : u) x = random.uniform(-1, 1);
  for (int p = 0; p < points; ++p) {
    ManyPoints::Point point;
    point.friction = friction, point.restitution = restitution;
    double b[3] = {};
    const int first = p % pairs % bodies;
    int second = random.uniform(0, 1) < 0.5 || bodies == 1 ? -1 : (first + 1) % bodies;
    if (p >= pairs) second = all.points[static_cast<std::size_t>(p - pairs)].parts[1].group;
    for (const auto& [side, body] : {std::pair{std::size_t{0}, first}, {std::size_t{1}, second}}) {
      if (body < 0) continue;
      point.parts[side] = {body, 6 * body, 6, all.J.size()};
      for (std::size_t row = 0; row < 3; ++row) {
        double J[6];
        for (std::size_t k = 0; k < 6; ++k) {
          J[k] = random.uniform(-1, 1);
          b[row] += J[k] * u[6 * static_cast<std::size_t>(body) + k];
        }
        all.J.insert(all.J.end(), J, J + 6);
        for (std::size_t k = 0; k < 6; ++k) {
          double y = 0;
          for (std::size_t j = 0; j < 6; ++j) y += inverse[static_cast<std::size_t>(body)][6 * k + j] * J[j];
          all.Y.push_back(y);
        }
      }
    }
    all.points.push_back(point);
    all.b.insert(all.b.end(), b, b + 3);
  }
  all.r.assign(3 * all.points.size(), 0.0);
  return all;
}

// The same as a dense system.
System dense(const ManyPoints& many) {
  System all;
  all.resize(many.points.size());
  all.b = many.b;
  for (std::size_t i = 0; i < many.points.size(); ++i) {
    all.laws[i].friction = many.points[i].friction;
    for (std::size_t j = 0; j < many.points.size(); ++j)
      for (const ManyPoints::Part& a : many.points[i].parts)
        for (const ManyPoints::Part& c : many.points[j].parts) {
          if (a.group < 0 || a.group != c.group) continue;
          for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 3; ++column)
              for (std::size_t k = 0; k < 6; ++k)
                all.element(3 * i + row, 3 * j + column) += many.J[a.at + 6 * row + k] * many.Y[c.at + 6 * column + k];
        }
  }
  return all;
}

}  // namespace

TEST_CASE("many points: impulses are those of the exact solver") {
  Prng random(1);
  double worst = 0;
  int compared = 0;
  for (int k = 0; k < 2000; ++k) {
    // Without friction, or at one point, the solution is unique.
    const bool single = k % 2 == 0;
    ManyPoints many = random_points(random, single ? 1 : 2, single ? 1 : 2, single ? 0.5 : 0.0, 0.0);
    System exact = dense(many);
    ImpactLaw law;
    REQUIRE(law.apply(exact, std::vector<double>(many.points.size(), 0.0)).solved);
    many.solve();
    double size = 1e-3;
    for (const double x : exact.r) size = std::max(size, std::fabs(x));
    std::vector<double> w, expected;
    many.velocities(w), exact.velocities(expected);
    for (std::size_t i = 0; i < w.size(); ++i) worst = std::max(worst, std::fabs(w[i] - expected[i]));
    ++compared;
  }
  CHECK(compared == 2000);
  CHECK(worst < 1e-9);
}

TEST_CASE("many points: no impact gains energy, none pulls, and friction keeps to its cone") {
  Prng random(2);
  int bounced = 0, unsolved = 0;
  for (int k = 0; k < 3000; ++k) {
    const double friction = random.uniform(0, 1.2), e = k % 3 == 0 ? 0.0 : random.uniform(0, 1);
    ManyPoints many = random_points(random, 1 + k % 6, 1 + k % 15, friction, e);
    // Also from a bad guess, which sweeps that end early may keep in part.
    if (k % 4 == 0)
      for (std::size_t i = 0; i < many.points.size(); ++i) many.r[3 * i] = random.uniform(0, 5);
    const System exact = dense(many);
    many.solve();
    System outcome = exact;
    outcome.r = many.r;
    double size = 0;
    for (const double b : many.b) size = std::max(size, b * b);
    CHECK(outcome.energy_change() <= 1e-9 * size);
    unsolved += e == 0 && outcome.residual() > 2e-3 ? 1 : 0;
    CHECK((outcome.residual() <= 2e-3 || e > 0 || many.residual() > 1e-3));  // it is said
    bool leaves = false;
    std::vector<double> w, expected;
    many.velocities(w);
    outcome.velocities(expected);
    for (std::size_t i = 0; i < many.points.size(); ++i) {
      CHECK(many.r[3 * i] >= 0);
      CHECK(std::hypot(many.r[3 * i + 1], many.r[3 * i + 2]) <= friction * many.r[3 * i] * (1 + 1e-12) + 1e-15);
      leaves = leaves || (e > 0.5 && many.b[3 * i] < -0.3 && w[3 * i] > 0.1);
      // Momentum is exact: the velocities are those that the impulses give.
      for (std::size_t row = 0; row < 3; ++row)
        CHECK(std::fabs(w[3 * i + row] - expected[3 * i + row]) <= 1e-9 * (1 + std::fabs(expected[3 * i + row])));
    }
    bounced += leaves ? 1 : 0;
  }
  CHECK(bounced > 300);
  CHECK(unsolved < 10);
}

// At the end of bodies that points press are moments, with random rows of their own.
TEST_CASE("many points: moments obey their bounds and oppose what turns, and no impact gains energy") {
  Prng random(5);
  int turning = 0, held = 0, unsolved = 0;
  for (int k = 0; k < 2000; ++k) {
    const int bodies = 1 + k % 5, contacts = 1 + k % 9;
    const double torsion = random.chance(0.3) ? 0 : random.uniform(0, 0.2);
    const double rolling = random.chance(0.3) ? 0 : random.uniform(0, 0.2);
    ManyPoints many = random_points(random, bodies, 2 * contacts, random.uniform(0.1, 1), 0, contacts);
    for (std::size_t i = 0, n = many.points.size() / 2; i < n; ++i) {
      ManyPoints::Point& moments = many.points[n + i];
      moments.pressed_by = static_cast<int>(i), moments.torsion = torsion, moments.friction = rolling;
      if (k % 3 != 0) continue;
      for (const ManyPoints::Part& part : moments.parts)  // nothing turns about the normal
        if (part.group >= 0) std::fill_n(many.J.begin() + static_cast<std::ptrdiff_t>(part.at), 6, 0.0);
      for (const ManyPoints::Part& part : moments.parts)
        if (part.group >= 0) std::fill_n(many.Y.begin() + static_cast<std::ptrdiff_t>(part.at), 6, 0.0);
      many.b[3 * (n + i)] = 0;
    }
    System outcome = dense(many);
    many.solve(ManyPoints::at_rest);
    outcome.r = many.r;
    double size = 0;
    for (const double b : many.b) size = std::max(size, std::fabs(b));
    CHECK(outcome.energy_change() <= 1e-9 * size * size);
    if (many.residual() > 1e-9 && ++unsolved > 0) continue;  // it is said
    std::vector<double> w;
    outcome.velocities(w);
    for (std::size_t i = 0, n = many.points.size() / 2; i < n; ++i) {
      const double N = many.r[3 * i], *const m = &many.r[3 * (n + i)], *const turns = &w[3 * (n + i)];
      CHECK(N >= 0);
      CHECK(std::fabs(m[0]) <= torsion * N * (1 + 1e-9) + 1e-12);
      CHECK(std::hypot(m[1], m[2]) <= rolling * N * (1 + 1e-9) + 1e-12);
      // What turns is opposed with the whole moment.
      const double rolls = std::hypot(turns[1], turns[2]);
      CHECK(std::fabs(m[0] * turns[0] + torsion * N * std::fabs(turns[0])) < 1e-8 * size * (N + size));
      CHECK(std::fabs(m[1] * turns[1] + m[2] * turns[2] + rolling * N * rolls) < 1e-8 * size * (N + size));
      if (!(N > 0 && rolling > 0)) continue;
      turning += rolls > 1e-3 * size ? 1 : 0, held += rolls < 1e-9 * size ? 1 : 0;
    }
  }
  CHECK(turning > 500);
  CHECK(held > 500);
  CHECK(unsolved < 10);
}

TEST_CASE("many points: overlaps are removed, and nothing else is overlapped instead") {
  Prng random(3);
  for (int k = 0; k < 500; ++k) {
    ManyPoints many = random_points(random, 1 + k % 4, 1 + k % 6, 0, 0);
    std::vector<double> gaps(many.points.size()), pushes;
    for (double& gap : gaps) gap = random.uniform(-1, 1);
    LinksMotion& moved = many.separate(gaps, pushes);
    const double deepest = -std::min(0.0, *std::min_element(gaps.begin(), gaps.end()));
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      CHECK(pushes[i] >= 0);
      CHECK(gaps[i] + many.along_normal(i, moved) >= -0.1 * deepest);
    }
  }
}
