// Restarts at another state: Simulation::set_state and World::momenta_of.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

std::vector<double> copy(std::span<const double> all) { return {all.begin(), all.end()}; }

// A free body with a ball joint and a damped revolute one: q has 7 + 4 + 1 numbers, p has 6 + 3 + 1.
Model probe() {
  Model model({.gravity = {0, 0, -1}});
  const BodyId hull = model.add({.name = "hull", .mass = 3, .com = {0.1, 0, 0}, .inertia = diagonal(1, 2, 3), .joint = Free{}});
  const BodyId arm = model.add({.name = "arm",
                                .mass = 1,
                                .com = {0, 0.3, 0},
                                .inertia = diagonal(0.1, 0.2, 0.15),
                                .parent = hull,
                                .at = {0.5, 0, 0},
                                .joint = Ball{}});
  model.add({.name = "hand",
             .mass = 0.5,
             .com = {0.1, 0, 0},
             .inertia = diagonal(0.02),
             .parent = arm,
             .at = {0, 0.6, 0},
             .joint = Revolute{.axis = {1, 0, 1}, .damping = 0.1}});
  return model;
}
const std::vector<double> some_v = {0.1, -0.2, 0.3, 0.4, -0.5, 0.6, 0.7, 0.8, -0.9, 1.1};

double largest_difference(std::span<const double> a, std::span<const double> b) {
  REQUIRE(a.size() == b.size());
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, std::fabs(a[i] - b[i]));
  return worst;
}

Model pendulum(const JointSpec& joint) {
  Model model({.gravity = {0, 0, -9.81}});
  model.add({.name = "bob", .mass = 1, .com = {0, 0, -1}, .inertia = diagonal(0.1), .joint = joint});
  return model;
}

}  // namespace

TEST_CASE("the momenta of velocities give these velocities back") {
  Simulation sim(probe());
  std::vector<double> q = copy(sim.world().state().q());
  q[0] = 2, q[11] = 0.7;
  sim.set_state(1.5, q, sim.world().momenta_of(q, some_v));
  CHECK(sim.time() == 1.5);
  CHECK(copy(sim.world().state().q()) == q);
  CHECK(largest_difference(sim.world().v(), some_v) < 1e-14);
  CHECK(sim.world().joint({2}).q[0] == 0.7);
  CHECK(sim.world().motions()[0].pose.position.x == 2);
}

TEST_CASE("a state that is set as it is continues bit for bit, and one of another run is continued as that run does") {
  Simulation one(probe()), other(probe());
  one.set_state(0, one.world().state().q(), one.world().momenta_of(one.world().state().q(), some_v));
  other.set_state(0, other.world().state().q(), one.world().p());
  CHECK(one.run_until(0.3) == Status::ok);
  CHECK(other.run_until(0.3) == Status::ok);
  for (int k = 0; k < 3; ++k) {
    other.set_state(other.time(), other.world().state().q(), other.world().p());
    CHECK(one.run_until(0.4 + 0.1 * k) == Status::ok);
    CHECK(other.run_until(0.4 + 0.1 * k) == Status::ok);
  }
  CHECK(copy(one.world().state().q()) == copy(other.world().state().q()));
  CHECK(copy(one.world().p()) == copy(other.world().p()));
}

TEST_CASE("the topology is kept, events and energies begin anew") {
  Simulation sim(probe());
  sim.keep_history();
  sim.apply(impulse("hull", {1, 2, 3}));
  sim.apply(break_joint("hand"));
  CHECK(sim.run_until(0.5) == Status::ok);
  const std::vector<double> q = copy(sim.world().state().q()), p = copy(sim.world().p());
  CHECK(p.size() == 15);
  sim.set_state(0.25, q, p);
  CHECK(sim.world().mechanisms().size() == 2);
  CHECK(sim.world().find_joint("arm") >= 0);
  CHECK(sim.events().empty());
  CHECK_FALSE(sim.can_undo(0));
  CHECK(sim.energy().dissipated == 0);
  CHECK(std::fabs(sim.energy().error) < 1e-12);
  CHECK(sim.run_until(1) == Status::ok);
  CHECK(std::fabs(sim.energy().error) < 1e-8);
}

