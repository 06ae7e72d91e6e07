// Islands that rest under time stepping: they stay where they are to the bit, wake when anything changes, and move as they would
// if they had been stepped all the time.
#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/run_state.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using oracle::Prng;

namespace {

const Integration stepping{.method = "stepping", .step = 1e-3};

// Columns of boxes on a floor, and a ball that rolls or flies into one of them. `stepped`: a force of zero on each body, so that
// none of them is left out of any step.
Model columns_and_ball(Prng random, bool stepped, const Vec3& velocity) {
  Model model;
  const auto add = [&](std::string name, const Vec3& at, const Vec3& v, contact::Solid solid, double mass) {
    const BodyId body = model.add({.name = std::move(name),
                                   .mass = mass,
                                   .inertia = diagonal(0.006 * mass),
                                   .joint = Free{},
                                   .q = {at.x, at.y, at.z, 1, 0, 0, 0},
                                   .v = {v.x, v.y, v.z, 0, 0, 0}});
    model.add_collider({.body = body, .solid = std::move(solid)});
    if (stepped) model.add_force({.body = body});
  };
  for (int column = 0; column < 3; ++column)
    for (int k = 0; k < 3; ++k)
      add("box" + std::to_string(3 * column + k), {0.5 * column, random.uniform(-0.02, 0.02), 0.1 + 0.2 * k + 1e-3 * (k + 1)}, {},
          contact::box({0.2, 0.2, 0.2}), 1);
  add("ball", {-1.5, 0, 0.3}, velocity, contact::sphere(0.08), 0.5);
  model.add_collider({.plane = true});
  return model;
}

bool same_state(const Simulation& a, const Simulation& b) {
  return std::ranges::equal(a.world().state().q(), b.world().state().q()) &&
         std::ranges::equal(a.world().state().u(), b.world().state().u());
}

}  // namespace

TEST_CASE("resting islands: boxes that have come to rest stay there to the bit, with the forces that carry them") {
  Simulation sim(columns_and_ball(Prng(1), false, {}), stepping);
  REQUIRE(sim.run_until(1));
  const std::vector<double> before(sim.world().state().q().begin(), sim.world().state().q().end());
  REQUIRE(sim.run_until(10));
  CHECK(std::ranges::equal(sim.world().state().q(), before));
  CHECK(std::ranges::all_of(sim.world().state().u(), [](double u) { return u == 0; }));
  double carried = 0;
  for (const ContactPoint& point : sim.world().contacts())
    if (point.other == ground) carried += point.force.z;
  CHECK(carried == doctest::Approx(9.5 * 9.81).epsilon(1e-9));
  CHECK(std::fabs(sim.energy().error) < 1e-9);
}

TEST_CASE("resting islands: what a ball hits moves as if it had been stepped all the time") {
  for (int k = 0; k < 10; ++k) {
    const Vec3 velocity{1 + 0.4 * k, 0, 0.5};
    Simulation sim(columns_and_ball(Prng(static_cast<unsigned>(k)), false, velocity), stepping);
    Simulation all(columns_and_ball(Prng(static_cast<unsigned>(k)), true, velocity), stepping);
    // Before it arrives two columns rest. Afterwards boxes tumble, which rounding decides in the long run.
    const double arrives = 2.1 / velocity.x;
    REQUIRE(sim.run_until(arrives));
    REQUIRE(all.run_until(arrives));
    double apart = 0;
    for (std::size_t b = 0; b < 10; ++b)
      apart = std::max(apart, norm(sim.world().motions()[b].linear - all.world().motions()[b].linear));
    CHECK(apart < 1e-4 * norm(velocity));  // the accuracy of steps in which bodies hit each other
    double moved = 0;
    for (std::size_t b = 0; b < 3; ++b) moved = std::max(moved, std::fabs(sim.world().motions()[b].pose.position.x));
    CHECK(moved > 1e-7);  // the first column was hit
    REQUIRE(sim.run_until(4));
    CHECK(sim.energy().lost_in_impacts > 0);
    CHECK(std::fabs(sim.energy().error) < 1e-6);
  }
}

TEST_CASE("resting islands: gravity, impulses and lost supports wake them") {
  Simulation sim(columns_and_ball(Prng(2), false, {}), stepping);
  REQUIRE(sim.run_until(1));
  sim.set_gravity({0, 9, -9.81});  // steeper than friction holds
  REQUIRE(sim.run_until(1.2));
  for (std::size_t b = 0; b < 9; ++b) CHECK(sim.world().motions()[b].linear.y > 0.1);

  Simulation other(columns_and_ball(Prng(2), false, {}), stepping);
  REQUIRE(other.run_until(1));
  other.remove(other.world().model().body("box0"));
  REQUIRE(other.run_until(1.1));
  for (const std::size_t b : {1u, 2u}) CHECK(other.world().motions()[b].linear.z == doctest::Approx(-0.981).epsilon(0.02));
  for (const std::size_t b : {3u, 4u, 5u}) CHECK(norm(other.world().motions()[b].linear) == 0);
}

// A box that a belt presses against a wall does not move, but the belt works: μ m g times its speed.
TEST_CASE("resting islands: a body that stands still on a running belt is stepped, so that the work of the belt is known") {
  constexpr double mu = 0.4, mass = 2, speed = 0.5;
  Model model;
  const BodyId box =
      model.add({.name = "box", .mass = mass, .inertia = diagonal(0.02), .joint = Free{}, .q = {0, 0, 0.1, 1, 0, 0, 0}});
  model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
  model.add_collider({.solid = contact::box({0.2, 2, 2}, Pose(Vec3{0.2, 0, 0}))});
  contact::Solid belt;
  belt.belt = {0, speed, 0};
  model.add_collider({.solid = std::move(belt), .plane = true});
  model.add_contact_rule({.law = {.friction = mu, .static_friction = mu}});
  Simulation sim(model, stepping);
  REQUIRE(sim.run_until(1));
  const double before = sim.energy().work, x = sim.world().motions()[0].pose.position.x;
  REQUIRE(sim.run_until(2));
  CHECK(sim.world().motions()[0].pose.position.x == doctest::Approx(x));
  CHECK(sim.energy().work - before > 0.5 * mu * mass * 9.81 * speed);
}

TEST_CASE("resting islands: a run that is restored, or continued from its state, goes on to the bit") {
  const Vec3 velocity{1.1, 0, 0.5};
  for (const double at : {0.4, 0.9, 1.25}) {
    const auto make = [&] { return Simulation(columns_and_ball(Prng(3), false, velocity), stepping); };
    Simulation through = make(), continued = make();
    REQUIRE(through.run_until(at));
    REQUIRE(continued.run_until(at));
    const RunState state = continued.run_state();
    REQUIRE(through.run_until(2));
    Simulation again = make();
    again.continue_from(state);
    REQUIRE(again.run_until(2));
    CHECK(same_state(again, through));
  }
}
