#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

// A chain that swings from a revolute joint; `strength` of its links, in the order of the chain.
Model chain(const std::vector<JointStrength>& strengths) {
  Model model({.gravity = {0, 0, -9.81}});
  BodyId parent = ground;
  for (std::size_t k = 0; k < strengths.size(); ++k) {
    Revolute joint{.axis = k % 2 == 0 ? y_axis : x_axis, .damping = 1e-3};
    joint.strength = strengths[k];
    const std::string name = "link" + std::to_string(k);
    parent = model.add({.name = name,
                        .mass = 1,
                        .com = {0.5, 0, 0},
                        .inertia = diagonal(0.01, 0.1, 0.1),
                        .parent = parent,
                        .at = {k == 0 ? 0.0 : 1.0, 0, 0},
                        .joint = joint,
                        .q = 0.02 * static_cast<double>(k)});
  }
  return model;
}

}  // namespace

TEST_CASE("strengths break joints as explicit events do, bit for bit") {
  for (const char* method : {"rk4", "dopri5"}) {
    const std::vector<JointStrength> strengths{{.force = 45, .torque = 30}, {.force = 28}, {.force = 12}, {.force = 4.6}};
    Simulation borne(chain(strengths), {.method = method, .step = 5e-3});
    Simulation told(chain(std::vector<JointStrength>(4)), {.method = method, .step = 5e-3});
    for (std::size_t k = 0; k < strengths.size(); ++k) {
      const std::string name = "link" + std::to_string(k);
      if (strengths[k].force < 1e9) told.when(reaction_force(name).exceeds(strengths[k].force)).then(break_joint(name));
      if (strengths[k].torque < 1e9) told.when(reaction_torque(name).exceeds(strengths[k].torque)).then(break_joint(name));
    }
    REQUIRE(borne.run_until(1.5) == Status::ok);
    REQUIRE(told.run_until(1.5) == Status::ok);
    REQUIRE(borne.events().size() >= 3);
    CHECK(borne.events()[0].name.starts_with("strength of link"));
    std::vector<std::string> broken[2];
    for (const Simulation* sim : {&borne, &told})
      for (const Event& e : sim->events())
        if (e.mechanisms_after.size() > e.mechanisms_before.size())
          broken[sim == &told].push_back(std::to_string(e.time) + e.actions[0].text());
    CHECK(broken[0] == broken[1]);
    const auto p = borne.world().p(), other = told.world().p();
    const auto q = borne.world().state().q(), other_q = told.world().state().q();
    CHECK(std::vector<double>(p.begin(), p.end()) == std::vector<double>(other.begin(), other.end()));
    CHECK(std::vector<double>(q.begin(), q.end()) == std::vector<double>(other_q.begin(), other_q.end()));
  }
}

TEST_CASE("torques of strengths and conditions are about the joint's frame, in the tree and in loops") {
  // A rod of mass 2 and length 1, its frame at one end, on two smooth pins that are 1 m apart: no pin transmits a torque,
  // wherever the frame of the body is.
  for (const bool both : {false, true}) {
    Model model({.gravity = {0, 0, -9.81}});
    Revolute pin{.axis = y_axis, .strength = {.torque = 1e-9}};
    model.add({.name = "rod",
               .mass = 2,
               .com = {0.5, 0, 0},
               .inertia = diagonal(0.01, 0.2, 0.2),
               .joint = pin,
               .q = both ? 0.0 : 0.6,
               .child_at = {1, 0, 0},
               .joint_name = "right"});
    if (both) {  // the block, on smooth ground, carries half of the rod by a hook
      const BodyId block = model.add({.name = "block", .mass = 1, .inertia = diagonal(0.1), .at = {-2, 0, 0}, .joint = Planar{}});
      Ball hook{.strength = {.torque = 1e-9}};
      model.add_loop({.name = "left", .body = {0}, .to = block, .joint = hook, .at = {1, 0, 0}});
    }
    Simulation sim(model, {.step = 1e-3});
    sim.when(reaction("right", "my").exceeds(1e-9)).then(lock("right"));
    sim.when(reaction_torque("right").exceeds(1e-9)).then(lock("right"));
    CHECK(sim.run_until(0.5) == Status::ok);
    CHECK(sim.events().empty());
    CHECK(norm(sim.world().joint_forces({0}).reaction.force) > 5);
  }
}

TEST_CASE("a strength stays with a joint that is reversed, and events can follow its break") {
  Model model({.gravity = {}});
  const BodyId hull = model.add({.name = "hull", .mass = 5, .inertia = diagonal(1), .joint = Free{}});
  model.add({.name = "arm",
             .mass = 1,
             .com = {0.5, 0, 0},
             .inertia = diagonal(0.1),
             .parent = hull,
             .at = {0.5, 0, 0},
             .joint = Revolute{.effort = 1, .strength = {.force = 1.5}}});
  double times[2];
  for (const bool turned : {false, true}) {
    Simulation sim(model, {.method = "dopri5", .rtol = 1e-11, .atol = 1e-12});
    sim.after("strength of arm", 0.1).then(impulse("arm", {1, 0, 0})).named("push");
    if (turned) sim.apply(reroot("arm"), "turn");
    REQUIRE(sim.run_until(5) == Status::ok);
    REQUIRE(sim.events().size() == (turned ? 3 : 2));
    CHECK(sim.events()[turned].name == "strength of arm");
    CHECK(sim.events()[turned + 1].name == "push");
    times[turned] = sim.events()[turned].time;
    CHECK(times[turned] > 0.1);
    CHECK(std::fabs(sim.events()[turned + 1].time - (times[turned] + 0.1)) < 1e-15);
    CHECK(sim.world().mechanism_names().size() == 2);
  }
  CHECK(times[0] == doctest::Approx(times[1]).epsilon(1e-7));
}

