// Islands that are stepped through while the contacts of others are located.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/run_state.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81;

BodySpec free_body(std::string name, const Vec3& at, const Vec3& v = {}) {
  return {.name = std::move(name),
          .mass = 1,
          .inertia = diagonal(0.006),
          .joint = Free{},
          .q = {at.x, at.y, at.z, 1, 0, 0, 0},
          .v = {v.x, v.y, v.z, 0, 0, 0}};
}

// A column of boxes that lands on one floor, with more points than are located: it is stepped through.
void add_column(Model& model, int boxes) {
  for (int i = 0; i < boxes; ++i) {
    const BodyId box = model.add(free_body("box" + std::to_string(i) + "/box", {0, 0, 0.15 + 0.2 * i + 1e-6 * i}));
    model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
  }
}

void add_floor(Model& model, double friction) {
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
}

std::vector<const Event*> named(const Simulation& sim, const std::string& name) {
  std::vector<const Event*> found;
  for (const Event& event : sim.events())
    if (event.name == name) found.push_back(&event);
  return found;
}

bool has(const std::vector<std::string>& all, const std::string& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

}  // namespace

TEST_CASE("islands: while a column is stepped through, a ball elsewhere bounces at its instants and comes to rest at its own") {
  constexpr double radius = 0.1, height = 0.7, e = 0.8;
  Model model;
  add_column(model, 12);
  const BodyId ball = model.add(free_body("ball/ball", {3, 0, height + radius}));
  model.add_collider({.body = ball, .solid = contact::sphere(radius)});
  add_floor(model, 0.5);
  model.add_contact_rule({.one = {ball}, .other = {ground}, .law = {.restitution = e}});
  for (const char* method : {"rk4", "dop853"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method, .step = 1e-3});
    const RunResult run = sim.run_until(4);
    INFO(run.reason);
    REQUIRE(run);
    const std::vector<const Event*> began = named(sim, "stepping");
    REQUIRE_FALSE(began.empty());
    for (const Event* event : began) CHECK_FALSE(has(event->stepped, "ball"));
    CHECK(has(began.front()->stepped, "box0"));
    double t = std::sqrt(2 * height / g), v = g * t;
    int k = 0;
    for (const Event& event : sim.events()) {
      if (event.name != "impact" || event.contact.one != "ball/ball" || k == 8) continue;
      CHECK(std::fabs(event.time - t) < 1e-9);
      v *= e, t += 2 * v / g, ++k;
    }
    CHECK(k == 8);
    const double rest = std::sqrt(2 * height / g) * (1 + 2 * e / (1 - e));
    double rests = 0;
    for (const Event& event : sim.events())
      if (event.name == "rest" && event.contact.one == "ball/ball") rests = event.time;
    CHECK(std::fabs(rests - rest) < 2e-8);
    CHECK(std::fabs(sim.energy().error) < 1e-3 * sim.energy().largest_kinetic);
  }
}

TEST_CASE("islands: a ball rolls on past a column that is stepped through at 5/7 of its speed") {
  constexpr double radius = 0.1, v = 2, mu = 0.3;
  Model model;
  add_column(model, 12);
  BodySpec spec = free_body("ball/ball", {-3, 3, radius}, {v, 0, 0});
  spec.inertia = diagonal(0.4 * radius * radius);
  const BodyId ball = model.add(spec);
  model.add_collider({.body = ball, .solid = contact::sphere(radius)});
  add_floor(model, mu);
  Simulation sim(model, {.method = "dop853", .step = 1e-3, .rtol = 1e-12, .atol = 1e-14});
  REQUIRE(sim.run_until(1));
  REQUIRE_FALSE(named(sim, "stepping").empty());
  CHECK(std::fabs(sim.world().motions()[static_cast<std::size_t>(ball.index)].linear.x - 5.0 / 7 * v) < 1e-12);
}

TEST_CASE("islands: thirty boxes that land apart from each other are located, with all their points") {
  constexpr double height = 0.3;
  Model model;
  for (int i = 0; i < 30; ++i) {
    const BodyId box = model.add(free_body("box" + std::to_string(i) + "/box", {0.5 + 0.3 * i, 0, 0.1 + height}));
    model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
  }
  add_floor(model, 0.5);
  Simulation sim(model, {.method = "rk4", .step = 1e-3});
  REQUIRE(sim.run_until(0.35));
  CHECK(named(sim, "stepping").empty());
  CHECK(sim.world().contacts().size() == 120);
  const std::vector<const Event*> impacts = named(sim, "impact");
  CHECK(impacts.size() == 30);
  for (const Event* impact : impacts) {
    CHECK(std::fabs(impact->time - std::sqrt(2 * height / g)) < 1e-9);
    CHECK(impact->lost == doctest::Approx(g * height).epsilon(1e-9));
    CHECK(impact->contact.impulse.z == doctest::Approx(std::sqrt(2 * g * height)).epsilon(1e-9));
  }
  CHECK(std::fabs(sim.energy().error) < 1e-9);
}

TEST_CASE("islands: what is hit by an island that is stepped through joins it") {
  Model model;
  add_column(model, 12);
  const BodyId ball = model.add(free_body("ball/ball", {1, 0, 0.1}, {-2, 0, 0}));
  model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  const BodyId far = model.add(free_body("far/far", {9, 0, 0.1}));
  model.add_collider({.body = far, .solid = contact::sphere(0.1)});
  add_floor(model, 0.2);
  Simulation sim(model, {.method = "rk4", .step = 1e-3});
  REQUIRE(sim.run_until(0.8));
  const std::vector<const Event*> began = named(sim, "stepping");
  REQUIRE(began.size() >= 2);
  const auto joined = std::find_if(began.begin(), began.end(), [](const Event* e) { return has(e->stepped, "ball"); });
  REQUIRE(joined != began.end());
  CHECK((*joined)->time > began.front()->time);
  for (const Event* event : began) CHECK_FALSE(has(event->stepped, "far"));
  for (const BodyMotion& m : sim.world().motions()) CHECK(m.pose.position.z > 0.09);
}

