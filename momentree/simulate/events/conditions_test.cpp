// Events with conditions: the instant of crossing for any step; order, repetition, duration.
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81;

Model falling(double v = 0) {
  Model model;
  model.add({.name = "ball", .mass = 2, .inertia = diagonal(0.1), .joint = Prismatic{}, .v = v});
  return model;
}

// A chain of hanging rods of 1 kg and 1 m, at rest.
Model hanging(int links) {
  Model model;
  BodyId last = ground;
  for (int k = 1; k <= links; ++k)
    last = model.add({.name = "rod/" + std::to_string(k),
                      .mass = 1,
                      .com = {0, 0, -0.5},
                      .inertia = diagonal(1.0 / 12, 1.0 / 12, 0.001),
                      .parent = last,
                      .at = {0, 0, k == 1 ? 0.0 : -1.0},
                      .joint = Revolute{.axis = {0, 1, 0}}});
  return model;
}

}  // namespace

TEST_CASE("the instant of a crossing does not depend on the step") {
  for (const double step : {1e-3, 5e-3, 0.05}) {
    Simulation sim(falling(), {.step = step});
    sim.when(height_of("ball").below(-1.0)).then(impulse("ball", {0, 0, 2})).named("low");
    sim.when(speed_of("ball").below(-3.0)).then(impulse("ball", {0, 0, 1})).named("fast");
    REQUIRE(sim.run_until(1) == Status::ok);
    REQUIRE(sim.events().size() == 2);
    CHECK(sim.events()[0].name == "fast");
    CHECK(std::fabs(sim.events()[0].time - 3 / g) < 1e-9);
    // From there with a speed of 2.5 m/s, at 3²/2g below the start.
    const double fallen = 9 / (2 * g), t = (-2.5 + std::sqrt(2.5 * 2.5 + 2 * g * (1 - fallen))) / g;
    CHECK(std::fabs(sim.events()[1].time - (3 / g + t)) < 2e-9);
  }
}

TEST_CASE("a pendulum breaks where the force in its joint reaches a threshold") {
  // Point mass on a massless rod of 1 m, released horizontally: the force is 3 m g sin φ, φ being the angle fallen; 2 m g at sin
  // φ = 2/3.
  Model model;
  model.add({.name = "bob", .mass = 1, .com = {1, 0, 0}, .inertia = {}, .joint = Revolute{.axis = {0, 1, 0}}});
  for (const double step : {1e-3, 5e-3}) {
    Simulation sim(model, {.step = step});
    sim.when(reaction_force("bob").exceeds(2 * g)).then(free_joint("bob"));
    REQUIRE(sim.run_until(0.1) == Status::ok);
    const Status status = sim.run_until(2);
    CHECK(status == Status::refused);  // a point has no inertia with which to move freely
    CHECK(std::fabs(std::sin(sim.world().joint({0}).q[0]) - 2.0 / 3) < 1e-7);
  }
}

TEST_CASE("conditions can be written as comparisons") {
  const auto broken_at = [](const Condition& condition) {
    Model model;
    model.add({.name = "rod",
               .mass = 2,
               .com = {0, 0, -1},
               .inertia = diagonal(0.2, 0.2, 0.01),
               .joint = Revolute{.axis = {0, 1, 0}},
               .q = 1.5});
    Simulation sim(model, {.step = 1e-3});
    sim.when(condition).then(break_joint("rod"));
    CHECK(sim.run_until(1) == Status::ok);
    REQUIRE(sim.events().size() == 1);
    return sim.events()[0].time;
  };
  CHECK(broken_at(reaction("rod").force() > 30) == broken_at(reaction_force("rod").exceeds(30)));
  CHECK(broken_at(reaction("rod").component("fz") > 30) == broken_at(reaction("rod", "fz").exceeds(30)));
  CHECK(broken_at(reaction("rod").torque() < 1) == broken_at(reaction_torque("rod").below(1)));
  CHECK(broken_at(position_of("rod") < 1) == broken_at(position_of("rod").below(1)));
}

