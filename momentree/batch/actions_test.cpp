// Actions in worlds of a batch are those of a Simulation.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/batch/batch.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

// A chaser that floats, and an arm on the ground, whose joints are named otherwise than their bodies.
Model scene() {
  Model model({.gravity = {0, 0, -2}});
  BodyId last = ground;
  for (int k = 0; k < 4; ++k) {
    BodySpec body{.name = "arm/" + std::to_string(k),
                  .mass = 2.0 - 0.3 * k,
                  .com = {0.2, 0.01, 0},
                  .inertia = {0.02, 0.03, 0.04, 0.001, 0, 0},
                  .parent = last,
                  .at = {k == 0 ? 0 : 0.5, 0, 0},
                  .joint = Revolute{.axis = {0.2 * k, 1, 0.1}, .damping = 0.1, .armature = 0.01},
                  .q = 0.2 * k,
                  .v = 1.0 - 0.4 * k};
    body.joint_name = "turn/" + std::to_string(k);
    last = model.add(body);
  }
  const BodyId hull = model.add({.name = "chaser/hull",
                                 .mass = 5,
                                 .inertia = diagonal(0.5, 0.6, 0.7),
                                 .joint = Free{},
                                 .q = {3, 0, 0, 1, 0, 0, 0},
                                 .v = {-0.2, 0, 0.1, 0.3, 0, 0}});
  model.add({.name = "chaser/panel",
             .mass = 1,
             .com = {0, 0.3, 0},
             .inertia = diagonal(0.1),
             .parent = hull,
             .at = {0, 0.4, 0},
             .joint = Ball{.stiffness = 2.0},
             .q = {1, 0, 0, 0},
             .v = {0.1, 0.2, -0.3}});
  return model;
}

double difference(std::span<const double> a, std::span<const double> b) {
  REQUIRE(a.size() == b.size());
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, std::fabs(a[i] - b[i]));
  return worst;
}

bool near(const Totals& a, const Totals& b) {
  return std::fabs(a.kinetic - b.kinetic) < 1e-9 && std::fabs(a.potential - b.potential) < 1e-9 &&
         norm(a.linear - b.linear) < 1e-9 && norm(a.angular - b.angular) < 1e-9;
}

void check_equal(const Event& one, const Event& other) {
  CHECK(one.name == other.name);
  CHECK(std::fabs(one.time - other.time) < 1e-12);
  CHECK(one.actions == other.actions);
  CHECK(one.mechanisms_before == other.mechanisms_before);
  CHECK(one.mechanisms_after == other.mechanisms_after);
  CHECK(one.topology.gone == other.topology.gone);
  REQUIRE(one.topology.joints.size() == other.topology.joints.size());
  for (std::size_t i = 0; i < one.topology.joints.size(); ++i)
    CHECK(one.topology.joints[i].name == other.topology.joints[i].name);
  CHECK(near(one.before, other.before));
  CHECK(near(one.after, other.after));
  CHECK(std::fabs(one.lost - other.lost) < 1e-9);
  CHECK(std::fabs(one.released - other.released) < 1e-9);
  CHECK(std::fabs(one.work - other.work) < 1e-9);
  CHECK(std::fabs(one.hardest_linear - other.hardest_linear) < 1e-9);
  REQUIRE(one.impulse.size() == other.impulse.size());
  for (std::size_t i = 0; i < one.impulse.size(); ++i) {
    CHECK(one.impulse[i].first == other.impulse[i].first);
    CHECK(difference(one.impulse[i].second, other.impulse[i].second) < 1e-9);
  }
}

struct Step {
  std::vector<Action> actions;
  std::string name;
};
// Sequences of events, by world.
std::vector<std::vector<Step>> programs() {
  return {
      {{{break_joint("turn/2")}, "cut"}, {{lock("turn/1"), impulse("arm/2", {1, 2, 3})}, ""}, {{break_joint("arm/2")}, ""}},
      {{{weld("chaser/panel", "arm/3")}, "grasp"}, {{change_joint("grasp", Kind::ball)}, ""}, {{break_joint("grasp")}, ""}},
      {{{attach("chaser/hull", "ground", Prismatic{.axis = x_axis})}, "rail"}, {{lock("rail")}, ""}, {{unlock("rail")}, "go"}},
      {{{reroot("chaser/panel")}, ""}, {{free_joint("turn/3")}, ""}, {{set_parameters("turn/0", {.damping = 3})}, "stiff"}},
      {{{lock("turn/0"), lock("turn/1"), break_joint("turn/3")}, ""},
       {{change_joint("turn/2", Kind::weld)}, ""},
       {{unlock("turn/0")}, ""}},
  };
}

}  // namespace

