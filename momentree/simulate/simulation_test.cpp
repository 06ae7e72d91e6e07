#include <momentree/simulate/simulation.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/failure.hpp>

using namespace momentree;

namespace {

Model chain(int links, double damping = 0) {
  Model model({.gravity = {0, -9.81, 0}});
  BodyId last = ground;
  for (int k = 1; k <= links; ++k)
    last = model.add({.name = "chain/" + std::to_string(k),
                      .mass = 0.1,
                      .com = {0.05, 0, 0},
                      .inertia = diagonal(8.3e-5),
                      .parent = last,
                      .at = {k == 1 ? 0.0 : 0.1, 0, 0},
                      .joint = Revolute{.damping = damping},
                      .q = 0.1});
  return model;
}

}  // namespace

TEST_CASE("steps end exactly on events and on the end of the run, and events are reported") {
  Simulation sim(chain(4), {.method = "rk4", .step = 1e-3});
  sim.at(0.10005).then(break_joint("chain/3")).named("snap");
  CHECK(sim.run_until(0.2) == Status::ok);
  CHECK(sim.time() == 0.2);
  REQUIRE(sim.events().size() == 1);
  const Event& e = sim.events()[0];
  CHECK(e.time == 0.10005);
  CHECK(e.name == "snap");
  CHECK(e.action_texts() == std::vector<std::string>{"break chain/3"});
  CHECK(e.mechanisms_before == std::vector<std::string>{"chain"});
  CHECK(e.mechanisms_after == std::vector<std::string>{"chain", "chain/3"});
  CHECK(e.after.kinetic == doctest::Approx(e.before.kinetic).epsilon(1e-13));
  CHECK(sim.statistics().steps == 201);
  CHECK(sim.statistics().changes == 1);
  const EnergyBalance energy = sim.energy();
  CHECK(std::fabs(energy.error) < 1e-6);
  CHECK(energy.error == doctest::Approx(energy.final - energy.initial).epsilon(1e-9));
}

TEST_CASE("events of one instant happen in order; an action on a joint that is gone is skipped and reported") {
  Simulation sim(chain(3), {.step = 1e-2});
  sim.at(0.05).then(break_joint("chain/2"));
  sim.at(0.0).then(break_joint("chain/3"));
  sim.at(0.05).then(break_joint("chain/2")).then(break_joint("chain/1"));
  CHECK(sim.run_until(0.05) == Status::ok);
  REQUIRE(sim.events().size() == 3);
  CHECK(sim.events()[0].time == 0);
  CHECK(sim.events()[0].name == "#2");
  CHECK(sim.events()[1].actions[0].text() == "break chain/2");
  CHECK(sim.events()[2].actions[0].text().find("skipped") != std::string::npos);
  CHECK(sim.events()[2].actions[1].text() == "break chain/1");
  CHECK(sim.events()[2].mechanisms_after.size() == 3);
  CHECK(sim.events()[2].mechanisms_after[0] == "chain");  // a mechanism whose root joint breaks keeps its name
}

TEST_CASE("stepping in a loop gives the same motion as one run") {
  Simulation one(chain(5), {.step = 1e-3}), other(chain(5), {.step = 1e-3});
  one.at(0.25).then(break_joint("chain/2"));
  other.at(0.25).then(break_joint("chain/2"));
  CHECK(one.run_until(0.5) == Status::ok);
  for (int k = 0; k < 50; ++k) REQUIRE(other.step(0.01) == Status::ok);
  CHECK(other.time() == doctest::Approx(0.5).epsilon(1e-15));
  for (std::size_t b = 0; b < 5; ++b)
    CHECK(norm(one.world().motions()[b].pose.position - other.world().motions()[b].pose.position) < 1e-9);
}