TEST_CASE("a threshold exceeded at the start fires at once; the largest load first; a cascade at one instant") {
  Simulation sim(hanging(5), {.step = 1e-3});
  // The joints carry 5, 4, 3, 2, 1 rods. All but the last are overloaded; the third is overloaded most, then the first with the
  // remaining rods.
  const double limits[5] = {4.2, 3.9, 2.0, 1.9, 5};
  for (int k = 1; k <= 5; ++k) {
    const std::string rod = "rod/" + std::to_string(k);
    sim.when(reaction_force(rod).exceeds(limits[k - 1] * g)).then(break_joint(rod)).named("snap " + std::to_string(k));
  }
  REQUIRE(sim.run_until(0.01) == Status::ok);
  REQUIRE(sim.events().size() == 1);  // without three rods no other joint is overloaded, nor is any in free fall
  CHECK(sim.events()[0].name == "snap 3");
  CHECK(sim.events()[0].time == 0);

  Simulation all(hanging(12), {.step = 1e-3});
  for (int k = 12; k >= 1; --k) {
    // From bottom to top, each slightly more overloaded than the one above it will be after the break.
    const std::string rod = "rod/" + std::to_string(k);
    all.when(position_of(rod).exceeds(-1)).then(break_joint(rod));
  }
  REQUIRE(all.run_until(0) == Status::ok);
  CHECK(all.events().size() == 12);  // all are met at once and happen one after the other, in the order of scheduling
  CHECK(all.events()[0].actions[0].text() == "break rod/12");
  CHECK(all.world().mechanisms().size() == 12);
}

TEST_CASE("a peak between the ends of a step is found") {
  const double v = 1, top = v * v / (2 * g);
  for (const std::string method : {"rk4", "dopri5", "dop853"}) {
    CAPTURE(method);
    // Up and down again within the first step; tolerances that everything meets.
    Simulation sim(falling(v), {.method = method, .step = 0.3, .rtol = 1e6, .atol = 1e6});
    sim.when(position_of("ball").exceeds(0.95 * top)).then(impulse("ball", {0.0, 0, 0}));
    REQUIRE(sim.run_until(0.3) == Status::ok);
    REQUIRE(sim.events().size() == 1);
    CHECK(std::fabs(sim.events()[0].time - v / g * (1 - std::sqrt(0.05))) < 1e-9);
  }
}

TEST_CASE("repetition, duration, delays, periods") {
  Model model({.gravity = {}});
  model.add({.name = "swing",
             .mass = 1,
             .inertia = diagonal(1),
             .joint = Prismatic{.stiffness = 4 * 9.869604401089358},  // a period of one second
             .q = 1.0});
  Simulation sim(model, {.step = 1e-3});
  const Action nothing = impulse("swing", {});
  sim.when(position_of("swing").exceeds(0.5).repeated()).then(nothing).named("out");
  sim.when(position_of("swing").exceeds(0.5).lasting(0.2)).then(nothing).named("long");
  sim.when(position_of("swing").exceeds(0.5).lasting(0.4)).then(nothing).named("too long");
  sim.after("out", 0.1).then(nothing).named("later");
  sim.every(0.75, 0.5).then(nothing).named("clock");
  REQUIRE(sim.run_until(2.2) == Status::ok);
  std::vector<std::pair<std::string, double>> expected = {
      {"out", 0},          {"later", 0.1},  {"clock", 0.5},    {"out", 5.0 / 6},     {"later", 14.0 / 15},
      {"long", 31.0 / 30}, {"clock", 1.25}, {"out", 11.0 / 6}, {"later", 29.0 / 15}, {"clock", 2.0}};
  REQUIRE(sim.events().size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(sim.events()[i].name == expected[i].first);
    CHECK(std::fabs(sim.events()[i].time - expected[i].second) < 1e-8);
  }
}

