// Exact couplings in a world: stops, prescribed motions, snapshots, branches and undo.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>

namespace momentree {
namespace {

// Two fingers, the second of which moves opposite to the first; a motor closes the first.
BodySpec finger(const char* name, double mass) {
  BodySpec spec;
  spec.name = name, spec.mass = mass, spec.inertia = diagonal(1e-3);
  spec.joint = JointSpec(Prismatic{{1, 0, 0}});
  return spec;
}
Model gripper(bool stop = false, bool driven = false) {
  Model model;
  BodySpec one = finger("hand/one", 0.2), other = finger("hand/other", 0.3);
  one.joint.parameters.effort = {2};
  if (driven) {
    one.joint.parameters.effort = {};
    one.joint.parameters.drive = motion_drive(Signal::sine(0.1, 1, 0, 0));
  }
  if (stop) other.joint.parameters.limits.lower = {-0.05}, other.joint.parameters.limits.restitution = {0};
  model.add(one), model.add(other);
  model.add_coupling({.joint = {1}, .follows = {0}, .multiplier = -1});
  return model;
}

std::vector<double> bits(const World& world) {
  std::vector<double> all{world.time()};
  all.insert(all.end(), world.state().q().begin(), world.state().q().end());
  all.insert(all.end(), world.state().y().begin(), world.state().y().end());
  all.push_back(world.coupling({0}).ended ? 1 : 0);
  all.push_back(world.coupling({0}).effort);
  return all;
}

}  // namespace

TEST_CASE("a stop of one joint of a coupling holds both, and its force passes through the coupling") {
  Simulation sim(gripper(true), {.method = "rk4", .step = 1e-3});
  REQUIRE(sim.run_until(1) == Status::ok);
  const World& world = sim.world();
  CHECK(world.joint({0}).q[0] == doctest::Approx(0.05).epsilon(1e-9));
  CHECK(world.joint({1}).q[0] == doctest::Approx(-0.05).epsilon(1e-9));
  CHECK(world.joint({1}).resting == 1);
  CHECK(world.coupling({0}).effort == doctest::Approx(-2));  // the motor's force on the other finger
  const double speed = std::sqrt(2 * 2 * 0.05 / 0.5);        // of both, before the impact
  double lost = 0;
  for (const Event& event : sim.events()) lost += event.lost;
  CHECK(lost == doctest::Approx(0.5 * 0.5 * speed * speed).epsilon(1e-6));
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  JointParameters opening;
  opening.effort = {-1};
  sim.apply(set_parameters("hand/one", opening));  // the motor opens the hand: the stop would have to pull
  REQUIRE(sim.run_until(1.1) == Status::ok);
  CHECK(world.joint({1}).resting == 0);
  CHECK(world.joint({0}).v[0] == doctest::Approx(-0.1 / 0.5).epsilon(1e-6));
}

TEST_CASE("a prescribed motion drives what is coupled, and its effort moves both") {
  for (const Variables variables : {Variables::velocities, Variables::momenta}) {
    Simulation sim(gripper(false, true), {.method = "dop853", .variables = variables, .rtol = 1e-10, .atol = 1e-12});
    REQUIRE(sim.run_until(0.3) == Status::ok);
    const World& world = sim.world();
    const double w = 2 * std::acos(-1.0), s = 0.1 * std::sin(w * 0.3);
    CHECK(world.joint({1}).q[0] == doctest::Approx(-s).epsilon(1e-9));
    CHECK(world.coupling({0}).effort == doctest::Approx(0.3 * w * w * s).epsilon(1e-7));
    double tau[2];
    world.equations().efforts(tau);
    CHECK(tau[0] == doctest::Approx(-0.5 * w * w * s).epsilon(1e-7));  // of the motion alone
    CHECK(std::fabs(sim.energy().error) < 1e-8);
  }
}

// m ẍ = F − c ẋ of both fingers together, and the rates of the momenta of each alone, which contain the coupling's force.
TEST_CASE("couplings in momenta: a closed form, and rates of momenta in either variables") {
  Model model = gripper();
  BodySpec damped = finger("hand/damped", 0.3);
  damped.joint.parameters.damping = {4};
  model.add(damped);
  model.add_coupling({.joint = {2}, .follows = {0}, .multiplier = 0.5});
  const double mass = 0.2 + 0.3 + 0.25 * 0.3, rate = 0.25 * 4 / mass, end = 2 / (0.25 * 4);
  struct Way {
    const char* method;
    Variables variables;
    double tolerance;
  };
  for (const auto& [method, variables, tolerance] :
       {Way{"dop853", Variables::velocities, 1e-9}, Way{"dop853", Variables::momenta, 1e-9}, Way{"rk4", Variables::momenta, 1e-9},
        Way{"midpoint", Variables::momenta, 1e-5}, Way{"damped", Variables::momenta, 1e-7}}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method, .variables = variables, .step = 1e-3, .rtol = 1e-11, .atol = 1e-13});
    REQUIRE(sim.run_until(0.5) == Status::ok);
    const World& world = sim.world();
    const double v = end * (1 - std::exp(-rate * 0.5)), a = end * rate * std::exp(-rate * 0.5);
    CHECK(world.state().variables() == variables);
    CHECK(world.joint({0}).v[0] == doctest::Approx(v).epsilon(tolerance));
    CHECK(world.coupling({0}).effort == doctest::Approx(-0.3 * a).epsilon(tolerance));
    const double share[] = {1, -1, 0.5}, masses[] = {0.2, 0.3, 0.3};
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(world.p()[i] == doctest::Approx(masses[i] * share[i] * v).epsilon(tolerance));
      CHECK(world.pdot()[i] == doctest::Approx(masses[i] * share[i] * a).epsilon(tolerance));
    }
    CHECK(std::fabs(sim.energy().error) < 10 * tolerance);
  }
}

