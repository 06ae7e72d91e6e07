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
  for (const Turns& turns : world.state().turns()) all.push_back(turns.first), all.push_back(turns.second);
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
  all.push_back({"damped", Variables::momenta});
  return all;
}

/// Distance of the rocker's angle after 0.4 s from that with an accurate method.
double off(const Model& model, double step) {
  Simulation sim(model, {.method = "damped", .step = step});
  Simulation exact(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-13});
  go(sim, 0.4), go(exact, 0.4);
  CHECK(sim.world().state().variables() == Variables::momenta);
  CHECK(sim.world().loop_status().residual < 1e-13);
  CHECK(std::fabs(sim.energy().error) < 1e-3);
  return std::fabs(sim.world().joint({2}).q[0] - exact.world().joint({2}).q[0]);
}

}  // namespace

TEST_CASE("undo, branches and snapshots of worlds with loops are exact") {
  JointSpec ball;
  ball.kind = Kind::ball;
  const std::vector<Action> changes{break_joint("pin"),
                                    break_joint("bar/coupler"),
                                    break_joint("bar/crank"),
                                    attach("bar/crank", "bar/rocker", ball),
                                    lock("pin"),
                                    lock("bar/crank"),
                                    free_joint("pin"),
                                    set_parameters("pin", {.armature = 0.3}),
                                    set_parameters("pin", {.drive = motion_drive(Signal::ramp_from_here(0.4))})};
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

TEST_CASE("both angles of a universal loop joint continue over full turns, also through snapshots and changes of kind") {
  const auto spinner = [](bool in_loop) {
    BodySpec body;
    body.name = "spinner", body.mass = 1, body.inertia = diagonal(0.1, 0.1, 0.1);
    body.joint = in_loop ? JointSpec(Ball{}) : JointSpec(Universal{.axis = x_axis, .axis2 = z_axis});
    body.v = in_loop ? Values{-4, 0, 9} : Values{-4, 9};
    Model model;
    model.set_gravity({});
    const BodyId b = model.add(body);
    if (in_loop) model.add_loop({.name = "cross", .body = b, .joint = Universal{.axis = x_axis, .axis2 = z_axis}});
    return model;
  };
  for (const auto& [method, variables] : every_way()) {
    CAPTURE(method);
    CAPTURE(name_of(variables));
    const Integration way{.method = method, .variables = variables, .step = 1e-3};
    Simulation loop(spinner(true), way), tree(spinner(false), way);
    go(loop, 1), go(tree, 1);
    const JointView own = loop.world().joint(loop.world().loops()[0]),
                    other = tree.world().joint(JointId{tree.world().find_joint("spinner")});
    CHECK(other.q[0] < -3.5);
    CHECK(other.q[1] > 8.5);
    for (int i = 0; i < 2; ++i) CHECK(own.q[i] == doctest::Approx(other.q[i]).epsilon(1e-4));
    const std::vector<double> before = bits(loop.world());
    const SimulationSnapshot snapshot = loop.snapshot();
    go(loop, 1.5);
    loop.restore(snapshot);
    CHECK(bits(loop.world()) == before);
    const double second = own.q[1];
    loop.apply(lock("cross")), loop.apply(unlock("cross"));
    CHECK(loop.world().joint(loop.world().loops()[0]).q[1] == doctest::Approx(second).epsilon(1e-12));
    loop.apply(break_joint("spinner"));  // the loop joint takes its place
    CHECK(loop.world().joint(JointId{loop.world().find_joint("cross")}).q[1] == doctest::Approx(second).epsilon(1e-12));
  }
}

TEST_CASE("loops at the world's origin, where all lengths are zero, stay closed") {
  for (const auto& [method, variables] : every_way()) {
    CAPTURE(method);
    CAPTURE(name_of(variables));
    BodySpec base = bar("m/base", ground, 0, 0.3, 0.4, 1);
    base.joint.axis = {1.1, 2.0, 0.1}, base.com = {0.1, -0.01, -0.06};
    Model model;
    const BodyId b = model.add(base);
    model.add(bar("m/arm", b, 0.35, 0.3, 0.3, -0.5));
    Simulation sim(model, {.method = method, .variables = variables});
    go(sim, 0.05);
    sim.apply(weld("m/base", "ground"), "held");
    go(sim, 0.1);
    sim.apply(change_joint("m/base", Kind::weld));
    go(sim, 0.15);
    CHECK(sim.world().loop_status().residual < 1e-15);
  }
}

TEST_CASE("a point mass in a loop has its equations, whichever body of the loop it is") {
  constexpr double r = 0.1, l = 0.3, q0 = 0.5;
  const auto piston_at = [](double q) { return r * std::cos(q) + std::sqrt(l * l - r * r * std::sin(q) * std::sin(q)); };
  for (const double inertia : {0.0, 1e-12, 1e-9, 1e-6, 1e-2})
    for (const bool swapped : {false, true})
      for (const bool point_rod : {false, true}) {
        CAPTURE(inertia);
        Model model;
        const BodyId crank = model.add(bar("e/crank", ground, 0, r, q0, 10));
        BodySpec spec = bar("e/rod", crank, r, l, -std::asin(r / l * std::sin(q0)) - q0);
        if (point_rod) spec.inertia = diagonal(inertia);
        const BodyId rod = model.add(spec);
        BodySpec piston{.name = "e/piston", .mass = 1, .inertia = diagonal(point_rod ? 0.01 : inertia)};
        piston.joint = Prismatic{.axis = x_axis};
        piston.q = piston_at(q0);
        const BodyId slider = model.add(piston);
        LoopSpec gudgeon{.name = "gudgeon", .body = swapped ? slider : rod, .to = swapped ? rod : slider, .joint = revolute()};
        (swapped ? gudgeon.at : gudgeon.child_at) = Pose{{l, 0, 0}, {}};
        model.add_loop(gudgeon);
        Simulation sim(model, {.method = "dopri5", .rtol = 1e-10, .atol = 1e-12});
        REQUIRE(sim.run_until(1) == Status::ok);
        CHECK(std::fabs(sim.world().joint({0}).q[0] - q0) > 0.5);
        CHECK(sim.world().joint({2}).q[0] == doctest::Approx(piston_at(sim.world().joint({0}).q[0])).epsilon(1e-12));
        CHECK(std::fabs(sim.energy().error) < 1e-8);
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
    CHECK(std::fabs(balance.error) < (std::string(method) == "midpoint" ? 1e-3 : std::string(method) == "damped" ? 1e-5 : 1e-6));
    CHECK(sim.world().loop_status().residual < 1e-13);
  }
}

TEST_CASE("the method damped has order 3 with loops, and is stable however strong the dampers of the tree are") {
  const double coarse = off(four_bar(), 2e-3), fine = off(four_bar(), 1e-3);
  CHECK(coarse < 1e-5);
  CHECK(coarse / fine > 6);
  CHECK(coarse / fine < 10);
  for (const double damping : {1.0, 100.0, 1e6}) {
    CAPTURE(damping);
    Model model;
    const Model lightly = four_bar();
    for (BodySpec body : lightly.bodies()) {
      if (body.name == "bar/coupler") body.joint.parameters.damping = damping;
      if (body.name == "bar/crank") body.v = 0;
      model.add(body);
    }
    model.add_loop(lightly.loops()[0]);
    CHECK(off(model, 1e-3) < 1e-5);
  }
}

TEST_CASE("single degrees of freedom of loop joints lock and unlock") {
  for (const Kind kind : {Kind::ball, Kind::planar}) {
    Simulation sim(four_bar(), {});
    JointSpec joint;
    joint.kind = kind;
    sim.apply(attach("bar/crank", "bar/rocker", joint), "clasp");
    const auto locked = [&] { return sim.world().joint(sim.world().loops()[1]).locked; };
    sim.apply(lock("clasp", {0}), "jam");
    CHECK(locked() == 1u);
    sim.apply(lock("clasp"), "jam all");
    sim.apply(unlock("clasp", {0}), "release one");
    CHECK(locked() == 6u);
    go(sim, 0.05);
    CHECK(sim.world().loop_status().residual < 1e-12);
    sim.apply(unlock("clasp"), "release");
    CHECK(locked() == 0u);
  }
}

TEST_CASE("a warning says if closing the loops changes the energy, unless the balance itself is off") {
  EnergyBalance balance;
  balance.largest_kinetic = 2, balance.projection = -1e-3;
  CHECK(balance.advice({.method = "rk4"}).empty());
  balance.projection = -1e-6;  // adaptive methods: 100 times the relative tolerance
  CHECK(balance.advice({.method = "dop853", .rtol = 1e-8}).empty());
  CHECK(balance.advice({.method = "dop853", .rtol = 1e-9}).find("changed the energy by -1e-06 J") != std::string::npos);
  balance.projection = -0.1;
  const std::string fixed = balance.advice({.method = "rk4", .step = 1e-3}), adaptive = balance.advice({.method = "dop853"});
  CHECK(fixed.find("changed the energy by -0.1 J, 5 % of the largest kinetic energy") != std::string::npos);
  CHECK(fixed.find("0.00025 s, or an adaptive method: dop853") != std::string::npos);
  CHECK(adaptive.find("rtol = 1e-10") != std::string::npos);
  balance.error = 1;
  CHECK(balance.advice({.method = "rk4"}).find("the energy balance is off") != std::string::npos);
}

// A piston that is pulled beyond r + l, which it reaches at a known instant.
TEST_CASE("a motion that leads out of the reach of a loop is named, with the loop") {
  const double r = 0.1, l = 0.25, start = 0.3, rate = 0.05;
  const double x = r * std::cos(start) + std::sqrt(l * l - r * r * std::sin(start) * std::sin(start));
  Model model;
  BodySpec crank = bar("crank", ground, 0, r, start);
  const BodyId turns = model.add(crank);
  const BodyId rod = model.add(bar("rod", turns, r, l, -start - std::asin(r * std::sin(start) / l)));
  BodySpec piston = bar("piston", ground, 0, 0.1, x);
  piston.joint.kind = Kind::prismatic, piston.joint.axis = x_axis;
  piston.joint.parameters.drive = motion_drive(Signal::ramp(rate, x));
  const BodyId slides = model.add(piston);
  LoopSpec wrist;
  wrist.name = "wrist", wrist.body = rod, wrist.to = slides, wrist.joint = revolute();
  wrist.child_at.position = {l, 0, 0};
  model.add_loop(wrist);
  for (const char* method : {"rk4", "dop853"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method, .step = 1e-3});
    const RunResult ended = sim.run_until(1);
    CHECK(ended.status == Status::diverged);
    CHECK(sim.time() == doctest::Approx((r + l - x) / rate).epsilon(0.01));
    CHECK_MESSAGE(ended.reason.find("loop 'wrist' can't be closed any more: the prescribed motion of joint 'piston' leads out "
                                    "of the reach of the mechanism") != std::string::npos,
                  ended.reason);
    CHECK(ended.reason.find("rtol") == std::string::npos);
  }
}

