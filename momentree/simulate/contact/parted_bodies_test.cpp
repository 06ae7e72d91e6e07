// Bodies that a joint holds together do not touch each other; once it has ended, they do.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/simulate/contact/contact_test_support.hpp>

using namespace momentree;
using namespace momentree::testing;

namespace {

const std::vector<std::string> methods{"rk4", "dop853", "stepping"};

// A plate whose upper side is at 0, fixed to the ground, and a box whose lower side is at `above`, which hangs on it or is free.
Model over_plate(double above, bool hangs) {
  Model model({.gravity = {0, 0, -g}});
  const BodyId plate = model.add({.name = "plate", .mass = 10, .inertia = diagonal(1), .at = {0, 0, -0.05}});
  model.add_collider({.body = plate, .solid = contact::box({2, 2, 0.1})});
  if (hangs)
    add_box(model, "box", above + 0.15, plate, Revolute{.axis = {0, 0, 1}});
  else
    add_box(model, "box", above + 0.1);
  return model;
}

double height(const Simulation& sim, const char* body) {
  return sim.world().motions()[static_cast<std::size_t>(sim.world().model().body(body).index)].pose.position.z;
}

const Event* event_named(const Simulation& sim, const std::string& name) {
  const auto found = std::ranges::find_if(sim.events(), [&](const Event& event) { return event.name == name; });
  return found == sim.events().end() ? nullptr : &*found;
}

bool is_about(const std::vector<std::string>& warnings, const std::string& what) {
  return std::ranges::any_of(warnings, [&](const std::string& each) { return each.find(what) != std::string::npos; });
}

}  // namespace

TEST_CASE("parted: a box whose joint breaks lands on its former parent like one that was never connected to it") {
  constexpr double above = 0.35, breaks = 0.1;
  for (const std::string& method : methods) {
    CAPTURE(method);
    for (const Action& parts : {break_joint("box"), free_joint("box")}) {
      CAPTURE(parts.text());
      Simulation sim(over_plate(above, true), {.method = method, .step = 1e-3}),
          other(over_plate(above, false), sim.integration());
      sim.at(breaks).then(parts);
      sim.when(touching("box", "plate")).named("landed");
      REQUIRE(sim.run_until(breaks + 1));
      REQUIRE(other.run_until(1));
      CHECK(height(sim, "box") == doctest::Approx(0.1).epsilon(1e-6));
      CHECK(std::fabs(height(sim, "box") - height(other, "box")) < 1e-9);
      CHECK(norm(force_on(sim.world(), sim.world().model().body("box")) - Vec3{0, 0, box_mass * g}) < 1e-6);
      REQUIRE(event_named(sim, "landed") != nullptr);
      CHECK(std::fabs(event_named(sim, "landed")->time - breaks - std::sqrt(2 * above / g)) <
            (method == "stepping" ? 2e-3 : 1e-9));
      CHECK(sim.warnings().empty());
    }
  }
}

TEST_CASE("parted: bodies that overlap where their joint broke pass through each other until they are apart") {
  constexpr double depth = 0.02, speed = 1;
  for (const std::string& method : methods) {
    CAPTURE(method);
    Simulation falls(over_plate(-depth, true), {.method = method, .step = 1e-3});
    falls.at(0.1).then(break_joint("box"));
    REQUIRE(falls.run_until(1));
    CHECK(std::fabs(height(falls, "box") - (0.1 - depth - 0.5 * g * 0.81)) < 1e-9);
    const Event* const pass = event_named(falls, "pass");
    REQUIRE(pass != nullptr);
    CHECK(pass->time == 0.1);
    CHECK(pass->contact.one == "plate");
    CHECK(pass->contact.other == "box");
    CHECK(is_about(falls.warnings(), "'plate' passes through 'box' from t = 0.1 s: they overlap by 0.02 m"));

    // The same box goes up until it is apart, and lands.
    Simulation rises(over_plate(-depth, true), {.method = method, .step = 1e-3});
    rises.at(0.1).then(break_joint("box")).then(impulse("box", {0, 0, box_mass * speed}));
    rises.when(touching("box", "plate")).named("landed");
    REQUIRE(rises.run_until(0.15));
    Simulation branch = rises.branch();
    const double flight = (speed + std::sqrt(speed * speed - 2 * g * depth)) / g;
    for (Simulation* sim : {&rises, &branch}) {
      REQUIRE(sim->run_until(1));
      REQUIRE(event_named(*sim, "landed") != nullptr);
      CHECK(std::fabs(event_named(*sim, "landed")->time - 0.1 - flight) < (method == "stepping" ? 2e-3 : 1e-9));
      CHECK(height(*sim, "box") == doctest::Approx(0.1).epsilon(1e-6));
      CHECK(std::fabs(sim->energy().error) < 1e-6);
    }
  }
}

