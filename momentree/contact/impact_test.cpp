// The impact law in contact space: closed forms, references, and thousands of random impacts that must not gain energy.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/impact.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

using Vector = std::vector<double>;

// Dense J (rows × n) and a diagonal or full inverse mass matrix.
struct Dense {
  std::size_t n;
  Vector inverse;  // M⁻¹, n × n
  Vector J;        // rows of n numbers
  Vector u;        // velocities before
  std::size_t rows() const { return J.size() / n; }
  double product(std::size_t i, std::size_t j) const {
    double sum = 0;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t c = 0; c < n; ++c) sum += J[i * n + a] * inverse[a * n + c] * J[j * n + c];
    return sum;
  }
  System system(double friction) const {
    System all;
    all.resize(rows() / 3);
    for (std::size_t i = 0; i < rows(); ++i) {
      for (std::size_t j = 0; j < rows(); ++j) all.element(i, j) = product(i, j);
      for (std::size_t a = 0; a < n; ++a) all.b[i] += J[i * n + a] * u[a];
    }
    for (PointLaw& law : all.laws) law.friction = friction;
    return all;
  }
  Vector after(const System& all) const {
    Vector result = u;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t c = 0; c < n; ++c)
        for (std::size_t i = 0; i < rows(); ++i) result[a] += inverse[a * n + c] * J[i * n + c] * all.r[i];
    return result;
  }
};

// A rigid body in the plane of x and y: velocities vx, vy, ω. Points at (x, y) from its centre, the floor below.
Dense planar_body(double mass, double inertia, const std::vector<std::pair<double, double>>& points, Vector u) {
  Dense body{3, {1 / mass, 0, 0, 0, 1 / mass, 0, 0, 0, 1 / inertia}, {}, std::move(u)};
  for (const auto& [x, y] : points) {
    const Vector rows{0, 1, x, 1, 0, -y, 0, 0, 0};
    body.J.insert(body.J.end(), rows.begin(), rows.end());
  }
  return body;
}

// Balls in a row, of unit mass, each touching its neighbours.
Dense balls(const Vector& u) {
  const std::size_t n = u.size();
  Dense row{n, Vector(n * n, 0.0), {}, u};
  for (std::size_t i = 0; i < n; ++i) row.inverse[i * n + i] = 1;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    Vector rows(3 * n, 0.0);
    rows[i] = -1, rows[i + 1] = 1;
    row.J.insert(row.J.end(), rows.begin(), rows.end());
  }
  return row;
}

Vector all(double e, std::size_t points) { return Vector(points, e); }

}  // namespace

TEST_CASE("impact: a rod that falls on its end, with every restitution") {
  Prng random(1);
  for (int k = 0; k < 300; ++k) {
    const double angle = random.uniform(0, 1.5), v = random.uniform(0.1, 3), w = random.uniform(-3, 3), e = random.unit();
    const double vx = random.uniform(-2, 2), x = -0.5 * std::cos(angle), y = -0.5 * std::sin(angle);
    const Dense rod = planar_body(1, 1.0 / 12, {{x, y}}, {vx, -v, w});
    const double un = -v + x * w;
    System system = rod.system(0);
    ImpactLaw law;
    REQUIRE(law.apply(system, all(e, 1)).solved);
    const double square = std::cos(angle) * std::cos(angle), N = un < 0 ? (1 + e) * -un / (1 + 3 * square) : 0;
    CHECK(std::fabs(system.r[0] - N) * (1 + 3 * square) < 1e-13 * std::max(std::fabs(system.b[0]), std::fabs(system.b[1])));
    const double lost = un < 0 ? (1 - e * e) * un * un / (2 * (1 + 3 * square)) : 0;
    CHECK(std::fabs(system.energy_change() + lost) < 1e-14 * (1 + lost));
  }
}

TEST_CASE("impact: Housner's rocking block") {
  for (const auto& [width, height] : {std::pair{0.3, 1.0}, {0.5, 1.0}, {0.8, 1.0}, {1.6, 1.0}, {2.0, 1.0}}) {
    const double alpha = std::atan(width / height), a = width / 2, h = height / 2;
    // It rotates about its left corner until the right one hits.
    const double omega = -1;
    const Dense block =
        planar_body(1, (width * width + height * height) / 12, {{-a, -h}, {a, -h}}, {-h * omega, a * omega, omega});
    System system = block.system(1e9);
    ImpactLaw law;
    REQUIRE(law.apply(system, all(0, 2)).solved);
    const double ratio = std::max(0.0, 1 - 1.5 * std::sin(alpha) * std::sin(alpha));
    CHECK(std::fabs(block.after(system)[2] / omega - ratio) < 1e-13);
  }
}

TEST_CASE("impact: the foot of a rimless wheel that leaves the ground has no impulse") {
  const int n = 10;
  const double L = 0.8, J = 0.3, m = 1, I = J * m * L * L, a = std::numbers::pi / n;
  const double omega = -1.6;  // about the old foot, at +a from the vertical through the hub
  const double x0 = -L * std::sin(a), x1 = L * std::sin(a), y = -L * std::cos(a);
  // The velocity of the hub about the old foot, at (x0, y) from it.
  const Dense wheel = planar_body(m, I, {{x0, y}, {x1, y}}, {omega * y, -omega * x0, omega});
  System system = wheel.system(1e9);
  ImpactLaw law;
  REQUIRE(law.apply(system, all(0, 2)).solved);
  const double eta = (I + m * L * L * std::cos(2 * a)) / (I + m * L * L);
  CHECK(std::fabs(wheel.after(system)[2] / omega - eta) < 1e-13);
  CHECK(std::fabs(system.r[0]) < 1e-14);
}

