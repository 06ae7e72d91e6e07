// Forces on bodies. (Random trees against an independent oracle: tests/oracle/body_forces_test.cpp.)
#include <momentree/dynamics/forces/body_forces.hpp>

#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

BodySpec ball(std::string name, double mass = 2) {
  return {.name = std::move(name), .mass = mass, .inertia = diagonal(0.3), .joint = Free{}};
}

}  // namespace

TEST_CASE("(20) a force at a point gives a force and a moment, in world axes or in body axes") {
  for (const bool body_axes : {false, true}) {
    Model model({.gravity = {}});
    const double half = std::sqrt(0.5);
    BodySpec spec = ball("m/a");
    spec.q = {0, 0, 0, half, 0, 0, half};  // a rotation by 90° about z
    const BodyId a = model.add(spec);
    model.add_force(
        {.body = a, .point = {0.5, 0, 0}, .force = {0.0, 3.0, 0.0}, .torque = {0.0, 0.0, 1.0}, .body_axes = body_axes});
    const Tree tree = compile(model);
    const State state = start_state(model, tree);
    Workspace<double> workspace(tree);
    forward_dynamics(tree, state, workspace);
    // World y is the body's x after the rotation.
    CHECK(workspace.pdot[0] == doctest::Approx(body_axes ? 0 : 3));
    CHECK(workspace.pdot[1] == doctest::Approx(body_axes ? 3 : 0));
    CHECK(workspace.pdot[5] == doctest::Approx(body_axes ? 2.5 : 1));
    accelerate(tree, state, workspace);
    CHECK(workspace.a[5] == doctest::Approx((body_axes ? 2.5 : 1) / 0.3));
    CHECK(norm(reaction(tree, state, workspace, tree.inboard_joint({0})).force) < 1e-14);  // unconstrained
    CHECK(norm(reaction(tree, state, workspace, tree.inboard_joint({0})).torque) < 1e-14);
  }
}

TEST_CASE("a pendulum in the wind: the joint receives the moment, and its reaction balances the force") {
  Model model({.gravity = {}});
  const BodyId a = model.add(
      {.name = "m/a", .mass = 1, .com = {0, 0, -1}, .inertia = diagonal(0.1), .joint = Revolute{.axis = {0, 1, 0}}, .q = 0.0});
  model.add_force({.body = a, .point = {0, 0, -2}, .force = {5.0, 0.0, 2.0}});
  const Tree tree = compile(model);
  const State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  CHECK(workspace.pdot[0] == doctest::Approx(-10));
  accelerate(tree, state, workspace);
  CHECK(workspace.a[0] == doctest::Approx(-10 / 1.1));
  const Wrench R = reaction(tree, state, workspace, tree.inboard_joint({0}));
  CHECK(R.force.x == doctest::Approx(10 / 1.1 - 5));  // m·a of the centre of mass, less the force
  CHECK(R.force.z == doctest::Approx(-2));
}

TEST_CASE("a force acts through a locked joint on the joints that carry it; a removed body takes its force along") {
  Model model({.gravity = {}});
  const BodyId a = model.add({.name = "m/a", .mass = 1, .inertia = diagonal(1), .joint = Prismatic{.axis = {1, 0, 0}}});
  const BodyId b =
      model.add({.name = "m/b", .mass = 1, .inertia = diagonal(1), .parent = a, .joint = Prismatic{.axis = {1, 0, 0}}});
  model.add_force({.body = b, .force = {4.0, 0.0, 0.0}});
  Simulation sim(model);
  sim.apply(lock("m/b"));
  CHECK(sim.world().joint({b.index}).pdot[0] == 0);
  CHECK(sim.world().joint({a.index}).pdot[0] == doctest::Approx(4));
  CHECK(sim.world().joint_forces({b.index}).reaction.force.x == doctest::Approx(-2));
  sim.apply(unlock("m/b"));
  CHECK(sim.world().joint({b.index}).pdot[0] == doctest::Approx(4));
  sim.apply(break_joint("m/b"));
  CHECK(sim.world().tree().loads().bodies.size() == 1);
  CHECK(sim.world().joint({a.index}).pdot[0] == 0);
  CHECK(sim.world().joint({b.index}).pdot[0] == doctest::Approx(4));
  const SimulationSnapshot before = sim.snapshot();
  sim.remove(b);
  CHECK(sim.world().tree().loads().bodies.empty());
  CHECK(sim.run_until(0.1) == Status::ok);
  sim.restore(before);
  CHECK(sim.world().joint({b.index}).pdot[0] == doctest::Approx(4));
}

