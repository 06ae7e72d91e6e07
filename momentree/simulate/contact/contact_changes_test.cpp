// Contacts where forces, the state or the world change between two runs, and overlaps that such changes bring about.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/simulate/contact/contact_test_support.hpp>
#include <momentree/simulate/stepping/overlap.hpp>
#include <tests/error_of.hpp>

using namespace momentree;
using namespace momentree::testing;

namespace {

const std::vector<std::string> methods{"rk4", "dopri5", "stepping"};

// Two boxes that overlap, welded to each other by a third body.
Model overlapping() {
  Model model({.gravity = {0, 0, -g}});
  const BodyId one = add_box(model, "one", 0.5);
  const BodyId between =
      model.add({.name = "between", .mass = 0.1, .inertia = diagonal(1e-3), .parent = one, .at = {0, 0, 0.1}, .joint = Weld{}});
  add_box(model, "two", 0.05, between, Weld{});
  model.add_collider({.plane = true});
  return model;
}

Vec3 acceleration(const Simulation& sim, int body) { return sim.world().accelerations()[static_cast<std::size_t>(body)].linear; }

std::vector<std::string> names_since(const Simulation& sim, std::size_t first) {
  std::vector<std::string> names;
  for (std::size_t i = first; i < sim.events().size(); ++i) names.push_back(sim.events()[i].name);
  return names;
}

}  // namespace

TEST_CASE("between runs: forces of contacts follow what is changed, as at the start of a run") {
  struct Change {
    const char* what;
    std::function<void(Simulation&)> make;
    Vec3 force, acceleration;  // of the upper box
  };
  const auto push = [](const Vec3& force) {
    return [force](Simulation& sim) { sim.force("box/1", [force](const EvaluationContext&) { return Wrench{force, {}}; }); };
  };
  const double most = friction * box_mass * g;
  const std::vector<Change> changes{
      {"less gravity",
       [](Simulation& sim) {
         sim.set_gravity({0, 0, -1.62});
       },
       {0, 0, box_mass * 1.62},
       {}},
      {"no gravity", [](Simulation& sim) { sim.set_gravity({}); }, {}, {}},
      {"a push", push({3, 0, 0}), {-3, 0, box_mass * g}, {}},
      {"too strong a push", push({most + 2, 0, 0}), {-most, 0, box_mass * g}, {1, 0, 0}},
      {"lifting", push({0, 0, 2 * box_mass * g}), {}, {0, 0, g}},
      {"a load", push({0, 0, -5}), {0, 0, box_mass * g + 5}, {}},
  };
  for (const std::string& method : methods)
    for (const Change& change : changes) {
      CAPTURE(method);
      CAPTURE(change.what);
      Simulation sim(boxes(2), {.method = method, .step = 1e-3});
      REQUIRE(sim.run_until(0.05));
      change.make(sim);
      const double accuracy = method == "stepping" ? 1e-3 : 1e-6;  // of the state: the pile has moved a little
      CHECK(norm(force_on(sim.world(), {1}) - change.force) < accuracy);
      CHECK(norm(acceleration(sim, 1) - change.acceleration) < accuracy);
      // The run agrees with what was read.
      const Vec3 before = sim.world().motions()[1].linear;
      REQUIRE(sim.run_until(0.06));
      CHECK(norm(sim.world().motions()[1].linear - before - 0.01 * change.acceleration) < accuracy);
    }
}

TEST_CASE("between runs: changes report what begins and ends, and nothing twice") {
  for (const char* method : {"rk4", "dopri5"}) {
    CAPTURE(method);
    Simulation sim(boxes(1), {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.01));
    CHECK(names_since(sim, 0) == std::vector<std::string>{"rest"});
    // The same coordinates and velocities: it goes on resting.
    const std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end());
    const std::vector<double> still(6, 0.0);
    sim.adjust(q, still, Variables::velocities);
    sim.set_gravity({0, 0, -3});
    REQUIRE(sim.run_until(0.02));
    CHECK(names_since(sim, 1).empty());
    // It is moved away, and a snapshot of that goes on in the same way.
    std::vector<double> above = q;
    above[2] += 0.5;
    sim.adjust(above, still, Variables::velocities);
    CHECK(sim.world().contacts().empty());
    CHECK(norm(acceleration(sim, 0) - Vec3{0, 0, -3}) < 1e-12);
    Simulation branch = sim.branch();
    REQUIRE(sim.run_until(0.03));
    REQUIRE(branch.run_until(0.03));
    CHECK(names_since(sim, 1) == std::vector<std::string>{"lift"});
    CHECK(names_since(branch, 1) == std::vector<std::string>{"lift"});
  }
}

