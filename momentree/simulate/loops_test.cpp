// Worlds with closed loops: changes, undo, branches, snapshots and saved runs.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/run_state.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {
namespace {

JointSpec revolute() {
  JointSpec joint;
  joint.kind = Kind::revolute, joint.axis = y_axis;
  return joint;
}

BodySpec bar(const std::string& name, BodyId parent, double at, double length, double q, double v = 0) {
  BodySpec spec;
  spec.name = name, spec.mass = 1, spec.com = {length / 2, 0, 0}, spec.inertia = diagonal(1e-4, 0.02, 0.02);
  spec.parent = parent, spec.at = Pose{{at, 0, 0}, Quat{}};
  spec.joint = revolute();
  spec.q = q, spec.v = v;
  return spec;
}

/// A crank, a coupler and a rocker on the ground; the pin between coupler and rocker closes the loop.
Model four_bar() {
  Model model;
  const BodyId crank = model.add(bar("bar/crank", ground, 0, 0.3, -1.2, 3));
  const BodyId coupler = model.add(bar("bar/coupler", crank, 0.3, 0.7, 0.9));
  const BodyId rocker = model.add(bar("bar/rocker", ground, 0.8, 0.5, -1.6));
  LoopSpec pin;
  pin.name = "pin", pin.body = coupler, pin.to = rocker;
  pin.joint = revolute();
  pin.joint.parameters.damping = 0.05;
  pin.at.position = {0.5, 0, 0}, pin.child_at.position = {0.7, 0, 0};
  model.add_loop(pin);
  return model;
}

std::vector<double> bits(const World& world) {
  std::vector<double> all{world.time()};
  const auto append = [&all](Numbers numbers) { all.insert(all.end(), numbers.begin(), numbers.end()); };
  append(world.state().q()), append(world.state().y());
  for (const double turn : world.state().turns()) all.push_back(turn);
  for (const JointId loop : world.loops()) append(world.joint(loop).q), append(world.joint(loop).v);
  return all;
}

void go(Simulation& sim, double until) { REQUIRE(sim.run_until(until) == Status::ok); }

struct Way {
  const char* method;
  Variables variables;
};
std::vector<Way> every_way() {
  std::vector<Way> all;
  for (const char* method : {"rk4", "midpoint", "dopri5", "dop853"})
    for (const Variables variables : {Variables::velocities, Variables::momenta}) all.push_back({method, variables});
  return all;
}

}  // namespace

TEST_CASE("undo, branches and snapshots of worlds with loops are exact") {
  JointSpec ball;
  ball.kind = Kind::ball;
  const std::vector<Action> changes{
      break_joint("pin"), break_joint("bar/coupler"), break_joint("bar/crank"), attach("bar/crank", "bar/rocker", ball),
      lock("pin"),        lock("bar/crank"),          free_joint("pin")};
  for (const auto& [method, variables] : every_way())
    for (const Action& change : changes) {
      CAPTURE(method);
      CAPTURE(name_of(variables));
      CAPTURE(change.text());
      Simulation sim(four_bar(), {.method = method, .variables = variables});
      sim.keep_history();
      go(sim, 0.05);
      const std::vector<double> before = bits(sim.world());
      const SimulationSnapshot snapshot = sim.snapshot();
      sim.apply(change, "clasp");
      go(sim, 0.1);
      const std::vector<double> after = bits(sim.world());
      Simulation branch = sim.branch();
      go(branch, 0.15), go(sim, 0.15);
      CHECK(bits(branch.world()) == bits(sim.world()));
      sim.undo(0);
      CHECK(bits(sim.world()) == before);
      CHECK(sim.world().joint_name(sim.world().loops()[0]) == "pin");
      sim.apply(change, "clasp");
      go(sim, 0.1);
      CHECK(bits(sim.world()) == after);
      sim.restore(snapshot);
      CHECK(bits(sim.world()) == before);
      sim.apply(change, "clasp");
      go(sim, 0.1);
      CHECK(bits(sim.world()) == after);
    }
}

