#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

// A body that rotates about z with an inertia of 1 kg m², nothing else.
Model rotor(Revolute joint, double q = 0, double v = 0) {
  Model model({.gravity = {}});
  joint.axis = z_axis;
  model.add({.name = "rotor", .mass = 1, .inertia = diagonal(1), .joint = joint, .q = q, .v = v});
  return model;
}

Integration exactly() { return {.method = "dopri5", .step = 1e-3, .rtol = 1e-12, .atol = 1e-13}; }

double scale(const Simulation& sim) {
  const EnergyBalance e = sim.energy();
  return std::max({std::fabs(e.initial), std::fabs(e.final), std::fabs(e.dissipated), std::fabs(e.work), 1e-3});
}

// A double pendulum with the given joint of the second arm.
Model arms(const Revolute& second) {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId one = model.add({.name = "one",
                                .mass = 2,
                                .com = {0, 0, -0.5},
                                .inertia = diagonal(0.2, 0.2, 0.05),
                                .joint = Revolute{.axis = y_axis, .damping = 0.1},
                                .q = 0.4,
                                .v = -0.3});
  model.add({.name = "two",
             .mass = 1,
             .com = {0, 0.1, -0.4},
             .inertia = diagonal(0.1, 0.1, 0.02),
             .parent = one,
             .at = {0, 0, -1},
             .joint = second,
             .q = 0.2,
             .v = 0.5});
  return model;
}

}  // namespace

TEST_CASE("friction stops a rotor as in the closed form: sinh(u/s) decays") {
  const double coulomb = 0.5, speed = 0.1, u0 = 2;
  Simulation sim(rotor({.friction = {coulomb, speed}}, 0, u0), exactly());
  for (const double t : {1.0, 3.9, 4.0, 4.1, 5.0}) {
    REQUIRE(sim.run_until(t) == Status::ok);
    const double u = speed * std::asinh(std::sinh(u0 / speed) * std::exp(-coulomb * t / speed));
    CHECK(sim.world().joint({0}).v[0] == doctest::Approx(u).epsilon(1e-8));
  }
  CHECK(sim.energy().dissipated == doctest::Approx(2).epsilon(1e-6));
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
}

TEST_CASE("position control is bounded by its largest effort, then a damped oscillator") {
  const double kp = 4, kd = 1, most = 2, target = 10;
  Simulation sim(rotor({.drive = pd_drive({.kp = kp, .kd = kd, .target = {target}, .max_effort = most})}), exactly());
  REQUIRE(sim.run_until(2.5) == Status::ok);
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(0.5 * most * 2.5 * 2.5).epsilon(1e-11));
  CHECK(sim.world().joint_forces({0}).effort[0] == doctest::Approx(most).epsilon(1e-14));
  // kp (target − t²) − kd 2t = most ends the first phase; then e″ + kd e′ + kp e = 0 while the required effort does not exceed
  // most.
  const double start = (-kd * most + std::sqrt(kd * kd * most * most + 2 * kp * most * (kp * target - most))) / (kp * most);
  const double e0 = 0.5 * most * start * start - target, v0 = most * start;
  const double delta = kd / 2, omega = std::sqrt(kp - delta * delta);
  const auto e = [&](double t) {
    return std::exp(-delta * t) * (e0 * std::cos(omega * t) + (v0 + delta * e0) / omega * std::sin(omega * t));
  };
  const auto effort = [&](double t) {
    const double h = 1e-6;
    return -kp * e(t) - kd * (e(t + h) - e(t - h)) / (2 * h);
  };
  double lasts = 0;
  while (lasts < 0.3 && std::fabs(effort(lasts + 0.01)) < most) lasts += 0.01;
  REQUIRE(lasts > 0.1);
  REQUIRE(sim.run_until(start + 0.9 * lasts) == Status::ok);
  CHECK(sim.world().joint({0}).q[0] - target == doctest::Approx(e(0.9 * lasts)).epsilon(1e-9));
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
}

TEST_CASE("position control follows the rate of its target unless another is set") {
  const Signal ramp = Signal::table({{0, 0}, {2, 6}});
  Simulation one(rotor({.drive = pd_drive({.kd = 5, .target = {ramp}})}), exactly());
  Simulation other(rotor({.drive = pd_drive({.kd = 5, .target_speed = {Signal(3)}})}), exactly());
  for (Simulation* sim : {&one, &other}) {
    REQUIRE(sim->run_until(1.5) == Status::ok);
    CHECK(sim->world().joint({0}).v[0] == doctest::Approx(3 * (1 - std::exp(-5 * 1.5))).epsilon(1e-10));
  }
  REQUIRE(one.run_until(3) == Status::ok);  // the ramp ended at 2 s
  CHECK(one.world().joint({0}).v[0] == doctest::Approx(3 * (1 - std::exp(-10.0)) * std::exp(-5.0)).epsilon(1e-9));
  CHECK(std::fabs(one.energy().error) <= 1e-9 * scale(one));
}