TEST_CASE("dissipation and work are in the energy ledger, which closes with the order of the method") {
  const auto error = [](double step) {
    Model model;
    const BodyId arm = model.add({.name = "a",
                                  .mass = 1,
                                  .com = {0.5, 0, 0},
                                  .inertia = diagonal(0.1),
                                  .joint = Revolute{.axis = y_axis, .damping = 0.2, .effort = 1.5}});
    model.add({.name = "b",
               .mass = 0.5,
               .com = {0.3, 0, 0.1},
               .inertia = diagonal(0.05),
               .parent = arm,
               .at = {1, 0, 0},
               .joint = Ball{.damping = 0.1, .stiffness = 2.0},
               .v = {1, 2, 3}});
    Simulation sim(model, {.step = step});
    CHECK(sim.run_until(1) == Status::ok);
    const EnergyBalance e = sim.energy();
    CHECK(e.dissipated > 0.1);
    CHECK(std::fabs(e.work) > 0.1);
    return std::fabs(e.error);
  };
  const double coarse = error(0.004), fine = error(0.002);
  CHECK(std::log2(coarse / fine) > 3.7);
  CHECK(fine < 1e-8);
}

TEST_CASE("observers: every step, at multiples, after events, never twice; an observer can stop the run") {
  std::vector<double> times;
  std::size_t mechanisms = 0;
  Simulation sim(chain(2), {.step = 3e-3});
  sim.at(0.02).then(break_joint("chain/2"));
  sim.observe(0.01, [&](const World& world) {
    times.push_back(world.time());
    if (world.time() == 0.02) mechanisms = world.mechanisms().size();
    return true;
  });
  CHECK(sim.run_until(0.025) == Status::ok);
  CHECK(sim.run_until(0.04) == Status::ok);
  REQUIRE(times.size() == 6);
  CHECK(times[1] == 0.01);
  CHECK(times[2] == 0.02);
  CHECK(times[3] == 0.025);
  CHECK(times[5] == 0.04);
  CHECK(mechanisms == 2);

  Simulation stopped(chain(2), {.step = 1e-2});
  int calls = 0;
  stopped.observe(0, [&](const World&) { return ++calls < 4; });
  CHECK(stopped.run_until(1) == Status::interrupted);
  CHECK(calls == 4);
  CHECK(stopped.time() == doctest::Approx(0.03));
}

TEST_CASE("a run that diverges stops at its last valid state and reports the joint, the time, and a remedy") {
  Model model = chain(30);
  Simulation sim(model, {.step = 0.05});
  CHECK(sim.run_until(1000) == Status::diverged);
  CHECK(sim.time() < 1000);
  CHECK(sim.result().reason.find("joint 'chain/") != std::string::npos);
  CHECK(sim.result().reason.find("t = ") != std::string::npos);
  CHECK(sim.result().reason.find("smaller step") != std::string::npos);
  for (double q : sim.world().state().q()) CHECK(std::fabs(q) < 1e9);  // detected before the numbers become meaningless
  CHECK(std::isfinite(sim.energy().error));
  CHECK(sim.run_until(2000) == Status::diverged);
}

TEST_CASE("mistakes are errors that name the problem") {
  const Model model = chain(2);
  CHECK_THROWS_AS(Simulation(model, {.method = "rk5"}), Error);
  CHECK_THROWS_AS(Simulation(model, {.step = 0}), Error);
  CHECK_THROWS_AS(Simulation(model, {.step = std::nan("")}), Error);
  Simulation sim(model, {});
  CHECK_THROWS_AS(sim.at(-1), Error);
  CHECK_THROWS_AS(sim.at(1).then(break_joint("chain/3")), Error);
  CHECK_THROWS_AS(sim.at(1).then(weld("chain/1", "chain/7")), Error);
  try {
    Simulation(model, {.method = "rk5"});
  } catch (const Error& e) {
    CHECK(e.message().find("did you mean 'rk4'") != std::string::npos);
  }
  Model point;
  point.add({.name = "p", .mass = 1, .joint = Revolute{}, .joint_name = "pin"});
  try {
    Simulation bad(point, {});
    FAIL("a singular joint-space mass was accepted");
  } catch (const Error& e) {
    CHECK(e.where.find("pin") != std::string::npos);
    CHECK(e.hint.find("armature") != std::string::npos);
  }
}