TEST_CASE("impact: Newton's cradle, together and in turn") {
  ImpactLaw law;
  const auto after = [&](const Vector& u, double e, Simultaneous how) {
    const Dense row = balls(u);
    System system = row.system(0);
    REQUIRE(law.apply(system, all(e, u.size() - 1), how).solved);
    return row.after(system);
  };
  const Vector one = after({1, 0, 0}, 1, Simultaneous::together);
  CHECK(one[0] == doctest::Approx(-1.0 / 3).epsilon(1e-13));
  CHECK(one[1] == doctest::Approx(2.0 / 3).epsilon(1e-13));
  CHECK(one[2] == doctest::Approx(2.0 / 3).epsilon(1e-13));
  const Vector two = after({1, 0, 0}, 1, Simultaneous::in_turn);
  CHECK(two == Vector{0, 0, 1});
  const Vector half = after({1, 0, 0}, 0.5, Simultaneous::in_turn);
  CHECK(half[0] == doctest::Approx(0.203125).epsilon(1e-14));
  CHECK(half[1] == doctest::Approx(0.234375).epsilon(1e-14));
  CHECK(half[2] == doctest::Approx(0.5625).epsilon(1e-14));
  const Vector five = after({1, 1, 0, 0, 0}, 1, Simultaneous::in_turn);
  CHECK(five == Vector{0, 0, 0, 1, 1});
}

TEST_CASE("impact: a sphere that meets a wall at an angle sticks or slips") {
  Prng random(2);
  for (int k = 0; k < 500; ++k) {
    const double m = random.uniform(0.5, 2), radius = random.uniform(0.1, 1), J = 0.4 * m * radius * radius;
    // Velocities vx, vy, vz, ωx, ωy, ωz; the floor's normal is z.
    Dense ball{6, Vector(36, 0.0), {}, {}};
    for (std::size_t i = 0; i < 3; ++i) ball.inverse[i * 7] = 1 / m, ball.inverse[(i + 3) * 7] = 1 / J;
    ball.J = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -radius, 0, 0, 1, 0, radius, 0, 0};
    for (int i = 0; i < 6; ++i) ball.u.push_back(random.uniform(-1, 1));
    ball.u[2] = -random.uniform(0.1, 2);
    const double mu = random.uniform(0, 0.6);
    System system = ball.system(mu);
    ImpactLaw law;
    REQUIRE(law.apply(system, all(0, 1)).solved);
    const double N = m * -ball.u[2], speed = std::hypot(system.b[1], system.b[2]);
    const double needed = m * speed * 2 / 7;  // 7/2 is the mobility of the tangent, in 1/m
    const double friction = std::hypot(system.r[1], system.r[2]);
    CHECK(system.r[0] == doctest::Approx(N).epsilon(1e-13));
    CHECK(friction == doctest::Approx(std::min(mu * N, needed)).epsilon(1e-12));
    CHECK(system.state(0) == (mu == 0 || mu * N < needed ? PointState::slip : PointState::stick));
    CHECK(std::fabs(system.r[1] * system.b[2] - system.r[2] * system.b[1]) < 1e-13 * (1 + friction));
    CHECK(system.r[1] * system.b[1] + system.r[2] * system.b[2] <= 0);
  }
}

TEST_CASE("impact: 10000 random impacts obey the law and never gain energy") {
  Prng random(3);
  int reduced = 0, sticking = 0, sliding = 0, separated = 0, failed = 0;
  double worst = 0, gained = 0;
  for (int k = 0; k < 10000; ++k) {
    const auto n = static_cast<std::size_t>(random.integer(3, 9)), points = static_cast<std::size_t>(random.integer(1, 6));
    Dense m{n, Vector(n * n, 0.0), {}, {}};
    Vector L(n * n);
    for (double& x : L) x = random.uniform(-1, 1);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t a = 0; a < n; ++a) m.inverse[i * n + j] += L[i * n + a] * L[j * n + a];
        if (i == j) m.inverse[i * n + j] += 0.05;
      }
    for (std::size_t i = 0; i < 3 * points * n; ++i) m.J.push_back(random.uniform(-1, 1));
    for (std::size_t i = 0; i < n; ++i) m.u.push_back(random.uniform(-1, 1));
    Vector e;
    System system = m.system(0);
    for (PointLaw& law : system.laws) law.friction = random.chance(0.2) ? 0 : random.uniform(0.05, 1), e.push_back(random.unit());
    ImpactLaw law;
    const ImpactResult result = law.apply(system, e, random.chance(0.3) ? Simultaneous::in_turn : Simultaneous::together);
    if (!result.solved) {
      ++failed;
      continue;
    }
    separated += result.separated ? 1 : 0;
    reduced += result.scale < 1 ? 1 : 0;
    gained = std::max(gained, system.energy_change());
    Vector w;
    system.velocities(w);
    double size = 0;
    for (const double x : system.b) size = std::max(size, std::fabs(x));
    for (std::size_t i = 0; i < points; ++i) {
      const double* const r = system.r.data() + 3 * i;
      CHECK(r[0] >= 0);
      worst = std::max(worst, -w[3 * i] / size);
      (system.state(i) == PointState::stick ? sticking : sliding) += r[0] > 0 ? 1 : 0;
      // What each phase obeys, their sum obeys.
      CHECK(std::hypot(r[1], r[2]) <= system.laws[i].friction * r[0] * (1 + 1e-12) + 1e-14);
    }
  }
  CHECK(failed == 0);
  CHECK(separated == 0);
  CHECK(worst < 1e-10);
  CHECK(gained <= 1e-13);
  CHECK(reduced > 100);
  CHECK(sticking > 1000);
  CHECK(sliding > 1000);
}