TEST_CASE("between runs: forces that are taken back leave the run as it was") {
  for (const std::string& method : methods) {
    CAPTURE(method);
    const auto run = [&](bool changed) {
      Simulation sim(boxes(3), {.method = method, .step = 1e-3});
      REQUIRE(sim.run_until(0.03));
      if (changed) {
        sim.set_gravity({0, 0, g});
        CHECK(norm(force_on(sim.world(), {2})) < 1e-9);
        sim.set_gravity({0, 0, -g});
        for (int k = 0; k < 3; ++k) CHECK(norm(force_on(sim.world(), {k}) - Vec3{0, 0, box_mass * g}) < 1e-6);
      }
      REQUIRE(sim.run_until(0.1));
      CHECK(norm(sim.world().motions()[2].pose.position - Vec3{0, 0, 0.5}) < 1e-5);
      return sim.events().size();
    };
    CHECK(run(true) == run(false));
  }
}

TEST_CASE("between runs: with time stepping, contacts follow actions and added bodies") {
  Simulation sim(boxes(2), {.method = "stepping", .step = 1e-3});
  REQUIRE(sim.run_until(0.05));
  static_cast<void>(sim.apply(impulse("box/1", {0, 0, 1})));
  CHECK(norm(force_on(sim.world(), {1})) < 1e-6);  // it leaves
  CHECK(norm(force_on(sim.world(), {0}) - Vec3{0, 0, box_mass * g}) < 1e-6);
  Simulation start(boxes(1), {.method = "stepping", .step = 1e-3});
  static_cast<void>(start.apply(impulse("box/0", {1, 0, 0})));
  CHECK(norm(force_on(start.world(), {0}) - box_mass * g * Vec3{-friction, 0, 1}) < 1e-6);
  static_cast<void>(
      start.add({.name = "new", .mass = box_mass, .inertia = diagonal(0.02), .joint = Free{}, .q = {1, 0, 0.1, 1, 0, 0, 0}},
                {contact::box({0.4, 0.4, 0.2})}));
  CHECK(norm(force_on(start.world(), {1}) - Vec3{0, 0, box_mass * g}) < 1e-6);
}

TEST_CASE("between runs: forces after a step of stepping that is shorter than usual") {
  for (const double h : {1e-7, 1e-5, 1e-4, 9e-4}) {
    CAPTURE(h);
    Simulation sim(boxes(2), {.method = "stepping", .step = 1e-3});
    REQUIRE(sim.run_until(h));
    for (int k = 0; k < 2; ++k) CHECK(norm(force_on(sim.world(), {k}) - Vec3{0, 0, box_mass * g}) < 1e-4 * box_mass * g);
    REQUIRE(sim.run_until(h + 1e-4));
    for (int k = 0; k < 2; ++k) CHECK(norm(force_on(sim.world(), {k}) - Vec3{0, 0, box_mass * g}) < 0.1 * box_mass * g);
  }
}

TEST_CASE("overlaps: no method accepts them, however they come about") {
  for (const std::string& method : methods) {
    CAPTURE(method);
    Model sunk = boxes(1);
    Simulation low(sunk, {.method = method, .step = 1e-3});
    const std::vector<double> q{0, 0, 0.05, 1, 0, 0, 0}, still(6, 0.0);
    low.adjust(q, still, Variables::velocities);
    for (int k = 0; k < 2; ++k) {
      const RunResult run = low.run_until(0.1);
      CHECK(run.status == Status::stalled);
      CHECK(run.reason.find("'box/0' and 'ground' overlap by 0.05 m") != std::string::npos);
      CHECK(low.time() == 0);
    }
    const std::vector<double> free{0, 0, 0.2, 1, 0, 0, 0};
    low.adjust(free, still, Variables::velocities);
    CHECK(low.run_until(0.01));
    low.set_state(0, q, still, Variables::velocities);
    CHECK(low.run_until(0.1).status == Status::stalled);

    Model model({.gravity = {0, 0, -g}});
    add_box(model, "one", 0.3), add_box(model, "two", 0.45);
    Simulation start(model, {.method = method, .step = 1e-3});
    CHECK(start.run_until(0.1).reason.find("overlap by 0.05 m") != std::string::npos);
  }
}