TEST_CASE("undo, branches and snapshots of worlds with couplings are exact") {
  for (const auto& [method, variables] : {std::pair{"rk4", Variables::velocities}, std::pair{"midpoint", Variables::velocities},
                                          std::pair{"dopri5", Variables::velocities}, std::pair{"dop853", Variables::velocities},
                                          std::pair{"rk4", Variables::momenta}, std::pair{"midpoint", Variables::momenta},
                                          std::pair{"dop853", Variables::momenta}, std::pair{"damped", Variables::momenta}})
    for (const Action& change : {break_joint("hand/other"), lock("hand/one"), free_joint("hand/one"), lock("hand/other")}) {
      CAPTURE(method);
      CAPTURE(change.text());
      Simulation sim(gripper(), {.method = method, .variables = variables});
      sim.keep_history();
      REQUIRE(sim.run_until(0.05) == Status::ok);
      const std::vector<double> before = bits(sim.world());
      const SimulationSnapshot snapshot = sim.snapshot();
      sim.apply(change, "change");
      REQUIRE(sim.run_until(0.1) == Status::ok);
      const std::vector<double> after = bits(sim.world());
      Simulation branch = sim.branch();
      REQUIRE(branch.run_until(0.15) == Status::ok);
      REQUIRE(sim.run_until(0.15) == Status::ok);
      CHECK(bits(branch.world()) == bits(sim.world()));
      sim.undo(0);
      CHECK(bits(sim.world()) == before);
      sim.restore(snapshot);
      CHECK(bits(sim.world()) == before);
      sim.apply(change, "change");
      REQUIRE(sim.run_until(0.1) == Status::ok);
      CHECK(bits(sim.world()) == after);
    }
}

TEST_CASE("a joint that follows a prescribed motion can't be stopped by its limits, which is an error before it is hit") {
  const char* const why = "joint 'hand/other' follows the prescribed motion of 'hand/one', so that its limits can't stop it";
  const auto problem = [](auto act) {
    try {
      act();
    } catch (const Error& error) {
      return error.problem;
    }
    return std::string();
  };
  CHECK(problem([] { static_cast<void>(gripper(true, true)); }).find(why) != std::string::npos);
  // By an action: the motion, or the limits.
  Simulation still(gripper(true), {.method = "rk4", .step = 1e-3}), moving(gripper(false, true), {.method = "rk4", .step = 1e-3});
  JointParameters motion, stops;
  motion.drive = motion_drive(Signal::sine(0.1, 1, 0, 0));
  CHECK(problem([&] { still.apply(set_parameters("hand/one", motion)); }).find(why) != std::string::npos);
  stops.limits.lower = {-0.05};
  CHECK(problem([&] { moving.apply(set_parameters("hand/other", stops)); }).find(why) != std::string::npos);
  // Soft stops only push, and chains of couplings pass motions on.
  stops.limits.stiffness = {1e3};
  moving.apply(set_parameters("hand/other", stops));
  REQUIRE(moving.run_until(0.3));
  CHECK(moving.world().joint({1}).q[0] == doctest::Approx(-0.1 * std::sin(2 * std::numbers::pi * 0.3)).epsilon(1e-6));
  Model chain = gripper(false, true);
  BodySpec last = finger("hand/last", 0.3);
  last.joint.parameters.limits.upper = {0.05};
  chain.add(last);
  CHECK(problem([&] { chain.add_coupling({.joint = {2}, .follows = {1}}); }).find("'hand/last' follows the") !=
        std::string::npos);
}

TEST_CASE("mistakes in couplings are errors") {
  const auto refused = [](const Coupling& coupling, const char* what) {
    Model model = gripper();
    BodySpec ball = finger("hand/ball", 1);
    ball.joint = JointSpec(Ball{});
    model.add(ball);
    try {
      model.add_coupling(coupling);
      FAIL_CHECK(what);
    } catch (const Error& error) {
      CHECK_MESSAGE(std::string(error.what()).find(what) != std::string::npos, error.what());
    }
  };
  refused({.joint = {7}, .follows = {0}}, "is not a joint of this model");
  refused({.joint = {first_loop}, .follows = {0}}, "closes a loop");
  refused({.joint = {2}, .follows = {0}}, "does not have one degree of freedom");
  refused({.joint = {0}, .follows = {0}}, "follow itself");
  refused({.joint = {0}, .follows = {1}, .multiplier = NAN}, "must be finite");
  Model contradiction = gripper();
  contradiction.add_coupling({.joint = {1}, .follows = {0}, .multiplier = -1, .offset = 1});
  CHECK_THROWS_AS(Simulation{contradiction}, Error);
}

}  // namespace momentree
