// Events that depend on contact where they are easily missed, at instants in closed form. (Each trigger:
// contact_triggers_test.cpp.)
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/contact/contact_bodies.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81;

std::vector<double> times_of(const Simulation& sim, const std::string& name) {
  std::vector<double> times;
  for (const Event& event : sim.events())
    if (event.name == name) times.push_back(event.time);
  return times;
}

BodySpec free_ball(std::string name, const Vec3& at, Vec3 velocity = {}) {
  return {.name = std::move(name),
          .mass = 2,
          .inertia = diagonal(0.008),
          .joint = Free{},
          .q = {at.x, at.y, at.z, 1, 0, 0, 0},
          .v = {velocity.x, velocity.y, velocity.z, 0, 0, 0}};
}

Model ball_over_floor(double height, double restitution) {
  Model model;
  model.add_collider({.body = model.add(free_ball("ball", {0, 0, height + 0.1})), .solid = contact::sphere(0.1)});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 0.5, .static_friction = 0.5, .restitution = restitution}});
  return model;
}

// A cube of 20 cm on the floor with friction 0.3, which slips with a velocity along x.
Model block_on_floor(double velocity) {
  Model model;
  BodySpec block = free_ball("block", {0, 0, 0.1}, {velocity, 0, 0});
  block.inertia = diagonal(0.013);
  model.add_collider({.body = model.add(block), .solid = contact::box({0.2, 0.2, 0.2})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = 0.3, .static_friction = 0.3}});
  return model;
}

const Integration accurate{.method = "dop853", .step = 1e-2, .rtol = 1e-12, .atol = 1e-14};

}  // namespace

TEST_CASE("contact instants: two bodies touch at the instant of the impact, and again at each bounce") {
  Simulation sim(ball_over_floor(1, 0.8), accurate);
  sim.when(touching("ball", "ground")).named("once");
  sim.when(touching("ground", "ball").repeated()).named("each");
  REQUIRE(sim.run_until(2));
  const double t1 = std::sqrt(2 / g);
  REQUIRE(times_of(sim, "once").size() == 1);
  CHECK(std::fabs(times_of(sim, "once")[0] - t1) < 1e-9);
  const std::vector<double> each = times_of(sim, "each");
  REQUIRE(each.size() == times_of(sim, "impact").size());
  double time = t1, speed = g * t1;
  for (const double bounce : each) {
    CHECK(std::fabs(bounce - time) < 1e-9);
    speed *= 0.8, time += 2 * speed / g;
  }
}

TEST_CASE("contact instants: bodies that touch at the start touch, with and without a force") {
  Simulation resting(ball_over_floor(0, 0), accurate);
  resting.when(touching("ball", "ground")).named("touch");
  REQUIRE(resting.run_until(0.1));
  CHECK(times_of(resting, "touch") == std::vector<double>{0});
  Model model(Model::Options{Vec3{}});
  for (const char* name : {"a", "b"}) {
    const BodyId ball = model.add(free_ball(name, {name[0] == 'a' ? 0 : 0.2, 0, 0}));
    model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  }
  Simulation weightless(model, accurate);
  weightless.when(touching("a", "b")).named("touch");
  REQUIRE(weightless.run_until(0.1));
  CHECK(times_of(weightless, "touch") == std::vector<double>{0});
}

TEST_CASE("contact instants: bodies part where nothing presses them together any more") {
  Simulation sim(block_on_floor(0), accurate);
  sim.force("block", [](const EvaluationContext& now) { return Wrench{{0, 0, 20 * now.time()}, {}}; });
  Condition parts = touching("block", "ground");
  parts.above = false;
  sim.when(parts).named("parts");
  REQUIRE(sim.run_until(2));
  REQUIRE(times_of(sim, "parts").size() == 1);
  CHECK(std::fabs(times_of(sim, "parts")[0] - 2 * g / 20) < 1e-9);
}