TEST_CASE("a body falls to its terminal speed as tanh; drag is dissipated, and the energy ledger closes") {
  for (const bool quadratic : {false, true}) {
    Model model({.gravity = {0, 0, -9.81}});
    const double m = 2, k = quadratic ? 0.4 : 0.9;
    const BodyId a = model.add(ball("m/a", m));
    BodyForce force{.body = a};
    if (quadratic)
      force.drag = {.quadratic = 0.8, .area = 0.5};
    else
      force.drag.linear = k;
    model.add_force(force);
    Simulation sim(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-13});
    const double terminal = quadratic ? std::sqrt(m * 9.81 / k) : m * 9.81 / k;
    for (const double t : {0.3, 1.0, 4.0}) {
      REQUIRE(sim.run_until(t) == Status::ok);
      const double v = quadratic ? terminal * std::tanh(9.81 * t / terminal) : terminal * (1 - std::exp(-k / m * t));
      CHECK(sim.world().motions()[0].linear.z == doctest::Approx(-v).epsilon(1e-10));
    }
    CHECK(sim.energy().dissipated > 50);
    CHECK(sim.energy().work == 0);
    CHECK(std::fabs(sim.energy().error) < 1e-8);
  }
}

TEST_CASE("forces that change with time: impulse and work") {
  Model model({.gravity = {}});
  const BodyId a = model.add(ball("m/a"));
  model.add_force({.body = a, .force = {Signal::table({{0, 0}, {1, 6}, {2, 0}}), Signal::sine(4, 0.5), 0.0}});
  Simulation sim(model, {.method = "rk4", .step = 0.01});
  REQUIRE(sim.run_until(1) == Status::ok);
  const Vec3 v = sim.world().motions()[0].linear;
  CHECK(v.x == doctest::Approx(1.5).epsilon(1e-12));                                 // 3 N s
  CHECK(v.y == doctest::Approx(4 / std::acos(-1.0)).epsilon(1e-8));                  // 8/π N s
  CHECK(sim.energy().work == doctest::Approx(v.x * v.x + v.y * v.y).epsilon(1e-9));  // m = 2 kg
  CHECK(std::fabs(sim.energy().error) < 1e-9);
}

TEST_CASE("errors in a force name the field") {
  Model model;
  const BodyId a = model.add(ball("m/a"));
  CHECK(error_of([&] { model.add_force({.body = {7}}); }).find("acts on no body of this model") != std::string::npos);
  CHECK(error_of([&] {
          model.add_force({.body = a, .force = {Signal(HUGE_VAL), 0.0, 0.0}});
        }).find("force: must be finite") != std::string::npos);
  CHECK(error_of([&] { model.add_force({.body = a, .drag = {.linear = -1}}); }).find("drag: 'linear' must not be negative") !=
        std::string::npos);
  CHECK(error_of([&] { model.add_force({.body = a, .point = {0, NAN, 0}}); }).find("point: must be finite") != std::string::npos);
}