TEST_CASE("a strength changes at run time, is restored by a snapshot, and is not a numbered event") {
  Simulation sim(chain({{.force = 200}, {}}), {.step = 2e-3});
  sim.at(0.25).then(impulse("link1", {0, 0.1, 0}));
  JointParameters weaker;
  weaker.strength.force = 15;
  sim.at(0.5).then(set_parameters("link1", weaker));
  const SimulationSnapshot start = sim.snapshot();
  std::vector<double> times;
  for (int round = 0; round < 2; ++round) {
    REQUIRE(sim.run_until(2) == Status::ok);
    REQUIRE(sim.events().size() == 3);
    CHECK(sim.events()[0].name == "#1");
    CHECK(sim.events()[1].name == "#2");
    CHECK(sim.events()[2].name == "strength of link1");
    CHECK(sim.events()[2].time >= 0.5);
    times.push_back(sim.events()[2].time);
    sim.restore(start);
  }
  CHECK(times[0] == times[1]);
  const DryRun dry_run = sim.dry_run();
  bool found = false;
  for (const auto& [name, kind] : dry_run.joints) found = found || (name == "link0" && kind == Kind::free);
  CHECK(found);
}

TEST_CASE("a dry run breaks joints that events make with a strength, and is incomplete after them") {
  Simulation sim(chain({{}, {}}));
  Ball hook;
  hook.strength = {.force = 2};
  sim.at(0.1).then(break_joint("link1"));
  sim.at(0.2).named("hook").then(attach("link1", "ground", hook));
  sim.at(0.3).then(weld("link1", "link0"));  // closes a loop unless the hook broke
  const DryRun found = sim.dry_run();
  CHECK(found.issues.empty());
  CHECK(std::count(found.joints.begin(), found.joints.end(), std::pair<std::string, Kind>("link1", Kind::free)) == 1);
}

TEST_CASE("a joint that replaces a broken one has the same strength again") {
  for (const double again : {0.2, 0.5}) {
    CAPTURE(again);
    Simulation sim(chain({{}, {.force = 1}}), {.method = "rk4", .step = 5e-3});
    Revolute weak{.axis = x_axis};
    weak.strength = {.force = 1};
    sim.at(again).named("second").then(attach("link1", "ground", weak));
    REQUIRE(sim.run_until(1) == Status::ok);
    REQUIRE(sim.events().size() == 3);
    CHECK(sim.events()[0].name == "strength of link1");
    CHECK(sim.events()[0].time == 0);
    CHECK(sim.events()[2].name == "strength of second");
    CHECK(sim.events()[2].time >= again);
  }
}

TEST_CASE("strengths of loop joints and of springs are monitored in mechanisms with loops") {
  // Two bars and the ground form a triangle, which bears its weight of 2 m g in its two feet.
  const auto triangle = [](double of_loop, double of_spring) {
    Model model({.gravity = {0, 0, -9.81}});
    const BodyId bar = model.add(
        {.name = "bar", .mass = 1, .com = {0.5, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{.axis = y_axis}, .q = -1.0});
    const BodyId strut = model.add({.name = "strut",
                                    .mass = 1,
                                    .com = {0.5, 0, 0},
                                    .inertia = diagonal(0.1),
                                    .parent = bar,
                                    .at = {1, 0, 0},
                                    .joint = Universal{.axis = y_axis, .axis2 = z_axis},
                                    .q = {2.0, 0}});
    Ball foot;
    foot.strength = {.force = of_loop};
    model.add_loop({.name = "foot", .body = strut, .joint = foot, .at = {1.08, 0, 0}, .child_at = {1, 0, 0}});
    model.add_spring({.name = "rope",
                      .from = {ground, {0.5, 0, 3}},
                      .to = {bar, {1, 0, 0}},
                      .stiffness = 10,
                      .rest = 1,
                      .strength = of_spring});
    return Simulation(model, {.method = "dopri5"});
  };
  const double inf = std::numeric_limits<double>::infinity();
  for (const auto& [of_loop, of_spring, broken] : {std::tuple{inf, inf, ""},
                                                   {1.0, inf, "strength of foot"},
                                                   {1e4, inf, ""},
                                                   {inf, 1.0, "strength of rope"},
                                                   {inf, 1e3, ""}}) {
    CAPTURE(of_loop);
    CAPTURE(of_spring);
    Simulation sim = triangle(of_loop, of_spring);
    REQUIRE(sim.run_until(0.01) == Status::ok);
    REQUIRE(sim.events().size() == (*broken ? 1 : 0));
    if (*broken) CHECK(sim.events()[0].name == broken);
    CHECK(sim.world().loops().size() == (std::string(broken) == "strength of foot" ? 0 : 1));
  }
}