// A cylinder of length l(t) from the ground at a to the tip of a boom: the law of cosines.
TEST_CASE("a cylinder that closes a loop lifts a boom by its prescribed length") {
  const double foot = 0.8, tip = 1.0;
  Model model;
  BodySpec boom = bar("boom", ground, 0, 2, -0.3), barrel = bar("barrel", ground, 0, 0.5, -0.9), rod;
  barrel.at = Pose{{0, 0, -foot}, Quat{}};
  model.add(boom);
  const BodyId base = model.add(barrel);
  rod = bar("rod", model.body("boom"), tip, -0.5, -0.6);
  const BodyId moving = model.add(rod);
  LoopSpec cylinder;
  cylinder.name = "cylinder", cylinder.body = moving, cylinder.to = base;
  cylinder.joint.kind = Kind::prismatic, cylinder.joint.axis = x_axis;
  cylinder.joint.parameters.armature = {2};
  cylinder.joint.parameters.drive = motion_drive(Signal::sine(0.1, 0.5, 0, 1.4));
  model.add_loop(cylinder);
  for (const char* method : {"rk4", "midpoint", "dopri5", "dop853"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method, .step = 1e-3, .rtol = 1e-9, .atol = 1e-11});
    for (const double t : {0.0, 0.3, 0.8, 1.3}) {
      go(sim, t);
      const double l = 1.4 + 0.1 * std::sin(3.14159265358979323846 * t);
      const double cosine = (foot * foot + tip * tip - l * l) / (2 * foot * tip);
      CHECK(-sim.world().joint({sim.world().find_joint("boom")}).q[0] ==
            doctest::Approx(std::acos(cosine) - 3.14159265358979323846 / 2).epsilon(1e-10));
    }
    const EnergyBalance balance = sim.energy();
    CHECK(std::fabs(balance.work) > 1e-3);
    CHECK(std::fabs(balance.error) < (std::string(method) == "midpoint" ? 1e-4 : 1e-8) * (1 + std::fabs(balance.initial)));
    CHECK(sim.world().loop_status().rank == 3);
  }
}