TEST_CASE("a saved run with loops continues to the same bits") {
  for (const auto& [method, variables] : every_way()) {
    CAPTURE(method);
    CAPTURE(name_of(variables));
    const auto schedule = [](Simulation& sim) {
      sim.at(0.12).then(break_joint("bar/coupler")).named("cut");
      sim.at(0.2).then(attach("bar/coupler", "bar/crank", revolute())).named("clasp");
    };
    Simulation sim(four_bar(), {.method = method, .variables = variables});
    schedule(sim);
    for (const double until : {0.1, 0.15, 0.25}) {
      go(sim, until);
      Simulation again(four_bar(), {.method = method, .variables = variables});
      schedule(again);
      again.continue_from(sim.run_state());
      CHECK(bits(again.world()) == bits(sim.world()));
      Simulation onwards = sim.branch();
      go(onwards, 0.3), go(again, 0.3);
      CHECK(bits(again.world()) == bits(onwards.world()));
    }
  }
}

TEST_CASE("a loop joint takes the place of a broken joint of the tree") {
  for (int i = 0; i < 6; ++i) {
    const char* const broken = std::array{"bar/crank", "bar/coupler", "bar/rocker"}[static_cast<std::size_t>(i / 2)];
    CAPTURE(broken);
    const Variables variables = i % 2 == 0 ? Variables::velocities : Variables::momenta;
    Simulation sim(four_bar(), {.variables = variables});
    go(sim, 0.1);
    const JointView pin = sim.world().joint(sim.world().loops()[0]);
    const double q = pin.q[0], v = pin.v[0];
    const std::vector<BodyMotion> motions(sim.world().motions().begin(), sim.world().motions().end());
    const double energy = sim.world().totals().kinetic + sim.world().totals().potential;
    sim.apply(break_joint(broken), "cut");
    const World& world = sim.world();
    CHECK(world.loops().empty());
    const JointView now = world.joint({world.find_joint("pin")});
    CHECK_FALSE(now.loop);
    CHECK(now.parameters->damping.of(0) == 0.05);
    CHECK(now.q[0] == doctest::Approx(q).epsilon(1e-12));
    CHECK(now.v[0] == doctest::Approx(v).epsilon(1e-10));
    CHECK(world.model()[now.child].name == "bar/coupler");
    CHECK(world.model()[now.parent].name == "bar/rocker");
    CHECK(std::fabs(world.totals().kinetic + world.totals().potential - energy) < 1e-12);
    for (std::size_t b = 0; b < motions.size(); ++b) {
      CHECK(norm(world.motions()[b].pose.position - motions[b].pose.position) < 1e-13);
      CHECK(norm(world.motions()[b].linear - motions[b].linear) < 1e-12);
    }
    sim.drive("pin", [](const EvaluationContext&) { return 0.1; });  // a joint like others now
    go(sim, 0.2);
    sim.apply(lock("pin"), "jam");
    go(sim, 0.3);
  }
}

TEST_CASE("with variables = momenta the state holds momenta, whatever closes and opens") {
  for (const char* method : {"rk4", "dop853"}) {
    CAPTURE(method);
    Simulation sim(four_bar(), {.method = method, .variables = Variables::momenta});
    const auto in_momenta = [&] {
      const World& world = sim.world();
      CHECK(world.state().variables() == Variables::momenta);
      const std::vector<double> p = world.momenta_of(world.state().q(), world.v());
      for (std::size_t i = 0; i < p.size(); ++i) CHECK(world.p()[i] == doctest::Approx(p[i]).epsilon(1e-12));
    };
    in_momenta(), go(sim, 0.1), in_momenta();
    sim.apply(attach("bar/coupler", "ground", revolute()), "pivot");
    in_momenta(), go(sim, 0.15), in_momenta();
    sim.apply(break_joint("pivot"), "let go");
    in_momenta(), go(sim, 0.2), in_momenta();
    sim.apply(break_joint("pin"), "open");
    in_momenta(), go(sim, 0.3), in_momenta();
    sim.apply(attach("bar/coupler", "bar/rocker", revolute()), "pinned");
    in_momenta(), go(sim, 0.4), in_momenta();
    const World& world = sim.world();
    sim.set_state(1, world.state().q(), world.v(), Variables::velocities);
    in_momenta(), go(sim, 1.1), in_momenta();
    const std::vector<double> q(world.state().q().begin(), world.state().q().end()), p(world.p().begin(), world.p().end());
    sim.set_state(1.1, q, p);  // kept as given
    CHECK(std::equal(p.begin(), p.end(), world.p().begin()));
    const World again(four_bar(), Variables::momenta, Variables::momenta);
    CHECK(again.state().variables() == Variables::momenta);
    const World usual(four_bar());
    CHECK(usual.state().variables() == Variables::velocities);
  }
}