TEST_CASE("contact instants: a gap falls below its threshold while bodies are apart") {
  Simulation sim(ball_over_floor(1, 0.8), accurate);
  sim.when(gap_between("ball", "ground") < 0.25).named("near");
  REQUIRE(sim.run_until(0.45));
  REQUIRE(times_of(sim, "near").size() == 1);
  CHECK(std::fabs(times_of(sim, "near")[0] - std::sqrt(2 * 0.75 / g)) < 1e-9);
  // A ball that flies past the edge of a box: the distance falls along a line, then to the edge.
  Model model(Model::Options{Vec3{}});
  const BodyId ball = model.add(free_ball("ball", {-3, 0, 0.9}, {2, 0, 0}));
  model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  model.add_collider({.solid = contact::box({1, 1, 1})});
  Simulation past(model, accurate);
  past.when(gap_between("ground", "ball") < 1).named("near");
  past.when(gap_between("ball", "ground") > 1.5).named("gone");
  REQUIRE(past.run_until(4));
  // √(Δx² + 0.4²) − 0.1 to the edge at x = −0.5, z = 0.5.
  REQUIRE(times_of(past, "near").size() == 1);
  CHECK(std::fabs(times_of(past, "near")[0] - (2.5 - std::sqrt(1.1 * 1.1 - 0.16)) / 2) < 1e-9);
  REQUIRE(times_of(past, "gone").size() == 1);
  CHECK(times_of(past, "gone")[0] == 0);
}

TEST_CASE("contact instants: gaps of the ground are those of the floor and of what stands on it") {
  Model model = ball_over_floor(1, 0);
  model.add_collider({.solid = contact::box({1, 1, 1}, Pose(Vec3{9, 0, 0.5}))});
  model.add_collider({.solid = contact::cylinder(0.5, 2, Pose(Vec3{0, 0.9, 1.1}))});
  Simulation sim(model, accurate);
  const auto distance = [&](BodyId one, BodyId other) { return sim.world().gap(one, other)->distance; };
  CHECK(std::fabs(distance({0}, ground) - 0.3) < 1e-15);
  CHECK(std::fabs(distance(ground, {0}) - 0.3) < 1e-15);
  sim.when(gap_between("ground", "ball") < 0.2).named("low");
  REQUIRE(sim.run_until(0.45));
  REQUIRE(times_of(sim, "low").size() == 1);
  CHECK(std::fabs(times_of(sim, "low")[0] - std::sqrt(2 * 0.8 / g)) < 1e-9);
}

TEST_CASE("contact instants: a contact force grows to its threshold") {
  Simulation sim(block_on_floor(0), accurate);
  sim.force("block", [](const EvaluationContext& now) { return Wrench{{0, 0, -10 * now.time()}, {}}; });
  sim.when(contact_force_between("block", "ground") > 40).named("pressed");
  sim.when(contact_force_between("ground", "block") < 10).named("light");
  REQUIRE(sim.run_until(3));
  REQUIRE(times_of(sim, "pressed").size() == 1);
  CHECK(std::fabs(times_of(sim, "pressed")[0] - (40 - 2 * g) / 10) < 1e-9);
  CHECK(times_of(sim, "light").empty());
}

TEST_CASE("contact instants: while contacts are stepped through, bodies touch to within a step") {
  Simulation sim(ball_over_floor(1, 0), {.method = "stepping", .step = 1e-3});
  sim.when(touching("ball", "ground")).named("touch");
  sim.when(contact_force_between("ball", "ground") > 15).named("rests");
  REQUIRE(sim.run_until(1));
  const double t1 = std::sqrt(2 / g);
  REQUIRE(times_of(sim, "touch").size() == 1);
  CHECK(std::fabs(times_of(sim, "touch")[0] - t1) < 1.1e-3);
  REQUIRE(times_of(sim, "rests").size() == 1);
  CHECK(std::fabs(times_of(sim, "rests")[0] - t1) < 2.1e-3);
}