TEST_CASE("motions that contradict each other through a loop are refused, with their names") {
  const auto says = [](Simulation& sim, const std::vector<Action>& actions) { return sim.try_apply(actions, "x").reason; };
  const auto slow = [] { return motion_drive(Signal::ramp_from_here(0.1)); };
  Simulation sim(four_bar());
  CHECK(says(sim, {set_parameters("bar/crank", {.drive = slow()})}).empty());
  const std::string twice = says(sim, {set_parameters("pin", {.drive = slow()})});
  CHECK(twice.find("joint 'pin': its prescribed motion contradicts the one of 'bar/crank'") != std::string::npos);
  const std::string both = says(sim, {set_parameters("bar/rocker", {.drive = slow()})});
  CHECK(both.find("'bar/crank'") != std::string::npos);
  CHECK(both.find("'bar/rocker'") != std::string::npos);
  CHECK(says(sim, {lock("pin")}).find("joint 'bar/crank': its motion is prescribed, but loops and locks") != std::string::npos);
  CHECK(says(sim, {weld("bar/crank")}).find("do not let it move here; weld 'x' holds it: leave that out") != std::string::npos);
  go(sim, 0.2);
  CHECK(says(sim, {break_joint("pin"), set_parameters("bar/rocker", {.drive = slow()})}).empty());
  go(sim, 0.3);
  const std::string rigid = says(sim, {attach("bar/coupler", "bar/rocker", revolute())});  // a triangle
  CHECK_MESSAGE(rigid.find("its motion is prescribed, but loops and locks do not let it move") != std::string::npos, rigid);
}