TEST_CASE("a condition is met at the same instant in momenta and in velocities") {
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    CAPTURE(method);
    double instant[2];
    for (const Variables variables : {Variables::velocities, Variables::momenta}) {
      Simulation sim(four_bar(), {.method = method, .variables = variables, .step = 1e-4, .rtol = 1e-11, .atol = 1e-13});
      sim.when(position_of("bar/crank").exceeds(-1.1)).then(break_joint("pin")).named("open");
      go(sim, 1);
      REQUIRE(sim.events().size() == 1);
      instant[variables == Variables::momenta ? 1 : 0] = sim.events()[0].time;
    }
    CHECK(std::fabs(instant[0] - instant[1]) < 1e-8);
  }
}

TEST_CASE("the energy balance closes with loops, projection included") {
  for (const auto& [method, variables] : every_way()) {
    CAPTURE(method);
    CAPTURE(name_of(variables));
    Simulation sim(four_bar(), {.method = method, .variables = variables, .step = 1e-3, .rtol = 1e-9, .atol = 1e-11});
    go(sim, 1);
    const EnergyBalance balance = sim.energy();
    CHECK(balance.dissipated > 1e-3);
    const double error = balance.final + balance.dissipated + balance.lost_in_impacts + balance.released - balance.initial -
                         balance.work - balance.projection;
    CHECK(balance.error == doctest::Approx(error).epsilon(0).scale(1).epsilon(1e-14));
    CHECK(std::fabs(balance.error) < (std::string(method) == "midpoint" ? 1e-3 : 1e-6));
    CHECK(sim.world().loop_status().residual < 1e-13);
  }
}

TEST_CASE("what would leave only some degrees of freedom of a loop joint locked is refused, by lock and by unlock") {
  for (const Kind kind : {Kind::ball, Kind::planar}) {
    Simulation sim(four_bar(), {});
    JointSpec joint;
    joint.kind = kind;
    sim.apply(attach("bar/crank", "bar/rocker", joint), "clasp");
    const auto refusal = [&](const Action& action) {
      const RunResult result = sim.try_apply({&action, 1}, "change");
      CHECK(result.status == Status::refused);
      return result.reason;
    };
    CHECK(refusal(lock("clasp", {0})).find("only some degrees of freedom") != std::string::npos);
    sim.apply(lock("clasp"), "jam");
    CHECK(refusal(unlock("clasp", {0})).find("only some degrees of freedom") != std::string::npos);
    CHECK(sim.world().joint(sim.world().loops()[1]).locked == 7u);
    sim.apply(unlock("clasp"), "release");
    CHECK(sim.world().joint(sim.world().loops()[1]).locked == 0u);
  }
}

TEST_CASE("a warning says if closing the loops changes the energy, unless the balance itself is off") {
  EnergyBalance balance;
  balance.largest_kinetic = 2, balance.projection = -1e-3;
  CHECK(balance.advice({.method = "rk4"}).empty());
  balance.projection = -0.1;
  const std::string fixed = balance.advice({.method = "rk4", .step = 1e-3}), adaptive = balance.advice({.method = "dop853"});
  CHECK(fixed.find("changed the energy by -0.1 J, 5 % of the largest kinetic energy") != std::string::npos);
  CHECK(fixed.find("0.00025 s, or an adaptive method: dop853") != std::string::npos);
  CHECK(adaptive.find("rtol = 1e-10") != std::string::npos);
  balance.error = 1;
  CHECK(balance.advice({.method = "rk4"}).find("the energy balance is off") != std::string::npos);
}

TEST_CASE("functions and unsupported parameters of loop joints are refused") {
  Simulation sim(four_bar());
  const auto says = [](const auto& call) {
    try {
      call();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(says([&] { sim.drive("pin", [](const EvaluationContext&) { return 0.0; }); }).find("closes a loop") != std::string::npos);
  CHECK(says([&] { sim.apply(set_parameters("pin", {.armature = 1}), "x"); }).find("armature") != std::string::npos);
  CHECK(says([&] { static_cast<void>(Simulation(four_bar(), {.method = "damped"})); }).find("damped") != std::string::npos);
}

}  // namespace momentree
