// Interactive changes while a world runs: actions that may be refused, names that actions give, another gravity.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {
namespace {

Model two_links(Vec3 gravity) {
  Model model(Model::Options{gravity});
  const BodyId arm = model.add({.name = "m/arm", .mass = 2, .com = {0.5, 0, 0}, .inertia = diagonal(0.2), .joint = Revolute{}});
  model.add({.name = "m/hand",
             .mass = 1,
             .com = {0.2, 0, 0},
             .inertia = diagonal(0.1),
             .parent = arm,
             .at = {{1, 0, 0}},
             .joint = Revolute{}});
  return model;
}

Model stone(Vec3 gravity) {
  Model model(Model::Options{gravity});
  model.add({.name = "stone", .mass = 3, .inertia = diagonal(0.1), .joint = Free{}});
  return model;
}

}  // namespace

TEST_CASE("an action on a joint that an event makes only later says so, and on one that is gone, that") {
  Model model = two_links({});
  model.add({.name = "sat", .mass = 3, .inertia = diagonal(0.1), .joint = Free{}, .q = {0, 0, 2, 1, 0, 0, 0}});
  Simulation sim(model, {.step = 1e-3});
  sim.at(0.2).then(weld("sat", "m/hand")).named("clasp");
  for (const double time : {0.1, 0.3, 0.4}) sim.at(time).then(break_joint("clasp"));
  REQUIRE(sim.run_until(0.5));
  REQUIRE(sim.events().size() == 4);
  CHECK(sim.events()[0].actions[0].skipped == "the joint does not exist yet: event 'clasp' makes it");
  CHECK(sim.events()[2].actions[0].skipped.empty());
  CHECK(sim.events()[3].actions[0].skipped == "the joint no longer exists");
}

TEST_CASE("limits that do not contain the position of the joint are refused, unless they are soft") {
  const JointLimits above{.lower = 1, .upper = 2}, below{.upper = -0.5}, soft{.lower = 1, .stiffness = 10};
  for (const bool loop : {false, true}) {
    Model model = two_links({});
    if (loop) {
      const BodyId bar = model.add({.name = "bar", .mass = 1, .inertia = diagonal(0.1), .joint = Free{}});
      model.add_loop({.name = "pin", .body = bar, .joint = Revolute{}});
    }
    const std::string joint = loop ? "pin" : "m/arm";
    Simulation sim(model, {.step = 1e-3});
    CHECK(sim.try_apply(set_parameters(joint, {.limits = above})).reason.find("limits: the joint is at 0, below them") !=
          std::string::npos);
    CHECK(sim.try_apply(set_parameters(joint, {.limits = below})).reason.find("limits: the joint is at 0, above them") !=
          std::string::npos);
    CHECK(sim.try_apply(set_parameters(joint, {.limits = soft})));
    CHECK(sim.try_apply(set_parameters(joint, {.limits = {.lower = 0, .upper = 2}})));
    // Where it will be at that time is not known before.
    sim.at(0.1).then(set_parameters(joint, {.limits = above}));
    CHECK(sim.dry_run().issues.empty());
    // A joint that is made begins at zero.
    const Prismatic made{.axis = {0, 0, 1}, .limits = above};
    CHECK(sim.try_apply(attach("m/hand", "ground", made)).reason.find("limits: the joint is at 0, below them") !=
          std::string::npos);
    CHECK(sim.try_apply(change_joint("m/arm", made)).reason.find("limits: the joint is at 0, below them") != std::string::npos);
    sim.at(0.1).then(attach("m/hand", "ground", made));
    CHECK(sim.dry_run().issues.size() == 1);
  }
}

TEST_CASE("a joint that an action makes has the name that the action gives it, and later actions find it by that name") {
  Model model = two_links({});
  for (int k = 0; k < 2; ++k)
    model.add({.name = k == 0 ? "sat/hull" : "tug/hull",
               .mass = 3,
               .inertia = diagonal(0.1),
               .joint = Free{},
               .q = {0, 0, 2.0 + k, 1, 0, 0, 0},
               .v = {0.1, 0, -0.2, 0, 0.3, 0}});
  Simulation sim(model, {.step = 1e-3});
  const World& world = sim.world();
  const std::vector<Action> join{weld("sat/hull", "tug/hull", "clasp"), attach("tug/hull", "m/hand", Ball{})};
  const Event both = sim.apply(join, "capture");
  CHECK(both.actions[0].joint == "clasp");
  CHECK(both.actions[1].joint == "capture");  // the only one without a name of its own
  REQUIRE(world.find_joint("clasp") >= 0);
  CHECK(world.joint({world.find_joint("clasp")}).kind == Kind::weld);
  CHECK(world.joint({world.find_joint("capture")}).kind == Kind::ball);
  CHECK_THROWS_AS(sim.apply(weld("sat/hull", "ground", "clasp")), Error);
  sim.apply(break_joint("clasp"));
  CHECK(world.mechanism_names() == std::vector<std::string>{"m", "sat/hull"});
  sim.apply(attach("sat/hull", "ground", Ball{}, {}, "port/clasp"));
  CHECK(world.joint({world.find_joint("port/clasp")}).kind == Kind::ball);

  Simulation scheduled(model, {.step = 1e-3});
  scheduled.at(0.1).then(weld("sat/hull", "tug/hull", "clasp")).named("capture");
  scheduled.at(0.2).then(break_joint("clasp"));
  CHECK_THROWS_AS(scheduled.at(0.3).then(break_joint("capture")), Error);
  REQUIRE(scheduled.run_until(0.25) == Status::ok);
  CHECK(scheduled.events()[1].action_texts() == std::vector<std::string>{"break clasp"});
}