TEST_CASE("parted: of several shapes of a body, those that are apart touch") {
  Model model = over_plate(-0.02, true);
  model.add_collider({.body = model.body("box"), .solid = contact::sphere(0.1, Pose(Vec3{0, 0, 0.4}))});
  Simulation sim(model, {.method = "dop853"});
  sim.at(0.1).then(break_joint("box"));
  REQUIRE(sim.run_until(1));
  CHECK(height(sim, "box") == doctest::Approx(-0.3).epsilon(1e-9));  // it hangs on the ball
}

TEST_CASE("parted: a box that is attached to what it stands on no longer touches it") {
  constexpr double spin = 3;
  for (const std::string& method : methods) {
    CAPTURE(method);
    Simulation sim(over_plate(0, false), {.method = method, .step = 1e-3});
    sim.at(0.1).then(attach("box", "plate", Revolute{.axis = {0, 1, 0}})).named("hinge");
    REQUIRE(sim.run_until(0.05));
    CHECK(!sim.world().contacts().empty());
    REQUIRE(sim.run_until(0.15));
    CHECK(sim.world().contacts().empty());
    static_cast<void>(sim.apply(impulse("box", {}, {0, 0.02 * spin, 0})));  // its corners turn through the plate
    REQUIRE(sim.run_until(1));
    CHECK(std::fabs(sim.world().motions()[1].angular.y - spin) < 1e-9);
    CHECK(sim.warnings().empty());
  }
}

TEST_CASE("parted: bodies that a loop joint connects do not touch until it breaks") {
  for (const std::string& method : methods) {
    CAPTURE(method);
    Model model = over_plate(0.35, false);
    model.add_loop({.name = "pin", .body = model.body("box"), .to = model.body("plate"), .joint = Ball{}, .at = {0, 0, 0.5}});
    Simulation sim(model, {.method = method, .step = 1e-3});
    sim.at(0.1).then(break_joint("pin"));
    REQUIRE(sim.run_until(1));
    CHECK(height(sim, "box") == doctest::Approx(0.1).epsilon(1e-6));

    Model sunk = over_plate(-0.05, false);  // no overlap at the start
    sunk.add_loop({.name = "pin", .body = sunk.body("box"), .to = sunk.body("plate"), .joint = Ball{}, .at = {0, 0, 0.1}});
    CHECK(Simulation(sunk, {.method = method, .step = 1e-3}).run_until(0.1));
  }
}

TEST_CASE("parted: a rule that names both lets a body touch its parent while a joint connects them, and later") {
  Model model = over_plate(0.35, false);
  const BodyId box = model.body("box"), plate = model.body("plate");
  const BodyId slide = add_box(model, "slide", 0.95, plate, Prismatic{.axis = {0, 0, 1}});
  const auto touches = [&](BodyId one, BodyId other) {
    const World world(model);
    return !world.gap(one, other)->passes;
  };
  CHECK(touches(box, plate));
  CHECK(!touches(slide, plate));
  model.add_contact_rule({.law = {.friction = 0.1, .static_friction = 0.1}});
  CHECK(!touches(slide, plate));
  model.add_contact_rule({.one = {slide}, .other = {plate}, .law = {.restitution = 0}});
  CHECK(touches(slide, plate));
  model.add_contact_rule({.one = {slide}, .law = {.off = true}});
  CHECK(!touches(slide, plate));
}