TEST_CASE("a soft stop throws a mass back as a damped oscillator does, and never pulls") {
  const double k = 400, v0 = 1.5;
  for (const double c : {0.0, 2.0, 12.0}) {
    Model model({.gravity = {}});
    const Prismatic slider{.axis = x_axis, .limits = {.lower = -0.2, .upper = 0.1, .stiffness = k, .damping = c}};
    model.add({.name = "mass", .mass = 1, .joint = slider, .v = v0});
    Simulation sim(model, {.method = "dopri5", .step = 1e-4, .rtol = 1e-12, .atol = 1e-13, .max_step = 1e-3});
    const double delta = c / 2, omega = std::sqrt(k - delta * delta);
    // It is released when k x + c ẋ = 0.
    const double lasts = (std::numbers::pi - std::atan2(c * omega, k - c * delta)) / omega;
    const double leaves = v0 * std::exp(-delta * lasts) * (std::cos(omega * lasts) - delta / omega * std::sin(omega * lasts));
    REQUIRE(sim.run_until(0.1 / v0 + 0.5 * lasts) == Status::ok);
    const double x = v0 / omega * std::exp(-delta * 0.5 * lasts) * std::sin(0.5 * omega * lasts);
    CHECK(sim.world().joint({0}).q[0] - 0.1 == doctest::Approx(x).epsilon(1e-8));
    CHECK(sim.world().totals().potential == doctest::Approx(0.5 * k * x * x).epsilon(1e-8));
    REQUIRE(sim.run_until(0.1 / v0 + lasts + 0.05) == Status::ok);
    CHECK(sim.world().joint({0}).v[0] == doctest::Approx(leaves).epsilon(1e-7));
    CHECK(sim.energy().dissipated == doctest::Approx(0.5 * (v0 * v0 - leaves * leaves)).epsilon(1e-6));
    CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
    CHECK(sim.events().empty());
    REQUIRE(sim.run_until(2) == Status::ok);  // to the other side and back
    CHECK(sim.world().joint({0}).q[0] > -0.3);
    CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
  }
}

TEST_CASE("time-dependent efforts keep the order of every method") {
  const Model model = arms({.axis = x_axis, .drive = effort_drive({Signal::sine(2, 1.3, 0.4, 0.5)})});
  const Tree tree(model);
  const auto end = [&](const char* method, int steps) {
    State state = start_state(model, tree);
    Workspace<double> work(tree);
    Evaluator evaluate(tree, work);
    EnergyLedger ledger;
    const auto integrator = make_integrator(method, tree, {.step = 1.0 / steps});
    for (int k = 0; k < steps; ++k) {
      evaluate(state);
      REQUIRE(integrator->step(evaluate, state, ledger, 1.0 / steps));
    }
    return state.q()[1];
  };
  const double exact = end("dop853", 800);
  struct Case {
    const char* method;
    int steps;
    double order;
  };
  for (const Case& c : {Case{"rk4", 100, 4}, {"dopri5", 40, 5}, {"dop853", 12, 8}, {"midpoint", 200, 2}}) {
    const double coarse = std::fabs(end(c.method, c.steps) - exact), fine = std::fabs(end(c.method, 2 * c.steps) - exact);
    CHECK_MESSAGE(std::log2(coarse / fine) > c.order - 0.4, c.method, ": ", std::log2(coarse / fine));
  }
}

TEST_CASE("steps end on the bends of tables, and methods keep their order across them") {
  const Signal zigzag = Signal::table({{0.1234, 0}, {0.3371, 3}, {0.5003, -2}, {0.7777, 1}});
  for (const bool controlled : {false, true}) {  // a target's rate jumps at a bend
    const auto drive = controlled ? pd_drive({.kp = 6, .kd = 2, .target = {zigzag}}) : effort_drive({zigzag});
    const Model model = arms({.axis = x_axis, .drive = drive});
    const auto end = [&](double step) {
      Simulation sim(model, {.method = "rk4", .step = step});
      REQUIRE(sim.run_until(1) == Status::ok);
      return sim.world().joint({1}).q[0];
    };
    Simulation fine(model, {.method = "dop853", .step = 1e-3, .rtol = 1e-13, .atol = 1e-14});
    std::vector<double> times;
    fine.observe(0, [&](const World& w) {
      times.push_back(w.time());
      return true;
    });
    REQUIRE(fine.run_until(1) == Status::ok);
    for (const Signal::Knot& k : zigzag.knots()) CHECK(std::find(times.begin(), times.end(), k.time) != times.end());
    CHECK(fine.statistics().steps < 200);
    CHECK(std::fabs(fine.energy().error) <= 1e-9 * scale(fine));
    const double exact = fine.world().joint({1}).q[0];
    const double coarse = std::fabs(end(0.01) - exact), half = std::fabs(end(0.005) - exact);
    CHECK_MESSAGE(std::log2(coarse / half) > 3.5, std::log2(coarse / half));
  }
}