TEST_CASE("overlaps: an action that brings one about is refused, and nothing has happened") {
  for (const std::string& method : methods) {
    CAPTURE(method);
    Simulation sim(overlapping(), {.method = method, .step = 1e-3}), other = sim.branch();
    REQUIRE(sim.run_until(0.1));
    REQUIRE(other.run_until(0.1));
    const std::string error = error_of([&] { static_cast<void>(sim.apply(break_joint("two"))); });
    CHECK(error.find(": break two: 'one' and 'two' overlap by 0.05 m; only bodies that are welded") != std::string::npos);
    const RunResult tried = sim.try_apply(break_joint("two"));
    CHECK(tried.status == Status::refused);
    CHECK(sim.events().size() == other.events().size());
    CHECK(sim.statistics().changes == 0);
    CHECK(sim.world().mechanisms().size() == 1);
    // A dry run says what the run will say, which names the action, and nothing that helps only at the start.
    sim.at(0.2).then(impulse("two", {})).then(break_joint("two")).named("part");
    const DryRun dry = sim.dry_run();
    REQUIRE(dry.issues.size() == 1);
    CHECK(dry.issues[0].action == 1);
    const RunResult run = sim.run_until(0.5);
    CHECK(run.status == Status::refused);
    CHECK(run.reason == dry.issues[0].message);
    CHECK(run.reason.find("event 'part' at t = 0.2 s: break two: 'one' and 'two' overlap by 0.05 m") == 0);
    CHECK(run.reason.find("resolve") == std::string::npos);
    CHECK(sim.time() == 0.2);
    CHECK(sim.world().mechanisms().size() == 1);
    REQUIRE(other.run_until(0.2));
    const std::span<const double> q = sim.world().state().q(), expected = other.world().state().q();
    CHECK(std::equal(q.begin(), q.end(), expected.begin(), expected.end()));
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("branches of runs with time stepping are exact, whatever conditions look at") {
  int different = 0, fired = 0;
  for (int k = 0; k < 24; ++k) {
    Model model = boxes(1 + k % 3);
    BodySpec arm{.name = "arm", .mass = 1, .com = {0.5, 0, 0}, .inertia = diagonal(0.01, 0.2, 0.2)};
    arm.at = {-0.4, 0, 0.9};
    Revolute joint{.axis = y_axis};
    joint.strength.force = 15 + 5 * k;
    arm.joint = joint;
    model.add_collider({.body = model.add(arm), .solid = contact::sphere(0.1, Pose{{1, 0, 0}, Quat{}})});
    Simulation sim(model, {.method = "stepping", .step = 2e-3});
    sim.when(contact_force_between("box/0", "ground").exceeds(20.0 + 2 * k)).then(impulse("box/0", {0.2, 0, 0.1}));
    sim.when(contact_force_between("box/0", "arm").exceeds(1)).named("hit");
    REQUIRE(sim.run_until(0.05 + 0.037 * k));
    Simulation branch = sim.branch();
    REQUIRE(sim.run_until(sim.time() + 0.3));
    REQUIRE(branch.run_until(sim.time()));
    const std::span<const double> one = sim.world().state().q(), two = branch.world().state().q();
    different += !std::equal(one.begin(), one.end(), two.begin(), two.end()) || sim.events().size() != branch.events().size();
    fired += static_cast<int>(sim.events().size());
  }
  CHECK(different == 0);
  CHECK(fired > 24);
}

TEST_CASE("overlaps: of beams that cross each other, where no corner of one is inside the other") {
  const auto crossing = [](double apart, double turn) {
    Model model({.gravity = {0, 0, -g}});
    for (const double sign : {1.0, -1.0}) {
      const double half = sign > 0 ? 0 : 0.5 * turn;
      const BodyId beam = model.add({.name = sign > 0 ? "one" : "other",
                                     .mass = 1,
                                     .inertia = diagonal(0.1),
                                     .joint = Free{},
                                     .q = {0, 0, 1 + 0.5 * sign * apart, std::cos(half), 0, 0, std::sin(half)}});
      model.add_collider({.body = beam, .solid = contact::box({1, 0.05, 0.05})});
    }
    return model;
  };
  for (const double turn : {0.3, 1.0, 1.5707963267948966}) {
    CAPTURE(turn);
    for (const double depth : {0.045, 0.02, 0.002}) {
      const Model model = crossing(0.05 - depth, turn);
      const std::optional<Overlap> overlap = deepest_overlap(model);
      REQUIRE(overlap.has_value());
      CHECK(overlap->depth == doctest::Approx(depth).epsilon(1e-9));
      for (const std::string& method : methods)
        CHECK(Simulation(model, {.method = method, .step = 1e-3}).run_until(0.01).status == Status::stalled);
      Simulation apart(model, {.resolve = true});
      CHECK(apart.run_until(0.01));
    }
    CHECK(!deepest_overlap(crossing(0.05, turn)).has_value());
    CHECK(!deepest_overlap(crossing(0.051, turn)).has_value());
  }
}

TEST_CASE("overlaps: no method carries out an event by which beams cross each other") {
  for (const std::string& method : methods) {
    CAPTURE(method);
    Model model({.gravity = {}});
    const auto beam = [&](BodySpec spec) {
      spec.mass = 1, spec.inertia = diagonal(0.1);
      const BodyId body = model.add(std::move(spec));
      model.add_collider({.body = body, .solid = contact::box({1, 0.05, 0.05})});
      return body;
    };
    const BodyId turning = beam({.name = "turning", .at = {0, 0, 0.5}, .joint = Revolute{.axis = {0, 0, 1}}, .q = {0.5}});
    const BodyId hub = model.add(
        {.name = "hub", .mass = 0.1, .inertia = diagonal(1e-3), .parent = turning, .at = {0, 0, 0.02}, .joint = Weld{}});
    beam({.name = "crossing", .parent = hub, .at = {{0, 0, 0}, {std::cos(0.5), 0, 0, std::sin(0.5)}}, .joint = Weld{}});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.01));
    CHECK(sim.try_apply(break_joint("crossing")).status == Status::refused);
    CHECK(sim.try_apply(break_joint("turning")).status == Status::ok);
  }
}