TEST_CASE("an impossible attempt changes nothing and reports the reason; a possible one is an event") {
  Simulation simulation(two_links({0, -9.81, 0}));
  simulation.keep_history();
  CHECK(simulation.run_until(0.1) == Status::ok);
  const std::vector<double> p(simulation.world().p().begin(), simulation.world().p().end());

  const Action loop = weld("m/hand", "m/arm");  // two bodies of one mechanism
  CHECK(simulation.try_apply({&loop, 1}) == Status::refused);
  CHECK(simulation.result().reason.find("weld") != std::string::npos);
  CHECK(simulation.events().empty());
  CHECK_FALSE(simulation.can_undo(0));

  const Action unknown = break_joint("m/hnd");
  CHECK(simulation.try_apply({&unknown, 1}) == Status::refused);
  CHECK(simulation.result().reason == "break: there is no joint 'm/hnd'; did you mean 'm/hand'?");
  REQUIRE(simulation.check(unknown));
  CHECK(simulation.check(unknown)->problem == "there is no joint 'm/hnd'");
  CHECK_FALSE(simulation.check(break_joint("m/hand")));
  CHECK(std::vector<double>(simulation.world().p().begin(), simulation.world().p().end()) == p);

  const Action cut = break_joint("m/hand");
  CHECK(simulation.try_apply({&cut, 1}) == Status::ok);
  REQUIRE(simulation.events().size() == 1);
  CHECK(simulation.world().mechanisms().size() == 2);
  REQUIRE(simulation.can_undo(0));
  simulation.undo(0);
  CHECK(simulation.world().mechanisms().size() == 1);
  CHECK(std::vector<double>(simulation.world().p().begin(), simulation.world().p().end()) == p);
}

TEST_CASE("without gravity motion is straight; the work of the change is in the energy ledger") {
  Simulation simulation(stone({0, 0, -9.81}));
  simulation.at(1.5).then(impulse("stone", {6, 0, 0}));
  CHECK(simulation.run_until(0.5) == Status::ok);
  const Pose before = simulation.world().motions()[0].pose;
  simulation.set_gravity({0, 0, 0});
  CHECK(simulation.world().model().gravity() == Vec3{0, 0, 0});
  CHECK(simulation.world().motions()[0].pose.position.z == before.position.z);
  CHECK(simulation.run_until(2) == Status::ok);
  const BodyMotion& end = simulation.world().motions()[0];
  CHECK(end.pose.position.z == doctest::Approx(-0.5 * 9.81 * 0.25 - 9.81 * 0.5 * 1.5));
  CHECK(end.linear.x == doctest::Approx(2));  // the scheduled action still happened
  CHECK(end.pose.position.x == doctest::Approx(1));
  REQUIRE(simulation.events().size() == 1);
  // m g z for the height at which gravity was turned off, and the impulse's ½ m v².
  CHECK(simulation.energy().work == doctest::Approx(3 * 9.81 * 0.5 * 9.81 * 0.25 + 0.5 * 3 * 4));
  CHECK(std::abs(simulation.energy().error) < 1e-10);
}

TEST_CASE("a world whose gravity changed keeps its topology, functions and undo") {
  Simulation simulation(two_links({0, -9.81, 0}));
  simulation.force("m/arm", [](const EvaluationContext&) { return Wrench{{0, 0, 0}, {0, 0, 0.5}}; });
  simulation.apply(break_joint("m/hand"));
  CHECK(simulation.run_until(0.2) == Status::ok);
  const SimulationSnapshot kept = simulation.snapshot();
  simulation.set_gravity({0, 0, 0});
  CHECK(simulation.world().mechanisms().size() == 2);
  CHECK(simulation.world().tree().loads().functions.size() == 1);
  const double spin = simulation.world().joint({0}).v[0];
  CHECK(simulation.run_until(0.4) == Status::ok);
  // Only the torque on the arm, about its joint axis: m c² + I.
  CHECK(simulation.world().joint({0}).v[0] == doctest::Approx(spin + 0.5 * 0.2 / (2 * 0.25 + 0.2)));
  CHECK(std::abs(simulation.energy().error) < 1e-9);

  Simulation straight(two_links({0, -9.81, 0}));  // the same without the detour
  straight.force("m/arm", [](const EvaluationContext&) { return Wrench{{0, 0, 0}, {0, 0, 0.5}}; });
  straight.apply(break_joint("m/hand"));
  CHECK(straight.run_until(0.2) == Status::ok);
  CHECK(straight.run_until(0.4) == Status::ok);
  simulation.set_gravity({0, -9.81, 0});
  simulation.restore(kept);
  CHECK(simulation.run_until(0.4) == Status::ok);
  for (std::size_t i = 0; i < straight.world().state().q().size(); ++i)
    CHECK(simulation.world().state().q()[i] == straight.world().state().q()[i]);
}

TEST_CASE("a joint can't change while momenta overflow; nothing has happened then") {
  Simulation simulation(two_links({0, -9.81, 0}));
  const std::vector<double> q(simulation.world().state().q().begin(), simulation.world().state().q().end());
  const std::vector<double> p(simulation.world().p().size(), 1e308);
  simulation.set_state(0, q, p);
  std::string reason;
  try {
    simulation.apply(free_joint("m/hand"));
  } catch (const Error& error) {
    reason = error.message();
  }
  CHECK(reason.find("kinetic energy is not finite") != std::string::npos);
  CHECK(simulation.events().empty());
  CHECK(simulation.world().p()[0] == 1e308);
}

}  // namespace momentree
