// Functions that drive joints which close loops.
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>

namespace momentree {
namespace {

constexpr double stiffness = 40, rest = 1.3, damping = 3;

/// A boom that hangs on a cylinder between two pins. `law`: a spring and a damper in the cylinder.
Model crane(bool law, JointParameters more = {}) {
  Model model;
  const auto part = [&](const char* name, BodyId parent, Vec3 at, double com, double q) {
    return model.add({.name = name,
                      .mass = 10,
                      .com = {com, 0, 0},
                      .inertia = diagonal(0.1, 1, 1),
                      .parent = parent,
                      .at = Pose{at, Quat{}},
                      .joint = Revolute{.axis = {0, -1, 0}},
                      .q = q});
  };
  const BodyId boom = part("crane/boom", ground, {}, 1, 0.35), barrel = part("crane/barrel", ground, {0, 0, -0.8}, 0.3, 0.9);
  const BodyId rod = part("crane/rod", boom, {1, 0, 0}, -0.3, 0.5);
  LoopSpec cylinder{.name = "cylinder", .body = rod, .to = barrel};
  cylinder.joint = Prismatic{.axis = x_axis};
  cylinder.joint.parameters = std::move(more);
  if (law)
    cylinder.joint.parameters.stiffness = {stiffness}, cylinder.joint.parameters.rest = {rest},
    cylinder.joint.parameters.damping = {damping};
  model.add_loop(cylinder);
  return model;
}

constexpr JointId cylinder_id{first_loop};

double spring_and_damper(const EvaluationContext& now) {
  return stiffness * (rest - now.q(cylinder_id)[0]) - damping * now.v(cylinder_id)[0];
}

std::vector<double> bits(const World& world) {
  std::vector<double> all{world.time()};
  all.insert(all.end(), world.state().q().begin(), world.state().q().end());
  all.insert(all.end(), world.state().y().begin(), world.state().y().end());
  return all;
}

void go(Simulation& sim, double until) { REQUIRE(sim.run_until(until) == Status::ok); }

void check_same(const World& one, const World& other, double tolerance) {
  for (std::size_t i = 0; i < one.v().size(); ++i) {
    CHECK(one.state().q()[i] == doctest::Approx(other.state().q()[i]).epsilon(tolerance));
    CHECK(one.v()[i] == doctest::Approx(other.v()[i]).epsilon(tolerance));
    CHECK(one.a()[i] == doctest::Approx(other.a()[i]).epsilon(tolerance));
  }
}

const std::vector<std::pair<const char*, Variables>> ways{{"rk4", Variables::velocities},   {"rk4", Variables::momenta},
                                                          {"midpoint", Variables::momenta}, {"dop853", Variables::velocities},
                                                          {"dop853", Variables::momenta},   {"damped", Variables::momenta}};

}  // namespace

TEST_CASE("a function in a loop joint acts as the spring and the damper that it computes, and its work is booked") {
  for (const auto& [method, variables] : ways) {
    CAPTURE(method);
    const Integration how{.method = method, .variables = variables, .step = 1e-3, .rtol = 1e-11, .atol = 1e-13};
    Simulation by_law(crane(true), how), by_function(crane(false), how);
    by_function.drive("cylinder", spring_and_damper);
    check_same(by_law.world(), by_function.world(), 1e-10);
    go(by_law, 0.6), go(by_function, 0.6);
    check_same(by_law.world(), by_function.world(), 1e-9);
    const JointForces one = by_law.world().joint_forces(cylinder_id), other = by_function.world().joint_forces(cylinder_id);
    CHECK(one.effort[0] == doctest::Approx(other.effort[0]).epsilon(1e-9));
    CHECK(norm(one.reaction.force - other.reaction.force) < 1e-8 * (1 + norm(one.reaction.force)));
    CHECK(norm(one.bearing.force - other.bearing.force) < 1e-8 * (1 + norm(one.bearing.force)));
    const EnergyBalance law = by_law.energy(), function = by_function.energy();
    const auto stored = [](const Simulation& sim) {
      const double l = sim.world().joint(cylinder_id).q[0];
      return 0.5 * stiffness * (l - rest) * (l - rest);
    };
    Simulation start(crane(true));
    const double work = stored(start) - stored(by_law) - law.dissipated;
    const double tolerance = std::string(method) == "midpoint" || std::string(method) == "damped" ? 1e-4 : 1e-8;
    CHECK(function.work == doctest::Approx(work).epsilon(tolerance));
    CHECK(function.dissipated == doctest::Approx(0));
    CHECK(std::fabs(function.error) < 20 * tolerance);
  }
}

TEST_CASE("a function gives one effort per degree of freedom of a loop joint, beside armatures and locks") {
  const auto pendulum = [](const JointParameters& parameters) {  // a rod on the ground at one end, and at the other by the loop
    Model model;
    model.add({.name = "arm",
               .mass = 1,
               .com = {0.3, 0, 0},
               .inertia = diagonal(0.01, 0.05, 0.06),
               .joint = Ball{},
               .v = {0.3, -0.4, 0.2}});
    model.add({.name = "rod",
               .mass = 2,
               .com = {0.2, 0, 0},
               .inertia = diagonal(0.02, 0.06, 0.07),
               .parent = {0},
               .at = {0.6, 0, 0},
               .joint = Ball{}});
    model.add({.name = "foot",
               .mass = 1.5,
               .com = {0, 0.1, 0.2},
               .inertia = diagonal(0.03, 0.04, 0.05),
               .at = {1, 0, 0},
               .joint = Ball{}});
    LoopSpec loop{.name = "hinge", .body = {1}, .to = {2}};
    loop.joint = Universal{.axis = x_axis, .axis2 = y_axis};
    loop.joint.parameters = parameters;
    loop.at.position = {0, 0, 0.2}, loop.child_at.position = {0.5, 0, 0};
    model.add_loop(loop);
    return model;
  };
  for (const auto& [method, variables] : ways) {
    CAPTURE(method);
    const Integration how{.method = method, .variables = variables, .step = 1e-3, .rtol = 1e-11, .atol = 1e-13};
    JointParameters given, rotor;
    given.effort = {0.7, -0.4}, given.armature = {0.05, 0.02}, rotor.armature = {0.05, 0.02};
    Simulation by_law(pendulum(given), how), by_function(pendulum(rotor), how);
    by_function.drive_all("hinge", [](const EvaluationContext&, std::span<double> efforts) {
      REQUIRE(efforts.size() == 2);
      CHECK(efforts[0] == 0);
      efforts[0] = 0.7, efforts[1] = -0.4;
    });
    go(by_law, 0.2), go(by_function, 0.2);
    check_same(by_law.world(), by_function.world(), 1e-9);
    CHECK(by_law.energy().work == doctest::Approx(by_function.energy().work).epsilon(1e-9));
    for (Simulation* sim : {&by_law, &by_function}) sim->apply(lock("hinge", {1}), "jam");  // its effort then does nothing
    go(by_law, 0.3), go(by_function, 0.3);
    check_same(by_law.world(), by_function.world(), 1e-8);
    CHECK_THROWS_AS(by_function.drive("hinge", [](const EvaluationContext&) { return 0.0; }), Error);
    by_function.drive_all("hinge", nullptr);
    CHECK(by_function.world().joint_forces(cylinder_id).effort[0] == 0);
    JointParameters off = rotor;
    off.effort = {0.0, 0.0};
    by_law.apply(set_parameters("hinge", off), "off");
    go(by_law, 0.35), go(by_function, 0.35);
    check_same(by_law.world(), by_function.world(), 1e-8);
  }
}

TEST_CASE("functions in loop joints stay in snapshots, branches and undo, and when the joint becomes one of the tree") {
  for (const auto& [method, variables] : ways) {
    CAPTURE(method);
    Simulation sim(crane(false), {.method = method, .variables = variables});
    sim.keep_history();
    int calls = 0;
    const auto counted = std::make_shared<int*>(&calls);
    sim.drive("cylinder", [counted](const EvaluationContext& now) {
      if (*counted != nullptr) ++**counted;
      const Numbers q = now.q(cylinder_id);  // none once the joint is one of the tree
      return q.size() == 0 ? 25.0 : 25 + stiffness * (rest - q[0]);
    });
    go(sim, 0.05);
    CHECK(calls > 20);
    CHECK(has_functions(sim.world().tree()));
    const std::vector<double> before = bits(sim.world());
    const SimulationSnapshot snapshot = sim.snapshot();
    sim.apply(break_joint("crane/barrel"), "cut");  // the cylinder holds the barrel
    CHECK(sim.world().loops().empty());
    const JointId now{sim.world().find_joint("cylinder")};
    REQUIRE_FALSE(is_loop(now));
    CHECK(sim.world().joint_forces(now).effort[0] == doctest::Approx(25));
    go(sim, 0.1);
    const std::vector<double> after = bits(sim.world());
    Simulation branch = sim.branch();
    go(branch, 0.12), go(sim, 0.12);
    CHECK(bits(branch.world()) == bits(sim.world()));
    sim.undo(0);
    CHECK(bits(sim.world()) == before);
    sim.apply(break_joint("crane/barrel"), "cut");
    go(sim, 0.1);
    CHECK(bits(sim.world()) == after);
    sim.restore(snapshot);
    CHECK(bits(sim.world()) == before);
    sim.apply(lock("cylinder"), "hold");
    CHECK(sim.world().joint_forces(cylinder_id).effort.size() == 1);
    sim.apply(unlock("cylinder"), "release");
    CHECK(sim.world().joint_forces(cylinder_id).effort[0] ==
          doctest::Approx(25 + stiffness * (rest - sim.world().joint(cylinder_id).q[0])));
    sim.apply(break_joint("cylinder"), "end");
    calls = 0;
    go(sim, 0.11);
    CHECK(calls == 0);
    CHECK_FALSE(has_functions(sim.world().tree()));
    *counted = nullptr;
  }
}

TEST_CASE("a start anew keeps each function at the joint of its name") {
  const auto push = [](const EvaluationContext& now) {
    const Numbers q = now.q(cylinder_id);  // empty while it is a joint of the tree
    return q.size() == 0 ? 25.0 : 25 + stiffness * (rest - q[0]);
  };
  for (const bool both : {false, true}) {
    Simulation sim(crane(false), {.method = "rk4"});
    sim.drive("cylinder", push);
    if (both) sim.drive("crane/barrel", [](const EvaluationContext&) { return 7.0; });
    sim.apply(break_joint("crane/barrel"), "cut");  // the cylinder takes its place, and its number
    REQUIRE_FALSE(is_loop({sim.world().find_joint("cylinder")}));
    sim.restore(0, {}, {});
    const Tree& tree = sim.world().tree();
    REQUIRE(tree.function(tree.loops().find(cylinder_id)->joint) != nullptr);
    CHECK(tree.function(1) == nullptr);  // that of the barrel ended with its joint
    Simulation other(crane(false), {.method = "rk4"});
    other.drive("cylinder", push);
    go(sim, 0.1), go(other, 0.1);
    CHECK(bits(sim.world()) == bits(other.world()));
  }
}

TEST_CASE("any function reads the coordinates of loop joints at the stage, and a prescribed motion takes no function") {
  Simulation sim(crane(false), {.method = "rk4"});
  double worst = 0;
  sim.drive("crane/boom", [&worst](const EvaluationContext& now) {
    CHECK(now.has_function({0}));
    CHECK_FALSE(now.has_function(cylinder_id));
    const Vec3 pin = now.motion({0}).pose.position + Vec3{std::cos(now.q({0})[0]), 0, std::sin(now.q({0})[0])};
    const double dx = pin.x, dz = pin.z + 0.8, length = std::sqrt(dx * dx + dz * dz);
    const double rate = (-dx * std::sin(now.q({0})[0]) + dz * std::cos(now.q({0})[0])) / length * now.v({0})[0];
    worst = std::max(worst, std::fabs(now.q(cylinder_id)[0] - length) + std::fabs(now.v(cylinder_id)[0] - rate));
    return 0.0;
  });
  go(sim, 0.2);
  CHECK(worst > 0);
  CHECK(worst < 1e-6);  // at stages, the loop is closed to the order of the method
  JointParameters moved;
  moved.drive = motion_drive(Signal::ramp_from_here(0.1));
  sim.apply(set_parameters("cylinder", moved), "moved");
  CHECK_THROWS_AS(sim.drive("cylinder", spring_and_damper), Error);
}

}  // namespace momentree