TEST_CASE("events after a delay, and conditions that have lasted, are at decimal instants") {
  Model model({.gravity = {}});
  model.add({.name = "slider", .mass = 1, .inertia = diagonal(1), .joint = Prismatic{.axis = {0, 0, 1}}, .q = 1.0});
  for (const char* method : {"rk4", "dopri5"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method, .step = 0.01});
    const Action nothing = impulse("slider", {});
    sim.at(0.1).then(nothing).named("a");
    sim.after("a", 0.2).then(nothing).named("b");
    sim.after("b", 0.4).then(nothing).named("c");
    sim.at(0.1).then(impulse("slider", {0, 0, 1}));
    sim.when(speed_of("slider").exceeds(0.5).lasting(0.6)).then(nothing).named("d");
    REQUIRE(sim.run_until(1) == Status::ok);
    std::map<std::string, double> instants;
    for (const Event& event : sim.events()) instants[event.name] = event.time;
    CHECK(instants.at("b") == 0.3);  // 0.1 + 0.2 is a rounding after it
    CHECK(instants.at("c") == 0.7);
    CHECK(instants.at("d") == 0.7);
  }
}

TEST_CASE("a duration starts anew if its condition ceases within a step, however briefly") {
  // A cosine with a period of one second falls below -0.85 for less than a step of 0.2 s: at 0.5, 1.5, … s, by 0.0883 s to both
  // sides.
  constexpr double turn = 2 * 3.14159265358979323846;
  const double gap = std::acos(0.85) / turn;
  for (const double step : {0.2, 0.01}) {
    CAPTURE(step);
    Model model({.gravity = {}});
    model.add({.name = "swing", .mass = 1, .inertia = diagonal(1), .joint = Prismatic{.stiffness = turn * turn}, .q = 1.0});
    // Tolerances that everything meets: all steps have the length max_step.
    Simulation sim(model, {.method = "dop853", .step = step, .rtol = 1e6, .atol = 1e6, .max_step = step});
    const Action nothing = impulse("swing", {});
    const auto over = position_of("swing").exceeds(-0.85);
    sim.when(Condition(over).lasting(0.7)).then(nothing).named("first");
    sim.when(Condition(over).lasting(0.7).repeated()).then(nothing).named("again");
    sim.when(Condition(over).lasting(1 - 2 * gap - 1e-4)).then(nothing).named("just");
    sim.when(Condition(over).lasting(1 - 2 * gap + 1e-4)).then(nothing).named("never");
    REQUIRE(sim.run_until(2.45) == Status::ok);
    std::vector<std::pair<std::string, double>> expected = {
        {"first", 1.2 + gap}, {"again", 1.2 + gap}, {"just", 1.5 - gap - 1e-4}, {"again", 2.2 + gap}};
    std::vector<std::pair<std::string, double>> found;
    for (const Event& e : sim.events()) found.emplace_back(e.name, e.time);
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      CHECK(found[i].first == expected[i].first);
      CHECK(std::fabs(found[i].second - expected[i].second) < (step < 0.1 ? 1e-9 : 2e-5));
    }
  }
}

TEST_CASE("a trigger far from its threshold costs no evaluation") {
  for (const std::string method : {"rk4", "dopri5", "dop853"}) {
    CAPTURE(method);
    long evaluations[3] = {};
    for (const int i : {0, 1, 2}) {
      Model model = hanging(3);
      Simulation sim(model, {.method = method, .step = 1e-3});
      sim.at(0).then(impulse("rod/3", {0.4, 0, 0}, {}, {0, 0, -1}));
      if (i == 1) sim.when(reaction_force("rod/1").exceeds(1e4)).then(break_joint("rod/1"));
      if (i == 2) sim.when(position_of("rod/2").exceeds(3)).then(break_joint("rod/2"));
      REQUIRE(sim.run_until(1) == Status::ok);
      evaluations[i] = sim.statistics().evaluations[0] + sim.statistics().evaluations[1];
    }
    CHECK(evaluations[0] > 50);
    // Except in the first step after an event, when slopes are not known.
    CHECK(evaluations[1] - evaluations[0] <= 30);
    CHECK(evaluations[2] - evaluations[0] <= 30);
    MESSAGE(method << ": " << evaluations[0] << ", " << evaluations[1] << ", " << evaluations[2] << " evaluations");
  }
}