TEST_CASE("the same actions at the same instants give the same events and motion as in a simulation") {
  const Model model = scene();
  for (const Variables variables : {Variables::momenta, Variables::velocities})
    for (const int threads : {1, 3}) {
      Batch batch(model, 25, {.variables = variables, .threads = threads});
      std::vector<Simulation> alone;
      for (int i = 0; i < 5; ++i) alone.emplace_back(model, Integration{.variables = variables});
      for (std::size_t event = 0; event < 4; ++event) {
        for (int k = 0; k < 20; ++k) batch.step(1e-3);
        for (int world = 0; world < 25; ++world) {
          Simulation& sim = alone[static_cast<std::size_t>(world % 5)];
          if (world < 5) REQUIRE(sim.run_until(0.02 * static_cast<double>(event + 1)) == Status::ok);
          CHECK(difference(batch.state(world).q(), sim.world().state().q()) < 1e-9);
          CHECK(difference(batch.state(world).y(), sim.world().state().y()) < 1e-9);
        }
        if (event == 3) break;
        for (int world = 0; world < 25; ++world) {
          Simulation& sim = alone[static_cast<std::size_t>(world % 5)];
          const Step step = programs()[static_cast<std::size_t>(world % 5)][event];
          CAPTURE(world);
          CAPTURE(event);
          if (world < 5) static_cast<void>(sim.apply(step.actions, step.name));
          check_equal(batch.apply(world, step.actions, step.name), sim.events().back());
        }
        CHECK(batch.groups() == 5);
      }
    }
}

TEST_CASE("names that actions gave stay with their world, and no other world has them") {
  Batch batch(scene(), 3);
  CHECK(batch.apply(1, weld("chaser/hull", "arm/3"), "grasp").name == "grasp");
  CHECK(batch.apply(0, break_joint("turn/1")).name == "#1");
  CHECK(batch.joint_name(1, {4}) == "grasp");
  CHECK(batch.joint_name(0, {4}) == "chaser/hull");
  CHECK(batch.joint_name(0, {1}) == "arm/1");
  CHECK(error_of([&] { batch.apply(2, break_joint("grasp")); }).find("'grasp'") != std::string::npos);
  const Event event = batch.apply(1, break_joint("grasp"));
  CHECK(event.name == "#2");
  CHECK(event.mechanisms_after.size() == 2);
  CHECK(batch.joint_name(1, {4}) == "chaser/hull");
  CHECK(batch.groups() == 3);  // the mechanism that was grasped is attached otherwise than at first
}

TEST_CASE("after changes without names, parts have those that actions would have given") {
  Batch batch(scene(), 2);
  batch.apply(0, Break{{2}});
  CHECK(batch.joint_name(0, {2}) == "arm/2");
  const Event event = batch.apply(0, lock("turn/1"));
  CHECK(event.mechanisms_before == std::vector<std::string>{"arm", "arm/2", "chaser"});
  CHECK(batch.apply(0, weld("arm/2", "chaser/panel"), "dock").mechanisms_after == std::vector<std::string>{"arm", "chaser"});
  batch.apply(0, Break{{2}});
  CHECK(batch.joint_name(0, {2}) == "arm/2");
  CHECK(batch.joint_name(1, {2}) == "turn/2");
  batch.apply(0, Remove{{2}});
  CHECK(batch.joint_name(0, {2}).empty());
  CHECK(batch.apply(0, impulse("arm/0", {1, 0, 0})).mechanisms_after == std::vector<std::string>{"arm", "chaser"});
}

TEST_CASE("an impossible action is refused as in a simulation, and leaves the world unchanged") {
  Batch batch(scene(), 2);
  Simulation sim(scene(), {.variables = Variables::momenta});
  batch.step(1e-3);
  REQUIRE(sim.run_until(1e-3) == Status::ok);
  const std::vector<Action> impossible[] = {{break_joint("turn/9")},
                                            {impulse("arm/1", {1, 0, 0}), break_joint("turn/9")},
                                            {lock("turn/1"), change_joint("turn/1", Kind::ball)},
                                            {unlock("nothing")}};
  const State before = batch.state(0);
  for (const std::vector<Action>& actions : impossible) {
    const std::string said = error_of([&] { batch.apply(0, actions); });
    CHECK_FALSE(said.empty());
    CHECK(said == error_of([&] { sim.apply(actions); }));
  }
  const Action ring = weld("arm/3", "arm/3");
  CHECK_FALSE(error_of([&] { batch.apply(0, ring); }).empty());
  CHECK(error_of([&] { batch.apply(0, ring, "ring"); }) == error_of([&] { sim.apply(ring, "ring"); }));
  const Action strong = set_parameters("turn/1", {.strength = {.force = 10}});
  CHECK(error_of([&] { batch.apply(0, strong, "weak"); }).find("strengths") != std::string::npos);
  CHECK(batch.groups() == 1);
  CHECK(difference(batch.state(0).q(), before.q()) == 0);
  CHECK(difference(batch.state(0).p(), before.p()) == 0);
  CHECK(batch.apply(0, break_joint("turn/3")).name == "#1");
  CHECK(batch.groups() == 2);

  Model larger = scene();
  const BodyId extra = larger.add({.name = "x", .mass = 1, .inertia = diagonal(0.1), .parent = {3}, .joint = Revolute{}});
  batch.apply(1, Add{&larger[extra]});
  CHECK(error_of([&] { batch.apply(1, lock("turn/0")); }).find("bodies were added") != std::string::npos);
}

TEST_CASE("worlds in float have actions, too") {
  Batch batch(scene(), 4, {.precision = Precision::float32, .threads = 2});
  for (int k = 0; k < 10; ++k) batch.step(1e-3);
  const Event event = batch.apply(2, std::vector<Action>{break_joint("turn/2"), lock("turn/0")}, "both");
  CHECK(event.lost > 0);
  for (int k = 0; k < 10; ++k) batch.step(1e-3);
  CHECK_FALSE(batch.diverged(2));
  CHECK(batch.time(2) == batch.time(1));
}