TEST_CASE("a world restored from its public data continues to the same bits") {
  Simulation whole(chain(6, 0.01), {.step = 1e-3});
  whole.at(0.1).then(break_joint("chain/4"));
  CHECK(whole.run_until(0.2) == Status::ok);
  std::vector<JointStart> joints;
  Forest forest;
  const World& world = whole.world();
  const Tree& tree = world.tree();
  for (int b = 0; b < 6; ++b) {
    const JointView j = world.joint({b});
    JointStart start{{b}, {}, {}, {}};
    for (double x : j.q) start.q.push_back(x);
    for (double x : j.p) start.p.push_back(x);
    joints.push_back(start);
    forest.places.push_back({tree.parent(b), tree.joint_of(b), tree.reversed(b)});
    if (is_detached(tree, b)) forest.changed.push_back({tree.joint_of(b), std::string(j.name), tree.joint(b), {}});
  }
  for (const Mechanism& m : world.mechanisms()) forest.mechanisms.emplace_back(m.root.index, std::string(m.name));
  Simulation branch(chain(6, 0.01), {.step = 1e-3});
  branch.restore(world.time(), forest, joints);
  CHECK(branch.time() == 0.2);
  CHECK(whole.run_until(0.3) == Status::ok);
  CHECK(branch.run_until(0.3) == Status::ok);
  for (std::size_t i = 0; i < whole.world().state().q().size(); ++i)
    CHECK(whole.world().state().q()[i] == branch.world().state().q()[i]);
  for (std::size_t i = 0; i < whole.world().p().size(); ++i) CHECK(whole.world().p()[i] == branch.world().p()[i]);
}

TEST_CASE("a coordinate that diverges in the first step is named, with its value") {
  Model model({.gravity = {}});
  model.add({.name = "calm", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}, .v = 1.0});
  model.add({.name = "stiff", .mass = 1, .inertia = diagonal(1), .joint = Revolute{.stiffness = 1e12}, .q = 0.1});
  Simulation sim(model, {.step = 1e-3});
  CHECK(sim.run_until(1) == Status::diverged);
  CHECK(sim.time() == 0);
  CHECK(sim.result().reason.find("diverged at t = 0 s: the spring of joint 'stiff'") == 0);
  // A spring within a function cannot be recognised as one: the message reports what happened instead.
  Model driven({.gravity = {}});
  driven.add({.name = "calm", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}, .v = 1.0});
  const BodyId swing = driven.add({.name = "swing", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}, .q = 0.1});
  Simulation other(driven, {.step = 1e-3});
  other.drive("swing", [swing](const EvaluationContext& at) { return -1e12 * at.q({swing.index})[0]; });
  CHECK(other.run_until(1) == Status::diverged);
  CHECK(other.result().reason.find("diverged at t = 0 s: joint 'swing' would move by ") == 0);
  CHECK(other.result().reason.find("within a step of 0.001 s; use a smaller step") != std::string::npos);
  Model sharp({.gravity = {}});
  const BodyId needle = sharp.add({.name = "sharp", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}, .q = 0.1});
  Simulation beyond(sharp, {.step = 1});
  beyond.drive("sharp", [needle](const EvaluationContext& at) { return -1e308 * at.q({needle.index})[0]; });
  CHECK(beyond.run_until(1) == Status::diverged);
  CHECK(beyond.result().reason.find("joint 'sharp' overflowed") != std::string::npos);
}