TEST_CASE("a function of the world acts on a body as the same force given by numbers") {
  const auto model = [](bool told) {
    Model m({.gravity = {0, 0, -9.81}});
    const BodyId a = m.add({.name = "m/a",
                            .mass = 1,
                            .com = {0, 0, -0.5},
                            .inertia = diagonal(0.1),
                            .joint = Revolute{.axis = {0, 1, 0}},
                            .q = 0.4,
                            .child_at = Pose{{0.1, 0.2, 0.3}, from_rpy(0.3, 0.2, 0.1)}});
    m.add({.name = "m/b",
           .mass = 2,
           .com = {0.1, 0, 0},
           .inertia = diagonal(0.2),
           .parent = a,
           .at = {0, 0, -1},
           .joint = Ball{},
           .v = {1, 2, 3},
           .child_at = Pose{{0.1, -0.2, 0.3}, from_rpy(-0.3, 0.2, 0.1)}});
    if (told)
      m.add_force({.body = {1}, .force = {Signal::sine(2, 1), 1.0, 0.5}, .torque = {0.0, 0.1, 0.0}, .drag = {.linear = 0.4}});
    return m;
  };
  Simulation told(model(true)), asked(model(false));
  asked.force("m/b", [](const EvaluationContext& m) {
    const BodyMotion body = m.motion({1});
    return Wrench{Vec3{Signal::sine(2, 1).value(m.time()), 1, 0.5} - 0.4 * body.linear, {0, 0.1, 0}};
  });
  const auto same = [&] {
    for (std::size_t b = 0; b < 2; ++b) {
      CHECK(norm(told.world().motions()[b].pose.position - asked.world().motions()[b].pose.position) < 1e-11);
      CHECK(norm(told.world().motions()[b].angular - asked.world().motions()[b].angular) < 1e-10);
    }
    const EnergyBalance one = told.energy(), other = asked.energy();
    CHECK(one.work - one.dissipated == doctest::Approx(other.work - other.dissipated).epsilon(1e-9));
    CHECK(std::fabs(other.error) < 1e-6);
  };
  for (Simulation* s : {&told, &asked}) {
    s->at(0.5).then(break_joint("m/b"));
    REQUIRE(s->run_until(0.3) == Status::ok);
  }
  same();
  Simulation branch = asked.branch();
  REQUIRE(told.run_until(1) == Status::ok);
  REQUIRE(asked.run_until(1) == Status::ok);
  REQUIRE(branch.run_until(1) == Status::ok);
  same();
  CHECK(branch.world().motions()[1].pose.position == asked.world().motions()[1].pose.position);
  asked.force("m/b", {});
  CHECK(asked.world().tree().loads().bodies.empty());
  asked.remove({1});
  CHECK(error_of([&] {
          asked.force("m/b", [](const EvaluationContext&) { return Wrench{}; });
        }).find("is no longer in this world") != std::string::npos);
  CHECK(error_of([&] { asked.force("m/c", {}); }).find("there is no body 'm/c'") != std::string::npos);
}

TEST_CASE("forces on bodies moved by a prescribed motion: the drive's effort balances them") {
  Model model({.gravity = {}});
  const BodyId a =
      model.add({.name = "m/a",
                 .mass = 2,
                 .inertia = diagonal(1),
                 .joint = Prismatic{.axis = {1, 0, 0}, .drive = motion_drive(Signal::table({{0, 0}, {1, 3}, {2, 3}}))}});
  model.add({.name = "m/b", .mass = 1, .inertia = diagonal(1), .parent = a, .joint = Prismatic{.axis = {1, 0, 0}}});
  model.add_force({.body = {1}, .force = {5.0, 0.0, 0.0}, .drag = {.linear = 0.3}});
  model.add_force({.body = a, .force = {-4.0, 0.0, 0.0}});
  Simulation sim(model);
  REQUIRE(sim.run_until(0.4) == Status::ok);
  const JointForces forces = sim.world().joint_forces({a.index});
  const double b = 5 - 0.3 * sim.world().motions()[1].linear.x;  // on the free slider, which transmits no force
  CHECK(sim.world().accelerations()[1].linear.x == doctest::Approx(b));
  CHECK(forces.effort[0] == doctest::Approx(2 * forces.a[0] + 4));
  CHECK(std::fabs(sim.energy().error) < 1e-7);
  CHECK(sim.energy().dissipated > 0.1);
}