TEST_CASE("a drive function gives the same motion as a signal, reads the world, and ends with the joint") {
  Simulation told(arms({.axis = x_axis, .drive = effort_drive({Signal::sine(2, 1.3)})}), {.step = 1e-2});
  Simulation asked(arms({.axis = x_axis}), {.step = 1e-2});
  int calls = 0;
  asked.drive("two", [&](const EvaluationContext& m) {
    ++calls;
    CHECK(m.q({1}).size() == 1);
    return Signal::sine(2, 1.3).value(m.time());
  });
  REQUIRE(told.run_until(0.5) == Status::ok);
  REQUIRE(asked.run_until(0.5) == Status::ok);
  CHECK(calls >= 200);
  // If a function may read body motions, other kernels evaluate the stages, and they round differently.
  CHECK(std::fabs(told.world().joint({1}).q[0] - asked.world().joint({1}).q[0]) < 1e-13);
  CHECK(std::fabs(told.energy().work - asked.energy().work) < 1e-13);

  // The evaluation context and the world must agree about body motions.
  BodyMotion seen;
  asked.drive("two", [&](const EvaluationContext& m) {
    seen = m.motion({1});
    return 3 * m.v({0})[0];
  });
  const BodyMotion is = asked.world().motions()[1];
  const double a = asked.world().joint_forces({1}).effort[0];
  CHECK(norm(seen.pose.position - is.pose.position) < 1e-14);
  CHECK(norm(seen.linear - is.linear) < 1e-14);
  CHECK(norm(seen.angular - is.angular) < 1e-14);
  CHECK(a == 3 * asked.world().joint({0}).v[0]);

  // Snapshots and branches keep the function; a joint that broke has none, and restoring brings it back.
  const SimulationSnapshot before = asked.snapshot();
  Simulation other = asked.branch();
  REQUIRE(other.run_until(0.6) == Status::ok);
  REQUIRE(asked.run_until(0.6) == Status::ok);
  CHECK(other.world().joint({1}).q[0] == asked.world().joint({1}).q[0]);
  asked.apply(break_joint("two"));
  seen = {};
  REQUIRE(asked.run_until(0.7) == Status::ok);
  CHECK(seen.pose.position.z == 0);
  asked.restore(before);
  REQUIRE(asked.run_until(0.6) == Status::ok);
  CHECK(other.world().joint({1}).q[0] == asked.world().joint({1}).q[0]);
  asked.drive("two", {});
  CHECK(asked.world().joint_forces({1}).effort[0] == 0);
  CHECK_THROWS_AS(asked.drive("three", {}), Error);
}

TEST_CASE("new drives, friction, stops and strengths at run time") {
  Simulation sim(rotor({.effort = 3}), exactly());
  JointParameters with;
  with.drive = pd_drive({.kd = 2, .target_speed = {Signal(1)}});
  sim.apply(set_parameters("rotor", with));
  CHECK(sim.world().joint_forces({0}).effort[0] == 2);  // the previous effort is removed
  with = {};
  with.effort = 5;
  sim.apply(set_parameters("rotor", with));
  CHECK(sim.world().joint_forces({0}).effort[0] == 5);
  with = {};
  with.friction = {0.5, 0.1};
  with.limits = {.lower = -1, .upper = -0.5, .stiffness = 100};
  const Event& event = sim.apply(set_parameters("rotor", with));
  CHECK(event.work == doctest::Approx(0.5 * 100 * 0.25));
  CHECK(sim.world().joint_forces({0}).effort[0] == doctest::Approx(5 - 50));
  REQUIRE(sim.run_until(1) == Status::ok);
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
  const double stored = sim.world().totals().potential;
  const Event& broken = sim.apply(break_joint("rotor"));
  CHECK(broken.released == doctest::Approx(stored));
  CHECK(sim.world().totals().potential == 0);
}

TEST_CASE("drive applies to all of several joints, or to none if one cannot have it") {
  Simulation together(arms({.axis = y_axis}), exactly()), apart(arms({.axis = y_axis}), exactly());
  const auto effort = [](double of) { return [of](const EvaluationContext&, std::span<double> efforts) { efforts[0] = of; }; };
  const double before[] = {together.world().joint({0}).pdot[0], together.world().joint({1}).pdot[0]};
  CHECK_THROWS_AS(together.drive_all({{"one", effort(3)}, {"none", effort(1)}}), Error);
  for (int j = 0; j < 2; ++j) CHECK(together.world().joint({j}).pdot[0] == before[j]);
  together.drive_all({{"one", effort(3)}, {"two", effort(-2)}});
  apart.drive_all("one", effort(3));
  apart.drive_all("two", effort(-2));
  CHECK(together.world().joint({0}).pdot[0] == doctest::Approx(before[0] + 3).epsilon(1e-14));
  CHECK(together.world().joint({1}).pdot[0] == doctest::Approx(before[1] - 2).epsilon(1e-14));
  for (Simulation* sim : {&together, &apart}) REQUIRE(sim->run_until(0.5) == Status::ok);
  for (int j = 0; j < 2; ++j) CHECK(together.world().joint({j}).q[0] == apart.world().joint({j}).q[0]);
}