TEST_CASE("quaternions are normalised, and refused if they are no rotations; errors change nothing") {
  Simulation sim(probe());
  const std::vector<double> q = copy(sim.world().state().q()), p = sim.world().momenta_of(q, some_v);
  std::vector<double> turned = q;
  turned[7] = 0.6 + 5e-10, turned[8] = 0.8;
  sim.set_state(0, turned, p);
  const auto now = sim.world().joint({1}).q;
  CHECK(std::fabs(std::hypot(now[0], now[1]) - 1) < 1e-15);
  CHECK(now[0] == doctest::Approx(0.6).epsilon(1e-8));

  const std::vector<double> kept = copy(sim.world().state().q());
  const auto with = [](std::vector<double> all, std::size_t i, double x) {
    all[i] = x;
    return all;
  };
  const auto refused = [&](double time, const std::vector<double>& new_q, const std::vector<double>& new_p, const char* what,
                           const char* where) {
    const std::string said = error_of([&] { sim.set_state(time, new_q, new_p); });
    INFO(said);
    CHECK(said.find(what) != std::string::npos);
    CHECK(said.find(where) != std::string::npos);
    CHECK(copy(sim.world().state().q()) == kept);
    CHECK(sim.time() == 0);
  };
  refused(1, with(q, 3, 1.001), p, "length 1.001", "joint 'hull'");
  refused(1, with(q, 7, 0), p, "length 0", "joint 'arm'");
  refused(1, with(q, 11, no_number), p, "number 11 of the coordinates is not a number", "joint 'hand'");
  refused(1, q, with(p, 8, -inf), "number 8 of the momenta is -inf", "joint 'arm'");
  refused(1, {1, 2, 3}, p, "3 coordinates were given, but the joints have 12", "");
  refused(1, q, {}, "0 momenta were given, but the joints have 10", "");
  refused(-1e-3, q, p, "-0.001 s", "not negative");
  refused(no_number, q, p, "time", "");
  refused(inf, q, p, "time", "");
  CHECK(error_of([&] { static_cast<void>(sim.world().momenta_of(q, q)); }).find("12 velocities") != std::string::npos);
  CHECK(error_of([&] { static_cast<void>(sim.world().momenta_of(with(q, 3, 2), some_v)); }).find("length") != std::string::npos);
  CHECK(error_of([&] { static_cast<void>(sim.world().momenta_of(q, with(some_v, 0, no_number))); }).find("velocities") !=
        std::string::npos);
}

TEST_CASE("prescribed motions are followed, and locked joints stay at rest, whatever the arrays say") {
  Model model;
  const BodyId base = model.add({.name = "base",
                                 .mass = 1,
                                 .com = {0.1, 0, 0},
                                 .inertia = diagonal(1),
                                 .joint = Revolute{.drive = motion_drive(Signal::ramp(2, 0.5))}});
  const BodyId elbow = model.add({.name = "elbow",
                                  .mass = 1,
                                  .com = {0.3, 0, 0},
                                  .inertia = diagonal(1),
                                  .parent = base,
                                  .at = {1, 0, 0},
                                  .joint = Revolute{}});
  model.add({.name = "tip",
             .mass = 1,
             .com = {0.2, 0, 0},
             .inertia = diagonal(1),
             .parent = elbow,
             .at = {1, 0, 0},
             .joint = Revolute{}});
  Simulation sim(model);
  sim.apply(lock("elbow"));
  const std::vector<double> q = {9, 0.1, 0.2}, v = {9, 9, 0.3}, present = sim.world().momenta_of(q, v);
  CHECK(present[0] == 2);
  CHECK(present[1] == 0);
  sim.set_state(3, q, sim.world().momenta_of(q, v, 3));
  CHECK(copy(sim.world().state().q()) == std::vector<double>{6.5, 0.1, 0.2});
  CHECK(largest_difference(sim.world().v(), std::vector<double>{2, 0, 0.3}) < 1e-14);
}

TEST_CASE("a joint that rests on a stop is released by another state, but not by its own") {
  const JointSpec stopped = Revolute{.axis = y_axis, .limits = {.lower = -0.5, .upper = 0.5}};
  Simulation sim(pendulum(stopped));
  sim.set_gravity({9.81, 0, 0});
  CHECK(sim.run_until(3) == Status::ok);
  REQUIRE(sim.world().joint({0}).resting == 1);
  const std::vector<double> q = copy(sim.world().state().q()), p = copy(sim.world().p());
  CHECK(std::fabs(std::fabs(q[0]) - 0.5) < 1e-9);
  sim.set_state(0, q, p);
  CHECK(sim.world().joint({0}).resting == 1);
  CHECK(sim.run_until(0.5) == Status::ok);
  CHECK(copy(sim.world().state().q()) == q);

  const std::vector<double> away = {q[0] > 0 ? -1.0 : 1.0};
  sim.set_state(1, q, sim.world().momenta_of(q, away));
  CHECK(sim.world().joint({0}).resting == 0);
  CHECK(sim.world().v()[0] == doctest::Approx(away[0]).epsilon(1e-14));
  CHECK(sim.run_until(1.05) == Status::ok);
  CHECK(std::fabs(sim.world().state().q()[0]) < 0.5 - 1e-3);
  CHECK(sim.run_until(4) == Status::ok);
  REQUIRE(sim.world().joint({0}).resting == 1);

  const std::vector<double> middle = {0.1}, rest = {0};
  sim.set_state(2, middle, sim.world().momenta_of(middle, rest));
  CHECK(sim.world().joint({0}).resting == 0);
  CHECK(sim.run_until(2.1) == Status::ok);
  CHECK(sim.world().state().q()[0] != 0.1);
  const std::vector<double> outside = {0.6};
  CHECK(error_of([&] { sim.set_state(0, outside, rest); }).find("beyond the stop at 0.5") != std::string::npos);
}