TEST_CASE("in momenta, loop joints take armatures and prescribed motions while a run goes on") {
  const auto moving = [] {
    JointSpec joint = revolute();
    joint.parameters.drive = motion_drive(Signal::ramp_from_here(0.4));
    return joint;
  };
  const std::vector<Action> changes{
      set_parameters("pin", {.armature = 0.3}), set_parameters("pin", {.drive = moving().parameters.drive}),
      attach("bar/crank", "bar/rocker",
             [] {
               JointSpec joint;
               joint.kind = Kind::planar, joint.axis = y_axis, joint.parameters.armature = {0.1, 0.2, 0.05};
               return joint;
             }()),
      change_joint("pin", moving())};
  for (const Action& change : changes) {
    CAPTURE(change.text());
    std::vector<Simulation> runs;
    for (const Variables variables : {Variables::velocities, Variables::momenta}) {
      Simulation& sim = runs.emplace_back(four_bar(), Integration{.method = "dop853", .variables = variables, .rtol = 1e-12});
      go(sim, 0.05);
      sim.apply(change, "change");
      go(sim, 0.15);
      sim.apply(impulse("bar/coupler", {0.1, 0, 0.3}), "hit");
      go(sim, 0.25);
      CHECK(sim.world().state().variables() == variables);
      CHECK(std::fabs(sim.energy().error) < 1e-8);
    }
    for (std::size_t i = 0; i < runs[0].world().state().q().size(); ++i)
      CHECK(runs[1].world().state().q()[i] == doctest::Approx(runs[0].world().state().q()[i]).epsilon(1e-7));
    CHECK(runs[1].energy().work == doctest::Approx(runs[0].energy().work).epsilon(1e-6));
  }
}

}  // namespace momentree
