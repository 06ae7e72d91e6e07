// Surfaces that run, as conveyor belts, rollers and tracks do: closed forms of motion, and the work of belts.
#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/contact/contact_test_support.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;
using testing::box_mass;
using testing::friction;
using testing::g;

namespace {

constexpr double speed = 1.5;                                  // of belts (m/s)
constexpr double slips = speed / (friction * g);               // until a box has this speed (s)
constexpr double energy = 0.5 * box_mass * speed * speed;      // and then this energy (J)
constexpr double behind = 0.5 * friction * g * slips * slips;  // of the belt, when it sticks (m)
const char* const located_methods[] = {"rk4", "dopri5", "dop853"};

/// A box of contact_test_support.hpp that lies on a belt along x: the floor, a fixed box, or its own tracks.
enum class Belt { floor, box, tracks };
Model box_on_belt(Belt belt, double above = 0) {
  Model model({.gravity = {0, 0, -g}});
  const BodyId box = model.add(
      {.name = "load/box", .mass = box_mass, .inertia = diagonal(0.02), .joint = Free{}, .q = {0, 0, 0.1 + above, 1, 0, 0, 0}});
  contact::Solid load = contact::box({0.4, 0.4, 0.2}), surface = contact::box({40, 2, 1});
  (belt == Belt::tracks ? load : surface).belt = {0, speed, 0};  // below, where tracks touch, they run backwards
  model.add_collider({.body = box, .solid = load});
  if (belt == Belt::box) {
    const BodyId bed = model.add({.name = "bed/bed", .mass = 1, .inertia = diagonal(1), .at = {0, 0, -0.5}, .joint = Weld{}});
    model.add_collider({.body = bed, .solid = surface});
  } else {
    model.add_collider({.solid = surface, .plane = true});
  }
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  return model;
}

double count(const Simulation& sim, const std::string& name) {
  return static_cast<double>(std::ranges::count_if(sim.events(), [&](const Event& e) { return e.name == name; }));
}

}  // namespace

TEST_CASE("belts: a box accelerates with mu g until it has the speed of the belt, and then sticks") {
  for (const Belt belt : {Belt::floor, Belt::box, Belt::tracks})
    for (const char* const method : located_methods) {
      CAPTURE(static_cast<int>(belt));
      CAPTURE(method);
      Simulation sim(box_on_belt(belt), {.method = method, .step = 1e-2, .rtol = 1e-11, .atol = 1e-13});
      REQUIRE(sim.run_until(0.5 * slips));
      const auto velocity = [&] { return sim.world().motions()[0].linear; };
      CHECK(std::fabs(velocity().x - 0.5 * speed) < 1e-11);
      REQUIRE_FALSE(sim.world().contacts().empty());
      const Vec3 slip = sim.world().contacts()[0].slip;
      CHECK(norm(slip - Vec3{-0.5 * speed, 0, 0}) < 1e-11);
      REQUIRE(sim.run_until(1));
      const auto stick = std::ranges::find_if(sim.events(), [](const Event& e) { return e.name == "stick"; });
      REQUIRE(stick != sim.events().end());
      CHECK(std::fabs(stick->time - slips) < 1e-7 / (friction * g));  // slower slip is stopped
      CHECK(count(sim, "slip") <= 1);
      CHECK(norm(velocity() - Vec3{speed, 0, 0}) < 1e-12);
      CHECK(std::fabs(sim.world().motions()[0].pose.position.x - (behind + speed * (1 - slips))) < 1e-8);
      const EnergyBalance balance = sim.energy();
      CHECK(std::fabs(balance.dissipated + balance.lost_in_impacts - energy) < 1e-8);
      CHECK(std::fabs(balance.work - 2 * energy) < 1e-8);
      CHECK(std::fabs(balance.error) < 1e-11);
    }
}

TEST_CASE("belts: time stepping carries a box in the same way, to the order of its steps, and its energy balance closes") {
  for (const Belt belt : {Belt::floor, Belt::box, Belt::tracks})
    for (const double step : {2e-3, 1e-3}) {
      CAPTURE(static_cast<int>(belt));
      Simulation sim(box_on_belt(belt), {.method = "stepping", .step = step});
      REQUIRE(sim.run_until(1));
      CHECK(norm(sim.world().motions()[0].linear - Vec3{speed, 0, 0}) < 1e-6);
      CHECK(std::fabs(sim.world().motions()[0].pose.position.x - (behind + speed * (1 - slips))) < 2 * speed * step);
      const EnergyBalance balance = sim.energy();
      CHECK(std::fabs(balance.dissipated + balance.lost_in_impacts - energy) < 4 * energy * step / slips);
      CHECK(std::fabs(balance.work - 2 * energy) < 4 * energy * step / slips);
      CHECK(std::fabs(balance.error) < 1e-9);
    }
}