TEST_CASE("scheduled events stay: past ones do not happen, and can happen again if the clock is set back") {
  Simulation sim(pendulum(Revolute{.axis = y_axis}));
  const auto push = impulse("bob", {1, 0, 0});
  sim.at(0).then(push).named("begin");
  sim.at(1).then(push).named("late");
  sim.every(0.25, 0.25).then(push).named("tick");
  sim.after("late", 0.1).then(push).named("echo");
  sim.when(position_of("bob") > 0.3).then(push).named("high");
  const auto names = [&] {
    std::vector<std::string> all;
    for (const Event& e : sim.events()) all.push_back(e.name);
    return all;
  };
  using Names = std::vector<std::string>;
  const std::vector<double> zero = {0.0}, still = {0.0}, high = {0.4};
  sim.set_gravity({});
  CHECK(sim.run_until(0.3) == Status::ok);
  CHECK(names() == Names{"begin", "tick"});
  sim.set_state(0.3, zero, still);
  CHECK(sim.run_until(0.4) == Status::ok);
  CHECK(names().empty());
  sim.set_state(1.05, zero, still);  // "late" is missed, and so is its echo
  CHECK(sim.run_until(1.2) == Status::ok);
  CHECK(names().empty());
  sim.set_state(1.3, high, still);
  CHECK(sim.run_until(1.55) == Status::ok);
  CHECK(names() == Names{"high", "tick"});
  sim.set_state(0, zero, still);
  for (int again = 0; again < 2; ++again) {
    CHECK(sim.run_until(0.05) == Status::ok);
    CHECK(names() == Names{"begin"});
    sim.set_state(0.9, zero, still);
    CHECK(sim.run_until(1.12) == Status::ok);
    CHECK(names() == Names{"late", "tick", "echo"});
    sim.set_state(0, zero, still);
  }
}

TEST_CASE("the observer is called at every multiple of its period after a restart, too") {
  Simulation sim(pendulum(Revolute{.axis = y_axis}));
  std::vector<double> seen;
  sim.observe(0.1, [&](const World& world) {
    seen.push_back(world.time());
    return true;
  });
  CHECK(sim.run_until(0.35) == Status::ok);
  seen.clear();
  sim.set_state(0, std::vector<double>{0.5}, std::vector<double>{0.0});
  CHECK(sim.run_until(0.2) == Status::ok);
  CHECK(seen == std::vector<double>{0, 0.1, 0.2});
}

TEST_CASE("an adjustment goes on with the run: its events stay, and the energy that it adds is work") {
  Simulation sim(pendulum(Revolute{.axis = y_axis}));
  sim.at(0.1).then(impulse("bob", {1, 0, 0}));
  sim.at(0.3).then(impulse("bob", {0.5, 0, 0}));
  REQUIRE(sim.run_until(0.2));
  const EnergyBalance before = sim.energy();
  const std::vector<double> q = {sim.world().state().q()[0] + 0.4}, p = {0.3};
  sim.adjust(std::vector<double>{2.0}, p);  // only the last one before a step counts
  sim.adjust(q, p);
  const EnergyBalance after = sim.energy();
  CHECK(sim.time() == doctest::Approx(0.2));
  CHECK(sim.events().size() == 1);
  CHECK(after.initial == before.initial);
  CHECK(after.work - before.work == doctest::Approx(after.final - before.final).epsilon(1e-12));
  REQUIRE(sim.run_until(0.5));
  CHECK(sim.events().size() == 2);
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  CHECK(error_of([&] { sim.adjust(q, std::vector<double>{inf}); }).find("number 0 of the momenta") != std::string::npos);
}