TEST_CASE("a run that makes no progress stops and reports the reason") {
  const Model model = chain(1);
  Simulation tiny(model, {.step = 1e-300});
  CHECK(tiny.run_until(1) == Status::stalled);
  CHECK(tiny.result().reason.find("no progress at t = ") == 0);
  CHECK(tiny.result().reason.find("the step of 1e-300 s is too short for a run of 1 s") != std::string::npos);
  CHECK(tiny.run_until(tiny.time()) == Status::ok);  // it may be called again
  Simulation late(model, {.step = 1});
  REQUIRE(late.run_until(1e6) == Status::ok);
  Simulation fine(model, {.step = 1e-12});
  fine.restore(1e6, {}, {});
  CHECK(fine.run_until(1e6 + 1) == Status::stalled);
  CHECK(fine.result().reason.find("a step of 1e-12 s is too short to move the clock") != std::string::npos);

  // A light body on a ball joint that is far from its centre of mass: with tight tolerances, its spin about the line through both
  // is rounding noise.
  Model light({.gravity = {}});
  light.add({.name = "light", .mass = 1, .com = {0.7, 0.5, 0.3}, .inertia = diagonal(1e-14), .joint = Ball{}, .v = {1, 2, 3}});
  Simulation noisy(light, {.method = "dop853", .rtol = 1e-12, .atol = 1e-12});
  CHECK(noisy.run_until(5) == Status::stalled);
  CHECK(noisy.result().reason.find("use larger rtol and atol") != std::string::npos);

  // Events that trigger each other, each slightly later.
  Simulation busy(model, {.step = 1e-3});
  busy.at(0).then(impulse("chain/1", {})).named("first");
  busy.after("first", 1e-12).then(impulse("chain/1", {})).named("second");
  busy.after("second", 1e-12).then(impulse("chain/1", {})).named("first");
  CHECK(busy.run_until(1) == Status::stalled);
  CHECK(busy.result().reason.find("events follow each other endlessly") != std::string::npos);
  CHECK(busy.result().reason.find("'second: impulse chain/1'") != std::string::npos);
}

