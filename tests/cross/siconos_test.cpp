// Contact solvers against Siconos, which has the same law: Coulomb friction and Signorini's conditions, for the same A and b.
// Velocities are unique without friction, forces where A is regular. With friction several solutions may exist, so that each one
// is judged by Siconos' measure of how much it violates the law.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Dense>

#include <momentree/contact/impact.hpp>
#include <tests/cross/contact_piles.hpp>
#include <tests/cross/contact_problems.hpp>
#include <tests/cross/siconos.hpp>

namespace momentree::peers {
namespace {

using Array = std::vector<double>;

double largest(const Array& x) {
  double most = 0;
  for (const double value : x) most = std::max(most, std::fabs(value));
  return most;
}
double difference(const Array& x, const Array& y) {
  double most = 0;
  for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::fabs(x[i] - y[i]));
  return most;
}
Array velocities(const contact::System& system) {
  Array w;
  system.velocities(w);
  return w;
}
bool regular(const contact::System& system) {
  const auto n = static_cast<Eigen::Index>(system.unknowns());
  const Eigen::MatrixXd A = Eigen::Map<const Eigen::MatrixXd>(system.A.data(), n, n);
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
  return values(0) > 1e-6 * values(n - 1);
}

}  // namespace

TEST_CASE("Siconos: impulses and forces of random mechanisms with loops, locks and redundant points") {
  constexpr double solved = 1e-10;
  int problems = 0, points = 0, loops = 0, locks = 0, redundant = 0;
  int unsolved = 0, theirs_unsolved = 0, frictionless = 0, alike = 0, other_solution = 0, forces = 0;
  double worst_error = 0, worst_velocity = 0, worst_force = 0;
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    const ContactProblem problem = random_problem(seed);
    const double size = largest(problem.system.b);
    if (!(size > 0)) continue;
    CAPTURE(seed);
    ++problems, points += static_cast<int>(problem.system.points());
    loops += problem.loops ? 1 : 0, locks += problem.locks ? 1 : 0;
    const bool is_regular = regular(problem.system);
    redundant += is_regular ? 0 : 1;

    contact::System ours = problem.system;
    const Siconos siconos(problem.system);
    if (!ours.solve()) {
      ++unsolved;
      continue;
    }
    const double error = siconos.error(ours.r);
    CHECK(error <= solved);
    worst_error = std::max(worst_error, error);

    const Siconos::Answer theirs = siconos.solve(Array(ours.r.size(), 0.0), 1000);
    if (!(theirs.error <= solved)) {
      ++theirs_unsolved;
      continue;
    }
    const double apart = difference(velocities(ours), theirs.w) / size;
    if (!problem.friction) {
      ++frictionless;
      CHECK(apart <= 1e-8);
    }
    if (apart > 1e-8) {
      ++other_solution;
      continue;
    }
    ++alike, worst_velocity = std::max(worst_velocity, apart);
    if (!is_regular || !(largest(ours.r) > 0)) continue;
    ++forces, worst_force = std::max(worst_force, difference(ours.r, theirs.r) / largest(ours.r));
  }
  MESSAGE(problems, " problems, ", points, " points; violation ", worst_error, "; velocities ", worst_velocity, ", forces ",
          worst_force, "; other solutions ", other_solution, ", unsolved ", unsolved, ", by Siconos ", theirs_unsolved);
  CHECK(worst_force <= 1e-9);  // velocities are found to 5e-14
  CHECK(problems > 4000);
  CHECK(loops > 1500);
  CHECK(locks > 1500);
  CHECK(redundant > 2500);
  CHECK(frictionless > 700);
  CHECK(forces > 200);
  CHECK(alike > 3700);
  CHECK(other_solution < problems / 10);
  CHECK(unsolved <= 10);
  CHECK(theirs_unsolved < problems / 100);
}

TEST_CASE("Siconos: piles of boxes, by the solver of impacts") {
  const Vec3 size{0.4, 0.4, 0.3};
  int with_friction = 0, separated = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    CAPTURE(seed);
    oracle::Prng random(seed);
    const double friction = seed % 2 == 0 ? 0 : random.uniform(0.1, 0.8);
    const int height = random.integer(1, 4), boxes = random.integer(height, 7);
    const World world(pile(random, boxes, height, size), Variables::velocities);
    contact::System ours = dense(points_of_step(world, points_of(world, contact::box(size), 1e-9), friction));
    const Siconos siconos(ours);
    contact::ImpactLaw law;
    const contact::ImpactResult result = law.apply(ours, Array(ours.points(), 0.0));
    REQUIRE(result.solved);
    with_friction += friction > 0 ? 1 : 0;
    if (friction > 0 && result.separated) {
      ++separated;
      continue;
    }
    CHECK(siconos.error(ours.r) <= 1e-12);
    if (friction > 0) continue;
    REQUIRE_FALSE(result.separated);
    const Siconos::Answer theirs = siconos.solve(Array(ours.r.size(), 0.0), 1000);
    REQUIRE(theirs.error <= 1e-12);
    CHECK(difference(velocities(ours), theirs.w) <= 1e-10 * largest(ours.b));
  }
  MESSAGE("taken in turn: ", separated, " of ", with_friction);
  CHECK(with_friction == 50);
  CHECK(separated == 0);
}

TEST_CASE("Siconos: piles of 30 to 100 boxes, by the solver of time steps") {
  const Vec3 size{0.4, 0.4, 0.3};
  std::size_t most_points = 0;
  for (std::uint64_t seed = 0; seed < 16; ++seed) {
    CAPTURE(seed);
    oracle::Prng random(seed);
    const double friction = seed % 2 == 0 ? 0 : random.uniform(0.1, 0.8);
    const int height = random.integer(1, 4), boxes = random.integer(30, 100);
    const World world(pile(random, boxes, height, size), Variables::velocities);
    contact::ManyPoints ours = points_of_step(world, points_of(world, contact::box(size), 1e-9), friction);
    const Siconos siconos(dense(ours));
    ours.solve();
    most_points = std::max(most_points, ours.points.size());
    const double points = std::sqrt(static_cast<double>(ours.points.size())), error = siconos.error(ours.r) / points;
    MESSAGE(boxes, " boxes, ", ours.points.size(), " points, friction ", friction, ": violation ", error);
    CHECK(error <= 1e-11);
    if (friction > 0) continue;
    const Siconos::Answer theirs = siconos.solve(ours.r, 1000);
    REQUIRE(theirs.error <= 1e-10);
    Array w;
    ours.velocities(w);
    MESSAGE("velocities ", difference(w, theirs.w) / largest(ours.b));
    CHECK(difference(w, theirs.w) <= 1e-9 * largest(ours.b));
  }
  CHECK(most_points > 300);
}

}  // namespace momentree::peers