TEST_CASE("contact instants: bodies begin to slip where the event says so, once or each time") {
  Simulation pulled(block_on_floor(0), accurate);
  pulled.force("block", [](const EvaluationContext& now) { return Wrench{{10 * now.time(), 0, 0}, {}}; });
  pulled.when(beginning_to_slip("floor", "block")).named("slips");
  pulled.when(slip_between("block", "ground") > 0.01).named("fast");
  REQUIRE(pulled.run_until(0.8));
  REQUIRE(!times_of(pulled, "slip").empty());
  const double first = times_of(pulled, "slip")[0];
  CHECK(std::fabs(first - 0.3 * 2 * g / 10) < 1e-6);
  CHECK(times_of(pulled, "slips") == std::vector<double>{first});
  REQUIRE(times_of(pulled, "fast").size() == 1);
  CHECK(times_of(pulled, "fast")[0] > first);
  Simulation hit(block_on_floor(0), accurate);
  for (const double time : {0.2, 1.0}) hit.at(time).then(impulse("block", {2, 0, 0}));
  hit.when(beginning_to_slip("block", "floor")).named("once");
  hit.when(beginning_to_slip("block", "floor").repeated()).named("each");
  REQUIRE(hit.run_until(2));
  CHECK(times_of(hit, "slip") == std::vector<double>{0.2, 1});
  CHECK(times_of(hit, "each") == times_of(hit, "slip"));
  CHECK(times_of(hit, "once") == std::vector<double>{0.2});
  // One that slips from the start.
  Simulation sliding(block_on_floor(1), accurate);
  sliding.when(beginning_to_slip("block", "ground")).named("slips");
  REQUIRE(sliding.run_until(0.1));
  CHECK(times_of(sliding, "slips") == std::vector<double>{0});
}

namespace {

// A dumb-bell, whose lower ball is 0.5 m above the floor, and a mechanism of a weld to another ball aside.
Model dumb_bell() {
  Model model;
  const BodyId upper = model.add(free_ball("bell/upper", {0, 0, 0.9}));
  const BodyId lower = model.add({.name = "bell/lower",
                                  .mass = 1,
                                  .inertia = diagonal(0.004),
                                  .parent = upper,
                                  .at = Pose(Vec3{0, 0, -0.3}),
                                  .joint = Weld{}});
  const BodyId other = model.add(free_ball("other/ball", {3, 0, 2}));
  for (const BodyId body : {upper, lower, other}) model.add_collider({.body = body, .solid = contact::sphere(0.1)});
  model.add_collider({.plane = true});
  return model;
}

}  // namespace

TEST_CASE("contact instants: the name of a mechanism stands for any of its bodies, floor for the ground") {
  Simulation sim(dumb_bell(), accurate);
  sim.when(touching("bell", "floor")).named("touch");
  sim.when(touching("bell/upper", "floor")).named("upper");
  sim.when(gap_between("floor", "bell") < 0.25).named("near");
  sim.when(gap_between("bell", "other") > 10).named("far");
  sim.when(contact_force_between("bell", "floor") > 0.99 * 3 * g).named("carried");
  sim.when(contact_force_between("floor", "bell") > 1.01 * 3 * g).named("pressed");
  const double lands = std::sqrt(2 * 0.5 / g);
  sim.when(contact_impulse_between("bell", "floor") > 0.99 * 3 * g * lands).named("hit");
  REQUIRE(sim.run_until(0.5));
  for (const char* name : {"touch", "carried", "hit"}) {
    CAPTURE(name);
    REQUIRE(times_of(sim, name).size() == 1);
    CHECK(std::fabs(times_of(sim, name)[0] - lands) < 1e-9);
  }
  REQUIRE(times_of(sim, "near").size() == 1);
  CHECK(std::fabs(times_of(sim, "near")[0] - std::sqrt(2 * 0.25 / g)) < 1e-9);
  for (const char* name : {"upper", "far", "pressed"}) CHECK(times_of(sim, name).empty());
  // Neighbours, which pass through each other, have a gap only if both are named.
  const World& world = sim.world();
  const auto gap = [&](const char* one, const char* other) {
    return world.gap(ContactBodies(world.model(), one), ContactBodies(world.model(), other));
  };
  CHECK(gap("bell", "bell")->passes);
  CHECK(gap("bell", "bell")->distance == doctest::Approx(0.1));
  CHECK_FALSE(gap("bell", "floor")->passes);
  for (const MissedEvent& missed : sim.missed())
    if (missed.name == "upper") CHECK(missed.of == std::vector<std::string>{"bell/upper", "floor"});
}