TEST_CASE("a run whose length is a multiple of the step has no short last step") {
  const Model model = chain(1);
  for (const double every : {25e-6, 0.03}) {
    Simulation sim(model, {.step = 25e-6});
    sim.observe(every, [](const World&) { return true; });
    REQUIRE(sim.run_until(3) == Status::ok);
    CHECK(sim.statistics().steps == 120'000);
  }
}

TEST_CASE("missed events: their time, the event that they follow, or the nearest value of their condition") {
  Model model({.gravity = {}});
  model.add(
      {.name = "swing", .mass = 1, .inertia = diagonal(1), .joint = Prismatic{.stiffness = 4 * 9.869604401089358}, .q = 1.0});
  const Action nothing = impulse("swing", {});
  for (const char* method : {"rk4", "dop853"}) {
    Simulation sim(model, {.method = method, .step = 0.02});
    sim.at(5).then(nothing).named("later");
    sim.after("later", 1).then(nothing).named("after it");
    sim.when(position_of("swing").below(-1.25)).then(nothing).named("far");  // the pendulum reaches −1, at 0.5 s
    sim.when(position_of("swing").below(-0.5).lasting(1)).then(nothing).named("long");
    sim.when(position_of("swing").exceeds(0.5)).then(nothing).named("at once");
    REQUIRE(sim.run_until(0.9) == Status::ok);
    const std::vector<MissedEvent> missed = sim.missed();
    REQUIRE(missed.size() == 4);
    CHECK(missed[0].name == "later");
    CHECK(missed[0].time == 5);
    CHECK(missed[1].after == "later");
    CHECK(missed[1].time == HUGE_VAL);
    CHECK(missed[2].quantity == "position");
    CHECK(missed[2].threshold == -1.25);
    CHECK_FALSE(missed[2].exceeds);
    CHECK(missed[2].nearest == doctest::Approx(-1).epsilon(1e-3));
    CHECK(missed[2].nearest_time == doctest::Approx(0.5).epsilon(1e-2));
    CHECK(missed[3].nearest == doctest::Approx(-1).epsilon(1e-3));
    CHECK(missed[3].lasts == 1);
    CHECK(missed[3].held == doctest::Approx(1.0 / 3).epsilon(0.2));
  }
}

TEST_CASE("a warning about the energy balance has advice") {
  Simulation rough(chain(20), {.step = 4e-3});
  REQUIRE(rough.run_until(1) == Status::ok);
  const EnergyBalance energy = rough.energy();
  CHECK(energy.largest_kinetic > 0);
  CHECK(std::fabs(energy.error) > 1e-3 * energy.largest_kinetic);
  const std::string advice = energy.advice({.step = 4e-3});
  CHECK(advice.find("the energy balance is off by ") == 0);
  CHECK(advice.find("use a smaller step, such as 0.001 s, or an adaptive method") != std::string::npos);
  CHECK(energy.advice({.method = "dopri5", .rtol = 1e-4}).find("rtol = 1e-06") != std::string::npos);
  Simulation exact(chain(2), {.method = "dop853"});
  REQUIRE(exact.run_until(1) == Status::ok);
  CHECK(exact.energy().advice({.method = "dop853"}).empty());
  Simulation still(Model(), {});
  CHECK(still.energy().advice({}).empty());
}

// It flies to and fro between elastic stops, in 1e-7 s from one to the other: 10,000 impacts a millisecond. A hundredth more for
// each stop is permitted. Twice as fast, the run ends at the impact after that, and keeps them all.
TEST_CASE("events before contacts are stepped through do not count as a flood afterwards") {
  std::vector<Event> events(12'000);
  double now = 0;
  const auto happen = [&](std::size_t first) {
    for (std::size_t i = first; i < events.size(); ++i) events[i].name = "impact", events[i].time = now += 1e-8;
  };
  happen(0);
  REQUIRE(may_be_flood(events, now, 1e-3));
  CHECK(flood_text(events, now, 1e-3, {}));
  events.emplace_back().time = now;
  events.back().name = "stepping", events.back().stepped = {"ball"};
  CHECK_FALSE(flood_text(events, now, 1e-3, {}));
  events.resize(events.size() + 10'001);
  happen(events.size() - 10'001);
  CHECK(flood_text(events, now, 1e-3, {}));
}

TEST_CASE("a flood of events ends a run within its bound, and keeps what was computed") {
  for (const double speed : {1.0, 2.0}) {
    CAPTURE(speed);
    Model model({.gravity = {}});
    model.add({.name = "pin",
               .mass = 1,
               .inertia = diagonal(0.1),
               .joint = Prismatic{.limits = {.lower = 0, .upper = 1e-7, .restitution = 1}},
               .q = 0.5e-7,
               .v = speed});
    Simulation sim(model, {.step = 1e-3});
    const RunResult result = sim.run_until(1.005e-3);
    const double rate = speed / 1e-7;
    CHECK(sim.world().joint({0}).v[0] * sim.world().joint({0}).v[0] == doctest::Approx(speed * speed).epsilon(1e-12));
    if (speed == 1) {
      CHECK(result == Status::ok);
      CHECK(std::fabs(static_cast<double>(sim.events().size()) - 1.005e-3 * rate) < 2);
      continue;
    }
    CHECK(result == Status::stalled);
    CHECK(std::fabs(static_cast<double>(sim.events().size()) - 10'200) <= 1);
    CHECK(std::fabs(sim.time() * rate - 10'200) < 2);
    CHECK(sim.result().reason.find("events follow each other endlessly: 10200 of them took ") != std::string::npos);
    CHECK(sim.result().reason.find("'stop: hit pin lower'") != std::string::npos);
    CHECK(sim.result().reason.find("give the joint's limits less restitution or a larger rest_speed") != std::string::npos);
  }
}

TEST_CASE("a run without end is not mistaken for one that makes no progress") {
  Model model({.gravity = {}});
  model.add({.name = "calm", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}});
  for (const char* method : {"rk4", "dopri5"}) {
    CAPTURE(std::string(method));
    Simulation sim(model, {.method = method, .max_step = 1e-3});
    long looks = 0;
    sim.watch([&looks](double) { return ++looks < 250'000; });
    CHECK(sim.run_until(std::numeric_limits<double>::infinity()) == Status::interrupted);
    CHECK(sim.time() > 200);
  }
}

TEST_CASE("a world in equilibrium closes its energy balance to rounding, without a warning") {
  Model model({.gravity = {0, 0, -9.81}});
  model.add({.name = "weight",
             .mass = 3,
             .inertia = diagonal(1),
             .joint = Prismatic{.axis = {0, 0, 1}, .stiffness = 100},
             .q = -3 * 9.81 / 100});
  Simulation sim(model);
  REQUIRE(sim.run_until(2) == Status::ok);
  CHECK(sim.energy().largest_kinetic < 1e-20);
  CHECK(sim.energy().advice({}) == "");
  EnergyBalance nothing;  // without a scale: the square of a speed of rounding size
  nothing.error = -2.35e-68;
  CHECK(nothing.advice({}) == "");
}

TEST_CASE("what lies still is no reason for a warning, and slow motion that is computed badly is one") {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId box = model.add({.name = "box",
                                .mass = 40,
                                .com = {0.03, 0.01, -0.02},
                                .inertia = diagonal(1.2, 1.0, 1.4),
                                .joint = Free{},
                                .q = {0.3, 0.2, 0.25, std::cos(0.2), 0, 0, std::sin(0.2)}});
  model.add_collider({.body = box, .solid = contact::box({0.6, 0.4, 0.5})});
  model.add_collider({.plane = true});
  for (const char* method : {"rk4", "dop853", "stepping"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method});
    REQUIRE(sim.run_until(2));
    CHECK(sim.warnings().empty());
  }
  // A pendulum that swings by 0.01 rad, with a step of a quarter of its period.
  Model slow({.gravity = {0, 0, -9.81}});
  slow.add({.name = "bob", .mass = 1, .com = {0, 0, -1}, .joint = Revolute{.axis = {0, 1, 0}}, .q = 0.01});
  Simulation swings(slow, {.step = 0.5});
  REQUIRE(swings.run_until(20));
  REQUIRE(swings.warnings().size() == 1);
  CHECK(swings.warnings()[0].find("the largest kinetic energy") != std::string::npos);
}

TEST_CASE("the energy balance of steps through contacts is off from a thousandth of the kinetic energy on") {
  EnergyBalance balance{.initial = 1, .final = 0.5, .lost_in_impacts = 0.5, .lost_in_steps = 0.5, .largest_kinetic = 1};
  const Integration how{.method = "stepping"};
  balance.error = 0.9e-3;
  CHECK(balance.advice(how).empty());
  balance.error = -1.1e-3;
  CHECK(balance.advice(how).find("contacts were stepped through") != std::string::npos);
  balance.error = 0;
  balance.projection = 0.04;
  CHECK(balance.advice(how).empty());
  balance.projection = 0.06;
  CHECK(balance.advice(how).find("removing overlaps") == 0);
  balance.of_heights = 1e4;  // a resting building beside it
  CHECK(balance.advice(how).empty());
  balance.projection = 1.1;
  CHECK(balance.advice(how).find("removing overlaps") == 0);
}

TEST_CASE("axes that are nearly parallel or nearly at right angles are not treated as exactly so") {
  for (const double angle : {0.0, 1.5707963267948966}) {
    for (const double off : {1e-14, 1e-11, 6e-9, 1e-8, 4e-8, 1e-7}) {
      CAPTURE(angle);
      CAPTURE(off);
      const double s = std::sin(angle + off), c = std::cos(angle + off);
      Model model;
      const BodyId hull =
          model.add({.name = "hull", .mass = 1, .inertia = diagonal(0.1), .joint = Revolute{.axis = z_axis}, .v = 2});
      model.add({.name = "arm",
                 .mass = 2,
                 .com = {0.3, 0.2, 0.1},
                 .inertia = diagonal(0.1),
                 .parent = hull,
                 .at = {0.4, 0, 0},
                 .joint = Revolute{.axis = {0, s, c}},
                 .v = 3});
      Simulation sim(model);
      const Event e = sim.apply(lock("arm"));
      // Kernels give the transmitted impulses, totals the momenta of the bodies.
      const Vec3 ground_impulse{e.ground_impulse[0], e.ground_impulse[1], e.ground_impulse[2]};
      CHECK(norm(e.after.linear - e.before.linear - ground_impulse) < 1e-14);
    }
  }
}
