// Torsional and rolling friction: closed forms of balls, thresholds, momentum, and what reported moments explain.
#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using oracle::Prng;

namespace {

constexpr double g = 9.81;

struct RollingBall {
  double mass, inertia, radius;
  Vec3 velocity, spin;
};

Simulation simulation_of(const RollingBall& ball, const ContactLaw& law, double slope, const Integration& how) {
  Model model({.gravity = {g * std::sin(slope), 0, -g * std::cos(slope)}});
  const BodyId body =
      model.add({.name = "ball",
                 .mass = ball.mass,
                 .inertia = diagonal(ball.inertia),
                 .joint = Free{},
                 .q = {0, 0, ball.radius, 1, 0, 0, 0},
                 .v = {ball.velocity.x, ball.velocity.y, ball.velocity.z, ball.spin.x, ball.spin.y, ball.spin.z}});
  model.add_collider({.body = body, .solid = contact::sphere(ball.radius)});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = law});
  return Simulation(model, how);
}

const BodyMotion& motion_of(const Simulation& sim) { return sim.world().motions()[0]; }

}  // namespace

// m v' = −T, I ω' = T R − ρ m g with v = ω R.
TEST_CASE("rolling friction: a ball rolls out as the closed form says, whatever the method") {
  Prng random(1);
  for (int k = 0; k < 40; ++k) {
    const double m = random.uniform(0.1, 5), R = random.uniform(0.02, 0.5), I = random.uniform(0.1, 0.6) * m * R * R;
    const double rolling = random.uniform(0.001, 0.05) * R, v = random.uniform(0.1, 1), turn = random.uniform(-3, 3);
    const Vec3 along{std::cos(turn), std::sin(turn), 0};
    const RollingBall ball{m, I, R, v * along, v / R * cross(Vec3{0, 0, 1}, along)};
    const double slows = rolling * g / (R * (1 + I / (m * R * R))), stops = v / slows;
    Integration how;
    how.method = k % 2 == 0 ? "stepping" : "dop853";
    Simulation sim = simulation_of(ball, {.friction = 0.5, .static_friction = 0.5, .rolling = rolling}, 0, how);
    REQUIRE(sim.run_until(0.5 * stops) == Status::ok);
    CHECK(norm(motion_of(sim).linear - 0.5 * v * along) < 1e-9);
    CHECK(norm(motion_of(sim).angular - 0.5 * v / R * cross(Vec3{0, 0, 1}, along)) < 1e-8 / R);
    const ContactPoint point = sim.world().contacts().at(0);
    CHECK(norm(point.moment + rolling * m * g * cross(Vec3{0, 0, 1}, along)) < 1e-7 * m * g * R);
    REQUIRE(sim.run_until(1.1 * stops) == Status::ok);
    CHECK(norm(motion_of(sim).linear) < 1e-9);
    CHECK(norm(motion_of(sim).pose.position - Vec3{0, 0, R} - 0.5 * v * stops * along) < 1e-3 * v);
    if (how.method == "dop853") {
      const auto begins = std::ranges::find(sim.events(), "stepping", &Event::name);
      REQUIRE(begins != sim.events().end());
      CHECK(begins->reason == "torsional or rolling friction");
    }
  }
}

// I ω' = −γ m g.
TEST_CASE("torsional friction: a ball that spins about the normal stops as the closed form says") {
  Prng random(2);
  for (int k = 0; k < 40; ++k) {
    const double m = random.uniform(0.1, 5), R = random.uniform(0.02, 0.5), I = random.uniform(0.1, 0.6) * m * R * R;
    const double torsional = random.uniform(0.001, 0.05) * R, spin = random.uniform(-20, 20);
    const double slows = torsional * m * g / I, stops = std::fabs(spin) / slows;
    Integration how;
    how.method = "stepping";
    Simulation sim =
        simulation_of({m, I, R, {}, {0, 0, spin}}, {.friction = 0.5, .static_friction = 0.5, .torsional = torsional}, 0, how);
    REQUIRE(sim.run_until(0.5 * stops) == Status::ok);
    CHECK(norm(motion_of(sim).angular - Vec3{0, 0, 0.5 * spin}) < 1e-8 / R);
    REQUIRE(sim.run_until(1.2 * stops) == Status::ok);
    CHECK(norm(motion_of(sim).angular) < 1e-9 / R);
    CHECK(std::fabs(sim.energy().error) < 1e-9 * (I * spin * spin + m * g * R));
  }
}

TEST_CASE("rolling friction: a ball on a slope rests up to the angle whose tangent is the moment over the radius") {
  Prng random(3);
  for (int k = 0; k < 30; ++k) {
    const double R = random.uniform(0.05, 0.3), m = random.uniform(0.1, 3), rolling = random.uniform(0.01, 0.1) * R;
    for (const double off : {-1e-6, 1e-6}) {
      const double slope = std::atan(rolling / R * (1 + off));
      Integration how;
      how.method = "stepping";
      Simulation sim = simulation_of({m, 0.4 * m * R * R, R, {}, {}},
                                     {.friction = 0.9, .static_friction = 0.9, .rolling = rolling}, slope, how);
      REQUIRE(sim.run_until(1) == Status::ok);
      const double moved = motion_of(sim).pose.position.x;
      if (off < 0) CHECK(std::fabs(moved) < 1e-10);
      const double expected = 0.5 * g * (std::sin(slope) - rolling / R * std::cos(slope)) / 1.4;
      if (off > 0) CHECK(moved == doctest::Approx(expected).epsilon(0.01));
    }
  }
}

TEST_CASE("torsional friction: two free bodies keep their angular momentum, and no energy is gained") {
  Prng random(4);
  for (int k = 0; k < 30; ++k) {
    Model model({.gravity = {}});
    for (const double x : {-0.1, 0.1}) {
      const Vec3 w{random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
      const BodyId body = model.add({.name = x < 0 ? "a" : "b",
                                     .mass = random.uniform(0.5, 3),
                                     .inertia = diagonal(random.uniform(0.002, 0.02)),
                                     .joint = Free{},
                                     .q = {1.1 * x, 0, 0, 1, 0, 0, 0},
                                     .v = {-10 * x, random.uniform(-0.3, 0.3), 0, w.x, w.y, w.z}});
      model.add_collider({.body = body, .solid = contact::sphere(0.1)});
    }
    model.add_contact_rule({.law = {.friction = 0.4,
                                    .static_friction = 0.4,
                                    .torsional = random.uniform(0, 0.05),
                                    .rolling = random.uniform(0, 0.05),
                                    .restitution = random.chance(0.5) ? 0.0 : 0.4}});
    Simulation sim(model, {.method = "stepping", .step = 1e-5});
    const Totals before = sim.world().totals();
    REQUIRE(sim.run_until(0.02) == Status::ok);
    const Totals after = sim.world().totals();
    CHECK(norm(after.linear - before.linear) < 1e-12);
    CHECK(norm(after.angular - before.angular) < 1e-5);  // points move in a step
    CHECK(after.kinetic < before.kinetic);
  }
}

TEST_CASE("torsional and rolling friction: lengths that are negative or not finite are refused") {
  Model model;
  for (const double length : {-1e-3, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    CHECK_THROWS(model.add_contact_rule({.law = {.torsional = length}}));
    CHECK_THROWS(model.add_contact_rule({.law = {.rolling = length}}));
  }
}