TEST_CASE("contact instants: conditions that can never be met are refused, with the pair") {
  Model model = dumb_bell();
  model.add(free_ball("bare/ball", {9, 0, 2}));
  const BodyId other = model.body("other/ball");
  model.add_contact_rule({.one = {other}, .other = {model.body("bell/upper"), model.body("bell/lower")}, .law = {.off = true}});
  model.add_contact_rule({.one = {other}, .other = {ground}, .law = {.friction = 0, .static_friction = 0}});
  Simulation sim(model);
  const auto refusal = [&](const Condition& condition) { return error_of([&] { static_cast<void>(sim.when(condition)); }); };
  CHECK(refusal(touching("bell", "other")) ==
        "error: touch: 'bell' and 'other' pass through each other; the last [[contact]] that names them says off = true");
  CHECK(refusal(slip_between("bell/upper", "bell/lower") > 1).empty());  // what connects them may break
  CHECK(refusal(gap_between("bell", "other") < 1).empty());
  CHECK(refusal(touching("bare", "bell")) == "error: touch: 'bare' touches nothing; give one of its bodies a collision");
  CHECK(refusal(touching("other", "other/ball")) ==
        "error: touch: 'other' and 'other/ball' are the same body; name two bodies, or mechanisms");
  CHECK(refusal(contact_force_between("bell", "bell/upper") > 1).find("have bodies in common") != std::string::npos);
  CHECK(refusal(beginning_to_slip("other", "floor")).find("'other' and the ground have no friction") != std::string::npos);
  CHECK(refusal(touching("bel", "floor")) == "error: touch: there is no body or mechanism 'bel'; did you mean 'bell'?");
}

TEST_CASE("contact: certificates of all events of an instant add up, also with prescribed motions, and so does their sum") {
  Model model({.gravity = {0, 0, -10}});
  const BodyId base = model.add(
      {.name = "base", .mass = 1, .inertia = diagonal(0.004, 0.004, 0.007), .joint = Free{}, .q = {0.01, 0.09, 0.4, 1, 0, 0, 0}});
  const BodyId middle = model.add({.name = "middle", .mass = 0.4, .inertia = diagonal(0.001), .parent = base, .joint = Ball{}});
  const BodyId tip = model.add({.name = "tip",
                                .mass = 0.3,
                                .inertia = {.xx = 0.0002, .yy = 0.0003, .zz = 0.0003, .xy = -8e-6, .xz = 2e-5, .yz = 6e-6},
                                .parent = middle,
                                .joint = Revolute{.drive = motion_drive(Signal::sine(0.17, 4, 0.5, 0.3))},
                                .child_at = {-0.06, 0.06, 0.07}});
  constexpr double a = 0.0336;
  model.add_collider({.body = tip, .solid = contact::hull(std::vector<Vec3>{{a, a, a}, {a, -a, -a}, {-a, a, -a}, {-a, -a, a}})});
  model.add_collider({.plane = true});
  for (const char* method : {"dop853", "rk4"}) {
    CAPTURE(std::string(method));
    Simulation sim(model, {.method = method, .step = 1e-4});
    REQUIRE(sim.run_until(1));
    double lost = 0;
    const Event* last = nullptr;
    for (const Event& event : sim.events()) {
      CAPTURE(event.name);
      CAPTURE(event.time);
      CHECK(event.lost >= 0);
      const double before = event.before.kinetic + event.before.potential, after = event.after.kinetic + event.after.potential;
      CHECK(std::fabs(before - event.lost - event.released + event.work - after) < 1e-13);
      const auto& S = event.ground_impulse;
      CHECK(norm(event.before.linear + Vec3{S[0], S[1], S[2]} - event.after.linear) < 1e-13);
      CHECK(norm(event.before.angular + Vec3{S[3], S[4], S[5]} - event.after.angular) < 1e-13);
      if (last != nullptr && last->time == event.time)
        CHECK(std::fabs(last->after.kinetic + last->after.potential - before) < 1e-13);
      lost += event.lost, last = &event;
    }
    CHECK(sim.events().size() > 20);
    CHECK(std::fabs(lost - sim.energy().lost_in_impacts) < 1e-12);
    CHECK(std::fabs(sim.energy().error) < 1e-6);
  }
}