TEST_CASE("many conditions on positions need the evaluations of one for each event") {
  const auto evaluations = [](int count) {
    Simulation sim(falling(20), {.step = 0.05});  // a ball thrown upwards: every condition fires once, on the way up
    for (int k = 1; k <= count; ++k) sim.when(position_of("ball").exceeds(20.0 * k / count)).then(impulse("ball", {}));
    REQUIRE(sim.run_until(2) == Status::ok);
    REQUIRE(sim.events().size() == static_cast<std::size_t>(count));
    return sim.statistics().evaluations[0] + sim.statistics().evaluations[1];
  };
  const long few = evaluations(20), many = evaluations(400);
  CHECK(many < 25 * few);  // 400 times as many if each event cost an evaluation per condition
}

TEST_CASE("conditions without rates find the slopes of one step together") {
  const auto evaluations = [](int count) {
    Simulation sim(hanging(3), {.step = 1e-3});
    sim.every(0.01).then(impulse("rod/3", {0.01, 0, 0}));  // after each event: slopes are not known in the next step
    for (int k = 0; k < count; ++k) sim.when(reaction_force("rod/1").exceeds(1e4 + k)).then(break_joint("rod/1"));
    REQUIRE(sim.run_until(0.2) == Status::ok);
    return sim.statistics().evaluations[0] + sim.statistics().evaluations[1];
  };
  CHECK(evaluations(100) == evaluations(1));
}

TEST_CASE("snapshots contain armed events; endless cascades are stopped and reported; impulses trigger conditions") {
  Simulation sim(falling(), {.step = 1e-3});
  sim.when(height_of("ball").below(-0.5)).then(impulse("ball", {0, 0, 1}));
  const SimulationSnapshot start = sim.snapshot();
  CHECK(sim.run_until(0.5) == Status::ok);
  const double t = sim.events().at(0).time;
  sim.restore(start);
  CHECK(sim.run_until(0.5) == Status::ok);
  REQUIRE(sim.events().size() == 1);
  CHECK(sim.events()[0].time == t);

  Simulation runaway(falling());
  runaway.at(0.1).then(impulse("ball", {})).named("a");
  runaway.after("a").then(impulse("ball", {})).named("b");
  runaway.after("b").then(impulse("ball", {})).named("a");
  CHECK(runaway.run_until(1) == Status::refused);
  CHECK(runaway.result().reason.find("more than 10000 events at t = 0.1 s") != std::string::npos);

  Simulation jerk(hanging(3));
  jerk.when(reaction_impulse("rod/2").exceeds(0.5)).then(break_joint("rod/2"));
  jerk.at(0.1).then(impulse("rod/3", {0, 0, -1}, {}, {0, 0, -1}));
  REQUIRE(jerk.run_until(0.2) == Status::ok);
  REQUIRE(jerk.events().size() == 2);
  CHECK(jerk.events()[1].time == 0.1);
}

TEST_CASE("impossible conditions are errors") {
  Simulation sim(hanging(2));
  CHECK_THROWS_AS(sim.when(reaction_force("rod/3").exceeds(1)), Error);
  CHECK_THROWS_AS(sim.when(reaction_force("rod/1").exceeds(0)), Error);
  CHECK_THROWS_AS(sim.when(height_of("rope").below(1)), Error);
  CHECK_THROWS_AS(reaction("rod/1", "fw"), Error);
  CHECK_THROWS_AS(sim.after("never", 1), Error);
  CHECK_THROWS_AS(sim.every(0), Error);
}
