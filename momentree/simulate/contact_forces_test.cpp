// Forces of contacts, gaps of bodies, and conditions of both.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

Model box_above_floor(double height, double slope = 0, double restitution = 0) {
  Model model({.gravity = {9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)}});
  const BodyId box = model.add({.name = "box/box",
                                .mass = 2,
                                .com = {0.05, 0, 0},
                                .inertia = diagonal(0.02),
                                .joint = Free{},
                                .q = {0, 0, 0.1 + height, 1, 0, 0, 0}});
  model.add_collider({.body = box, .solid = contact::box({0.4, 0.4, 0.2})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 0.6, .static_friction = 0.6, .restitution = restitution}});
  return model;
}

const Event* event_named(const Simulation& sim, const std::string& name) {
  for (const Event& event : sim.events())
    if (event.name == name) return &event;
  return nullptr;
}

}  // namespace

TEST_CASE("contact forces: a box at rest is carried, also on a slope, located or stepped through") {
  for (const char* method : {"rk4", "dop853", "stepping"})
    for (const double slope : {0.0, 0.3}) {
      CAPTURE(method);
      CAPTURE(slope);
      Simulation sim(box_above_floor(0.01, slope), {.method = method, .step = 1e-3});
      REQUIRE(sim.run_until(1));
      Vec3 force{}, moment{};
      const BodyMotion& box = sim.world().motions()[0];
      const Vec3 centre = box.pose * Vec3{0.05, 0, 0};
      for (const ContactPoint& point : sim.world().contacts()) {
        CHECK(point.one.index == 0);
        CHECK(point.other == ground);
        CHECK(norm(point.normal - Vec3{0, 0, 1}) < 1e-6);
        CHECK(dot(point.force, point.normal) >= 0);
        force += point.force, moment += cross(point.point - centre, point.force);
      }
      CHECK(norm(force - 2 * 9.81 * Vec3{-std::sin(slope), 0, std::cos(slope)}) < 1e-4);
      CHECK(norm(moment) < 1e-4);
      CHECK(std::fabs(sim.world().gap({0}, ground)->distance) < 1e-9);
    }
}

TEST_CASE("contact forces: corners share a load without pulling, wherever the centre of mass is") {
  // The second one is beyond the line between two corners: the least forces of four corners would pull at one.
  for (const Vec3& com : {Vec3{0.1, 0.03, 0.02}, Vec3{0.16, 0.12, -0.05}}) {
    Model model;
    const BodyId box = model.add({.name = "box/box",
                                  .mass = 2,
                                  .com = com,
                                  .inertia = diagonal(0.03, 0.04, 0.05),
                                  .joint = Free{},
                                  .q = {0, 0, 0.1, 1, 0, 0, 0}});
    model.add_collider({.body = box, .solid = contact::box({0.4, 0.3, 0.2})});
    model.add_collider({.plane = true});
    Simulation sim(model);
    REQUIRE(sim.run_until(0.1));
    Vec3 force{}, moment{};
    for (const ContactPoint& c : sim.world().contacts()) {
      CHECK(c.force.z > -1e-9);
      force += c.force, moment += cross(c.point - sim.world().motions()[0].pose * com, c.force);
    }
    CHECK(norm(force - Vec3{0, 0, 2 * 9.81}) < 1e-12);
    CHECK(norm(moment) < 1e-12);
  }
}

TEST_CASE("contact conditions fire at the instants of closed forms") {
  const double lands = std::sqrt(2 * 0.5 / 9.81), speed = 9.81 * lands;
  const auto fires = [&](const Condition& condition) {
    Simulation sim(box_above_floor(0.5), {.method = "dop853"});
    sim.when(condition).then(impulse("box/box", {0, 0, 0})).named("now");
    REQUIRE(sim.run_until(1));
    const Event* const event = event_named(sim, "now");
    return event != nullptr ? event->time : -1;
  };
  CHECK(std::fabs(fires(touching("box/box", "ground")) - lands) < 1e-9);
  CHECK(std::fabs(fires(gap_between("box/box", "ground").below(0.2)) - std::sqrt(2 * 0.3 / 9.81)) < 1e-9);
  // All four corners hit at once; the centre of mass is aside, so that friction and rotation take part, and nothing bounces.
  CHECK(std::fabs(fires(contact_impulse_between("ground", "box/box").exceeds(0.9 * 2 * speed)) - lands) < 1e-9);
  CHECK(fires(contact_impulse_between("ground", "box/box").exceeds(1.1 * 2 * speed)) == -1);
  CHECK(std::fabs(fires(contact_force_between("box/box", "ground").exceeds(0.9 * 2 * 9.81)) - lands) < 1e-9);
  CHECK(fires(contact_force_between("box/box", "ground").exceeds(1.1 * 2 * 9.81)) == -1);
  CHECK(fires(slip_between("box/box", "ground").exceeds(1e-3)) == -1);
}

TEST_CASE("contact conditions: slip on a slope reaches a speed when Coulomb's law says") {
  Simulation sim(box_above_floor(0, 0.7), {.method = "dop853"});
  sim.when(slip_between("box/box", "ground").exceeds(0.5)).then(impulse("box/box", {0, 0, 0})).named("fast");
  REQUIRE(sim.run_until(1));
  const Event* const fast = event_named(sim, "fast");
  REQUIRE(fast != nullptr);
  const double acceleration = 9.81 * (std::sin(0.7) - 0.6 * std::cos(0.7));
  CHECK(std::fabs(fast->time - 0.5 / acceleration) < 1e-8);
}
