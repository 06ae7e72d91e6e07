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

namespace {

// An arm on a hinge in 0.5 m, whose tip, 0.4 m beside it, rests on the floor; a torque about the hinge lifts it.
BodyId add_resting_arm(Model& model, const Vec3& hinge, double torque_rate) {
  const BodyId arm = model.add({.name = "arm/arm",
                                .mass = 1,
                                .com = {0.25, 0, -0.25},
                                .inertia = diagonal(0.01),
                                .at = {hinge + Vec3{0, 0, 0.5}},
                                .joint = Revolute{.axis = {0, -1, 0}, .drive = effort_drive({Signal::ramp(torque_rate, 0)})}});
  model.add_collider({.body = arm, .solid = contact::sphere(0.05, {0.4, 0, -0.45})});
  return arm;
}

Model on_floor(double friction) {
  Model model({.gravity = {0, 0, -9.81}});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  return model;
}

}  // namespace

TEST_CASE("contact forces: an arm that rests with its tip on the floor is within its cone, and a torque lifts it") {
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    CAPTURE(method);
    Model model = on_floor(0.3);
    add_resting_arm(model, {}, 9.81);  // lifts it when it is m g r = 1 · 9.81 · 0.25 N m
    Simulation sim(model, {.method = method, .step = 1e-3});
    for (const double t : {0.1, 0.2}) {
      REQUIRE(sim.run_until(t));
      const std::vector<ContactPoint> contacts = sim.world().contacts();
      REQUIRE(contacts.size() == 1);
      const double N = contacts[0].force.z, T = std::hypot(contacts[0].force.x, contacts[0].force.y);
      CHECK(N > 0);
      CHECK(T <= 0.3 * N * (1 + 1e-9));
      CHECK(0.4 * N + 0.5 * contacts[0].force.x == doctest::Approx(9.81 * (0.25 - t)).epsilon(1e-9));
    }
    REQUIRE(sim.run_until(0.5));
    const Event* const lift = event_named(sim, "lift");
    REQUIRE(lift != nullptr);
    CHECK(std::fabs(lift->time - 0.25) < 1e-7);
    CHECK(sim.world().joint({0}).q[0] == doctest::Approx(0.1791).epsilon(1e-3));  // stepped through, and by rk4
  }
}

TEST_CASE("contact forces: a block that is guided on an inclined line slips when no friction can hold it") {
  // Its friction along the line raises N, which then holds up to 3.02 N across; without that, up to 2.94 N.
  for (const char* method : {"rk4", "dop853"}) {
    CAPTURE(method);
    Model model = on_floor(0.3);
    const BodyId slide = model.add({.name = "slide", .mass = 1e-3, .joint = Prismatic{.axis = y_axis}});
    const BodyId block = model.add({.name = "block",
                                    .mass = 1,
                                    .inertia = diagonal(0.01),
                                    .parent = slide,
                                    .at = {{0, 0, 0.1}},
                                    .joint = Prismatic{.axis = {0.6, 0, 0.8}}});
    model.add_collider({.body = block, .solid = contact::sphere(0.1)});
    model.add_force({.body = block, .force = {Signal{}, Signal::ramp(30, 0), Signal{}}});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.5));
    const Event* const slip = event_named(sim, "slip");
    REQUIRE(slip != nullptr);
    CHECK(slip->time > 0.098);
    CHECK(slip->time < 0.101);
    // From there with N = m g: ÿ = (30 t − 0.3 · 9.81)/1.001
    const double from = slip->time, h = 0.5 - from;
    CHECK(sim.world().joint({0}).q[0] ==
          doctest::Approx(((30 * from - 0.3 * 9.81) * h * h / 2 + 5 * h * h * h) / 1.001).epsilon(1e-6));
  }
}

TEST_CASE("contact forces: what happens at one contact does not depend on bodies far away") {
  for (const bool arm : {false, true}) {
    CAPTURE(arm);
    Model model = on_floor(0.8);
    const BodyId box =
        model.add({.name = "box", .mass = 2, .inertia = diagonal(0.02), .joint = Free{}, .q = {0, 0, 0.1, 1, 0, 0, 0}});
    model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
    if (arm) add_resting_arm(model, {3, 0, 0}, 0);
    model.add_force({.body = box, .point = {0, 0, -0.1}, .force = {Signal::ramp(20, 0), Signal{}, Signal{}}});
    Simulation sim(model, {.method = "rk4", .step = 1e-3});
    REQUIRE(sim.run_until(1.2));
    const Event* const slip = event_named(sim, "slip");
    REQUIRE(slip != nullptr);
    const double from = 0.8 * 2 * 9.81 / 20, h = 1.2 - from;
    CHECK(std::fabs(slip->time - from) < 1e-6);
    CHECK(sim.world().joint({box.index}).q[0] == doctest::Approx(20 * h * h * h / 12).epsilon(1e-5));
  }
}