TEST_CASE("belts: a box that lands on a belt gets mu times its momentum, and the belt's part of the energy is work") {
  const double height = 0.05, fall = std::sqrt(2 * g * height), gained = friction * fall;
  for (const Belt belt : {Belt::floor, Belt::box, Belt::tracks}) {
    CAPTURE(static_cast<int>(belt));
    Simulation sim(box_on_belt(belt, height), {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
    REQUIRE(sim.run_until(1));
    const Event& impact = sim.events().front();
    REQUIRE(impact.name == "impact");
    CHECK(norm(impact.contact.impulse - Vec3{box_mass * gained, 0, box_mass * fall}) < 1e-8);
    CHECK(std::fabs(impact.work - box_mass * gained * speed) < 1e-8);
    CHECK(std::fabs(impact.lost - box_mass * (gained * speed + 0.5 * fall * fall - 0.5 * gained * gained)) < 1e-8);
    CHECK(norm(sim.world().motions()[0].linear - Vec3{speed, 0, 0}) < 1e-11);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("belts: an inclined belt lifts a box that sticks to it, by work alone") {
  const double slope = 0.3, uphill = 0.4;  // rad, m/s
  Model model({.gravity = {-g * std::sin(slope), 0, -g * std::cos(slope)}});
  static_cast<void>(testing::add_box(model, "load/box", 0.1));
  contact::Solid surface;
  surface.belt = {0, uphill, 0};
  model.add_collider({.solid = surface, .plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  const double gains = friction * g * std::cos(slope) - g * std::sin(slope), begins = uphill / gains;
  REQUIRE(gains > 0);
  Simulation sim(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
  REQUIRE(sim.run_until(begins + 0.1));
  const double before = sim.energy().work, lost = sim.energy().dissipated;
  REQUIRE(sim.run_until(begins + 1.1));
  CHECK(std::fabs(sim.energy().work - before - box_mass * g * std::sin(slope) * uphill) < 1e-9);
  CHECK(std::fabs(sim.energy().dissipated - lost) < 1e-12);
  CHECK(norm(sim.world().motions()[0].linear - Vec3{uphill, 0, 0}) < 1e-12);
}

TEST_CASE("belts: a ball whose surface runs rolls and turns without slip, and the belt's work is all that it gains") {
  Model model;
  const BodyId ball = model.add({.name = "ball",
                                 .mass = 2,
                                 .inertia = diagonal(0.03, 0.04, 0.05),
                                 .joint = Free{},
                                 .q = {0, 0, 0.2, 1, 0, 0, 0},
                                 .v = {0.3, 0, 0, 1, -0.7, 2}});
  contact::Solid solid = contact::sphere(0.2);
  solid.belt = {0.1, 0.3, -0.2};
  model.add_collider({.body = ball, .solid = solid});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 3, .static_friction = 3}});
  Simulation sim(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
  REQUIRE(sim.run_until(0.5));
  const double worked = sim.energy().work;
  for (double t = 0.6; t < 2; t += 0.1) {
    REQUIRE(sim.run_until(t));
    REQUIRE(sim.world().contacts().size() == 1);
    CHECK_FALSE(sim.world().contacts()[0].slips);
    const BodyMotion& now = sim.world().motions()[0];
    const Mat3 R = rotation_matrix(now.pose.rotation);
    const Vec3 surface = cross(Vec3{0, 0, 1}, R * solid.belt) + now.linear + cross(now.angular, Vec3{0, 0, -0.2});
    CHECK(norm(surface) < 1e-10);
  }
  CHECK(std::fabs(sim.energy().work - worked) > 1e-3);
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  CHECK(std::fabs(sim.energy().projection) < 1e-9);
}

TEST_CASE("belts: a cylinder whose surface runs is a roller") {
  // A box lies on two rollers, which are fixed: it moves as on a belt.
  Model model({.gravity = {0, 0, -g}});
  static_cast<void>(testing::add_box(model, "load/box", 0.1));
  const double half = std::sqrt(0.5);
  const Quat across{half, half, 0, 0};  // about x: along y
  for (const double x : {-0.15, 0.15}) {
    const BodyId roller = model.add(
        {.name = "rollers/" + std::to_string(x > 0), .mass = 1, .inertia = diagonal(1), .at = {x, 0, -0.05}, .joint = Weld{}});
    contact::Solid solid = contact::cylinder(0.05, 1, {{}, across});
    solid.belt = {0, speed, 0};
    model.add_collider({.body = roller, .solid = solid});
  }
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  Simulation sim(model, {.method = "dop853", .rtol = 1e-11, .atol = 1e-13});
  REQUIRE(sim.run_until(0.05));
  CHECK(norm(sim.world().motions()[0].linear - Vec3{friction * g * 0.05, 0, 0}) < 1e-9);
  CHECK(norm(sim.world().motions()[0].angular) < 1e-9);
}