TEST_CASE("islands: a pendulum beside a column that is stepped through keeps its energy to the method's accuracy") {
  Model model;
  add_column(model, 12);
  model.add({.name = "pendulum/bob",
             .mass = 1,
             .com = {0, 0, -1},
             .inertia = diagonal(0.01),
             .at = {5, 0, 3},
             .joint = Revolute{{0, 1, 0}},
             .q = {1.2}});
  add_floor(model, 0.5);
  Simulation sim(model, {.method = "dop853", .step = 1e-3, .rtol = 1e-12, .atol = 1e-13});
  REQUIRE(sim.run_until(1.5));
  REQUIRE_FALSE(named(sim, "stepping").empty());
  const double q = sim.world().joint(model.joint("pendulum/bob")).q[0], v = sim.world().joint(model.joint("pendulum/bob")).v[0];
  CHECK(0.5 * 1.01 * v * v - g * std::cos(q) == doctest::Approx(-g * std::cos(1.2)).epsilon(1e-10));
}

TEST_CASE("islands: a run that is restored, or continued from its state, goes on to the bit") {
  Model model;
  add_column(model, 12);
  const BodyId ball = model.add(free_body("ball/ball", {3, 0, 1}));
  model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  add_floor(model, 0.5);
  model.add_contact_rule({.one = {ball}, .other = {ground}, .law = {.restitution = 0.8}});
  const auto make = [&] { return Simulation(model, {.method = "dopri5", .step = 1e-3}); };
  const auto same = [](const Simulation& a, const Simulation& b) {
    return std::equal(a.world().state().q().begin(), a.world().state().q().end(), b.world().state().q().begin()) &&
           std::equal(a.world().state().u().begin(), a.world().state().u().end(), b.world().state().u().begin()) &&
           a.energy().error == b.energy().error;
  };
  Simulation through = make();
  REQUIRE(through.run_until(0.2));
  REQUIRE(through.run_until(0.6));
  REQUIRE_FALSE(named(through, "stepping").empty());
  Simulation restored = make();
  REQUIRE(restored.run_until(0.2));
  const SimulationSnapshot snapshot = restored.snapshot();
  const RunState state = restored.run_state();
  REQUIRE(restored.run_until(0.5));
  restored.restore(snapshot);
  REQUIRE(restored.run_until(0.6));
  CHECK(same(restored, through));
  Simulation continued = make();
  continued.continue_from(state);
  REQUIRE(continued.run_until(0.6));
  CHECK(same(continued, through));
}

TEST_CASE("islands: an impact takes no more evaluations if hundreds of others follow it in the step") {
  const auto evaluations_of_each = [](int spheres) {
    Model model;
    for (int i = 0; i < spheres; ++i) {
      const double last = i == 0 ? 0 : 1.0 * ((37 * i) % spheres) / spheres;  // in no order
      const BodyId sphere = model.add(free_body("s" + std::to_string(i) + "/s", {0.25 * i, 0, 0.1002 + 1e-4 * last}));
      model.add_collider({.body = sphere, .solid = contact::sphere(0.1)});
    }
    add_floor(model, 0.3);
    Simulation sim(model, {.method = "rk4", .step = 1e-3});
    REQUIRE(sim.run_until(0.0085));
    const std::vector<const Event*> impacts = named(sim, "impact");
    REQUIRE(static_cast<int>(impacts.size()) == spheres);
    for (const Event* impact : impacts) {
      const double height = 0.5 * g * impact->time * impact->time;  // of the fall
      CHECK(height > 2e-4 - 1e-12);
      CHECK(height < 3e-4 + 1e-12);
      CHECK(&impact->mechanisms_after[0] == &impacts.front()->mechanisms_before[0]);  // one list for all
    }
    return static_cast<double>(sim.statistics().evaluations[0] + sim.statistics().evaluations[1]) / spheres;
  };
  const double few = evaluations_of_each(10), many = evaluations_of_each(150);
  CHECK(many < 1.2 * few);
}

TEST_CASE("islands: many balls that land one after the other, each for itself, are no flood of changes") {
  constexpr int balls = 400;
  constexpr double radius = 0.1;
  const auto instant = [](int k) { return 0.1 + 4e-3 * k / balls; };
  Model model;
  for (int k = 0; k < balls; ++k) {
    const double height = radius + g / 2 * instant(k) * instant(k);
    const BodyId ball = model.add(free_body("ball" + std::to_string(k) + "/ball", {0.5 * (k % 20), 0.5 * (k / 20), height}));
    model.add_collider({.body = ball, .solid = contact::sphere(radius)});
  }
  add_floor(model, 0.5);
  Simulation sim(model, {.step = 1e-3});
  REQUIRE(sim.run_until(0.105));
  CHECK(named(sim, "stepping").empty());
  const std::vector<const Event*> impacts = named(sim, "impact");
  REQUIRE(impacts.size() == balls);
  for (int k = 0; k < balls; ++k) CHECK(std::fabs(impacts[static_cast<std::size_t>(k)]->time - instant(k)) < 1e-9);
}
