#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double mass = 3, length = 2, inertia = 0.5, g = 9.81;

Model pendulum(const Signal& angle, double armature = 0) {
  Model model({.gravity = {0, 0, -g}});
  model.add({.name = "bob",
             .mass = mass,
             .com = {0, 0, -length},
             .inertia = diagonal(inertia),
             .joint = Revolute{.axis = y_axis, .armature = armature, .drive = motion_drive(angle)},
             .joint_name = "pin"});
  return model;
}

// A floating hull with a driven arm that carries a swinging hand.
Model floating(const Signal& angle, double armature = 0.2) {
  Model model({.gravity = {}});
  const BodyId hull = model.add({.name = "hull",
                                 .mass = 5,
                                 .com = {0.1, 0, 0.2},
                                 .inertia = diagonal(0.8, 0.9, 1),
                                 .joint = Free{},
                                 .v = {0.1, -0.2, 0.3, 0.1, 0.2, -0.3}});
  const BodyId arm = model.add({.name = "arm",
                                .mass = 1,
                                .com = {0.25, 0.1, 0},
                                .inertia = diagonal(0.1, 0.2, 0.3),
                                .parent = hull,
                                .at = {0, 0, 0.5},
                                .joint = Revolute{.axis = {1, 1, 0}, .armature = armature, .drive = motion_drive(angle)}});
  model.add({.name = "hand",
             .mass = 0.5,
             .com = {0, 0.1, 0.2},
             .inertia = diagonal(0.01),
             .parent = arm,
             .at = {0.5, 0, 0},
             .joint = Universal{.axis = y_axis, .axis2 = x_axis, .damping = 0.02, .stiffness = 0.5},
             .q = {0.7, 0.1},
             .v = {-1, 0.4}});
  return model;
}

Integration exactly() { return {.method = "dopri5", .step = 1e-3, .rtol = 1e-11, .atol = 1e-12}; }

double scale(const Simulation& sim) {
  const EnergyBalance e = sim.energy();
  return std::max({std::fabs(e.initial), std::fabs(e.final), std::fabs(e.dissipated), std::fabs(e.work), 1.0});
}

}  // namespace

TEST_CASE("a driven joint follows its curve to rounding, by every method, and its effort is that of the closed form") {
  const double a = 0.8, f = 0.7, armature = 0.4, J = inertia + mass * length * length;
  const Signal swing = Signal::sine(a, f, 0.3, 0.2);
  for (const char* method : {"rk4", "dopri5", "midpoint", "damped"}) {
    Simulation sim(pendulum(swing, armature), {.method = method, .step = 1e-3, .max_step = 1e-3});
    double worst = 0, worst_effort = 0;
    sim.observe(0, [&](const World& world) {
      const Curve::Point s = Curve(swing).at(world.time());
      const JointView hinge = world.joint({0});
      const JointForces forces = world.joint_forces({0});
      const double effort = (J + armature) * s.acceleration + mass * g * length * std::sin(s.value);
      worst = std::max({worst, std::fabs(hinge.q[0] - s.value), std::fabs(hinge.v[0] - s.rate),
                        std::fabs(forces.a[0] - s.acceleration), std::fabs(hinge.p[0]), std::fabs(hinge.pdot[0])});
      worst_effort = std::max({worst_effort, std::fabs(forces.effort[0] - effort) / 100,
                               std::fabs(forces.reaction.torque.y - effort + armature * s.acceleration) / 100,
                               std::fabs(forces.bearing.torque.y) / 100});
      return true;
    });
    REQUIRE(sim.run_until(10) == Status::ok);
    CHECK(sim.statistics().steps >= 10'000);
    CHECK(worst <= 1e-14);
    CHECK(worst_effort <= 1e-14);
    CHECK(std::fabs(sim.energy().error) <= (method[0] == 'm'                       ? 1e-4
                                            : method[0] == 'd' && method[1] == 'a' ? 1e-6
                                                                                   : 1e-9) *
                                               scale(sim));
  }
}

TEST_CASE("a pendulum rotated at a constant rate needs the torque of its weight") {
  Simulation sim(pendulum(Signal::table({{0, 0}, {1, 0.5}, {3, 3}, {4, 3.5}})), exactly());
  REQUIRE(sim.run_until(5) == Status::ok);
  CHECK(sim.world().joint({0}).q[0] == 3.5);
  CHECK(sim.world().joint({0}).v[0] == 0);
  CHECK(sim.world().joint_forces({0}).effort[0] == doctest::Approx(mass * g * length * std::sin(3.5)).epsilon(1e-14));
  // All work of the drive lifts the weight.
  CHECK(sim.energy().work == doctest::Approx(mass * g * length * (1 - std::cos(3.5))).epsilon(1e-11));
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
}

TEST_CASE("a floating mechanism with a prescribed motion keeps its momenta, and its energy is the drive's work") {
  Simulation sim(floating(Signal::sine(1.2, 0.9)), exactly());
  const Totals start = sim.world().totals();
  REQUIRE(sim.run_until(3) == Status::ok);
  const Totals end = sim.world().totals();
  CHECK(norm(end.linear - start.linear) <= 1e-9);
  CHECK(norm(end.angular - start.angular) <= 1e-9);
  CHECK(std::fabs(sim.energy().work) > 1e-2);
  CHECK(sim.energy().dissipated > 1e-2);
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
}

TEST_CASE("strongly damped joints, integrated implicitly, next to a prescribed motion") {
  Model model = floating(Signal::sine(1.2, 0.9));
  model.add({.name = "brake",
             .mass = 0.2,
             .com = {0.1, 0, 0},
             .inertia = diagonal(1e-3),
             .parent = {1},
             .at = {0, 0.2, 0},
             .joint = Revolute{.damping = 40, .friction = {0.1, 0.5}}});
  Simulation damped(model, {.method = "damped", .step = 5e-4}), exact(model, exactly());
  REQUIRE(damped.run_until(0.5) == Status::ok);
  REQUIRE(exact.run_until(0.5) == Status::ok);
  CHECK(damped.world().joint({1}).q[0] == Curve(Signal::sine(1.2, 0.9)).at(0.5).value);
  for (std::size_t b = 0; b < 4; ++b)
    CHECK(norm(damped.world().motions()[b].pose.position - exact.world().motions()[b].pose.position) <= 1e-7);
  CHECK(damped.energy().work == doctest::Approx(exact.energy().work).epsilon(1e-5));
  CHECK(damped.energy().dissipated == doctest::Approx(exact.energy().dissipated).epsilon(1e-5));
}

TEST_CASE("re-rooting does not affect a prescribed motion") {
  Simulation here(floating(Signal::sine(1.2, 0.9)), exactly()), there(floating(Signal::sine(1.2, 0.9)), exactly());
  const JointForces before = there.world().joint_forces({1});
  const Wrench reaction = before.reaction;
  const double effort = before.effort[0];
  there.apply(reroot("hand"));
  CHECK(there.world().joint({1}).reversed);
  CHECK(there.world().joint({1}).driven);
  CHECK(there.world().joint_forces({1}).effort[0] == doctest::Approx(effort).epsilon(1e-12));
  CHECK(norm(there.world().joint_forces({1}).reaction.force - reaction.force) <= 1e-12 * norm(reaction.force));
  REQUIRE(here.run_until(2) == Status::ok);
  REQUIRE(there.run_until(2) == Status::ok);
  for (int b = 0; b < 3; ++b) {
    const BodyMotion one = here.world().motions()[static_cast<std::size_t>(b)],
                     other = there.world().motions()[static_cast<std::size_t>(b)];
    CHECK(norm(one.pose.position - other.pose.position) <= 1e-8);
    CHECK(norm(one.angular - other.angular) <= 1e-8);
  }
  CHECK(std::fabs(there.energy().error) <= 1e-9 * scale(there));
}

TEST_CASE("locks stop a prescribed motion by an impulse, unlocks resume it, breaks end it") {
  const Signal swing = Signal::sine(0.6, 1);  // at the same position at 0.1 s and 0.4 s
  Simulation sim(floating(swing), exactly());
  const Totals start = sim.world().totals();
  const auto unmoved = [&] {
    const Totals now = sim.world().totals();
    CHECK(norm(now.linear - start.linear) <= 1e-9);
    CHECK(norm(now.angular - start.angular) <= 1e-9);
    CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
  };
  REQUIRE(sim.run_until(0.1) == Status::ok);
  const double speed = sim.world().joint({1}).v[0];
  const Event locked = sim.apply(lock("arm"));
  CHECK(speed > 1);
  CHECK(sim.world().joint({1}).v[0] == 0);
  CHECK_FALSE(sim.world().joint({1}).driven);
  CHECK(locked.lost > 0);
  CHECK(locked.released == doctest::Approx(0.5 * 0.2 * speed * speed));
  CHECK(locked.impulse.size() >= 1);
  unmoved();
  REQUIRE(sim.run_until(0.25) == Status::ok);
  CHECK_THROWS_AS(sim.apply(unlock("arm")), Error);
  unmoved();
  REQUIRE(sim.run_until(0.4) == Status::ok);
  const Event& unlocked = sim.apply(unlock("arm"));
  CHECK(sim.world().joint({1}).v[0] == Curve(swing).at(0.4).rate);
  CHECK(unlocked.work != 0);
  unmoved();
  REQUIRE(sim.run_until(0.5) == Status::ok);
  unmoved();
  const std::vector<BodyMotion> before = sim.world().motions();
  sim.apply(break_joint("arm"));
  for (std::size_t b = 0; b < 3; ++b) {
    CHECK(norm(sim.world().motions()[b].linear - before[b].linear) <= 1e-12);
    CHECK(norm(sim.world().motions()[b].angular - before[b].angular) <= 1e-12);
  }
  REQUIRE(sim.run_until(1) == Status::ok);
  unmoved();
}

TEST_CASE("removing a prescribed motion keeps the speed; adding one sets the speed, at the joint's position") {
  Simulation sim(floating(Signal::sine(0.6, 1)), exactly());
  const Totals start = sim.world().totals();
  REQUIRE(sim.run_until(0.3) == Status::ok);
  const std::vector<BodyMotion> before = sim.world().motions();
  JointParameters none;
  none.effort = 0;
  const Event& freed = sim.apply(set_parameters("arm", none));
  CHECK(std::fabs(freed.work) <= 1e-14);
  CHECK_FALSE(sim.world().joint({1}).driven);
  CHECK(std::fabs(sim.world().joint({1}).p[0]) > 0);
  for (std::size_t b = 0; b < 3; ++b) {
    CHECK(norm(sim.world().motions()[b].linear - before[b].linear) <= 1e-13);
    CHECK(norm(sim.world().motions()[b].angular - before[b].angular) <= 1e-13);
  }
  REQUIRE(sim.run_until(0.5) == Status::ok);
  const double stands = sim.world().joint({1}).q[0];
  JointParameters moved;
  moved.drive = motion_drive(Signal(stands + 1e-3));
  CHECK_THROWS_AS(sim.apply(set_parameters("arm", moved)), Error);
  moved.drive = motion_drive(Signal::sine(0.5, 1, std::numbers::pi, stands));  // passes there at 0.5 s, upwards
  const double kinetic = sim.world().totals().kinetic;
  const Event& driven = sim.apply(set_parameters("arm", moved));
  CHECK(driven.work == doctest::Approx(sim.world().totals().kinetic - kinetic));
  CHECK(sim.world().joint({1}).v[0] == doctest::Approx(std::numbers::pi).epsilon(1e-12));
  REQUIRE(sim.run_until(1) == Status::ok);
  const Totals end = sim.world().totals();
  CHECK(norm(end.linear - start.linear) <= 1e-9);
  CHECK(norm(end.angular - start.angular) <= 1e-9);
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
}

TEST_CASE("impacts elsewhere do not change a prescribed motion: the drive's impulse does work") {
  Simulation sim(floating(Signal::sine(0.6, 1)), exactly());
  REQUIRE(sim.run_until(0.2) == Status::ok);
  const double speed = sim.world().joint({1}).v[0];
  const Totals before = sim.world().totals();
  const Event event = sim.apply(lock("hand"));
  const Totals after = sim.world().totals();
  CHECK(sim.world().joint({1}).v[0] == speed);
  CHECK(norm(after.linear - before.linear) <= 1e-12);
  CHECK(norm(after.angular - before.angular) <= 1e-12);
  CHECK(event.lost > 0);
  CHECK(event.work != 0);
  CHECK(after.kinetic - before.kinetic == doctest::Approx(event.work - event.lost - (before.potential - after.potential)));
  sim.apply(impulse("hand", {0.1, 0.2, 0.3}));
  CHECK(sim.world().joint({1}).v[0] == speed);
  REQUIRE(sim.run_until(0.6) == Status::ok);
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
}

TEST_CASE("an impact on a stop next to a prescribed motion: the drive's work is in the energy ledger") {
  Model model({.gravity = {}});
  const BodyId cart = model.add({.name = "cart",
                                 .mass = 1,
                                 .inertia = diagonal(1),
                                 .joint = Prismatic{.axis = x_axis, .drive = motion_drive(Signal::sine(0.2, 1))}});
  model.add({.name = "arm",
             .mass = 1,
             .com = {0, 0.3, 0},
             .inertia = diagonal(0.01),
             .parent = cart,
             .joint = Revolute{.limits = {.lower = -2, .upper = 0.3, .restitution = 0.5}},
             .v = 3.0});
  Simulation sim(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-12});
  REQUIRE(sim.run_until(0.3) == Status::ok);
  REQUIRE(sim.events().size() == 1);
  const Event& hit = sim.events()[0];
  CHECK(hit.work > 0.1);
  CHECK(hit.lost > 0.1);
  CHECK(std::fabs(sim.energy().error) <= 1e-11 * scale(sim));
}

TEST_CASE("a driven joint that changes kind keeps its speed if possible; a capture next to one keeps its motion") {
  Model model = floating(Signal::sine(0.6, 1), 0);
  model.add({.name = "prey",
             .mass = 2,
             .inertia = diagonal(0.3),
             .joint = Free{},
             .q = {3, 0, 0, 1, 0, 0, 0},
             .v = {-1, 0.2, 0, 0.5, 0, 1}});
  Simulation sim(model, exactly());
  const Totals start = sim.world().totals();
  REQUIRE(sim.run_until(0.2) == Status::ok);
  sim.apply(weld("prey", "hand"), "grasp");
  CHECK(sim.world().joint({1}).v[0] == Curve(Signal::sine(0.6, 1)).at(0.2).rate);
  REQUIRE(sim.run_until(0.3) == Status::ok);
  CHECK(sim.world().joint({1}).q[0] == Curve(Signal::sine(0.6, 1)).at(0.3).value);
  const std::vector<BodyMotion> before = sim.world().motions();
  sim.apply(change_joint("arm", Kind::cylindrical));
  CHECK_FALSE(sim.world().joint({1}).driven);
  for (std::size_t b = 0; b < 4; ++b) {
    CHECK(norm(sim.world().motions()[b].linear - before[b].linear) <= 1e-12);
    CHECK(norm(sim.world().motions()[b].angular - before[b].angular) <= 1e-12);
  }
  REQUIRE(sim.run_until(0.5) == Status::ok);
  const Totals end = sim.world().totals();
  CHECK(norm(end.linear - start.linear) <= 1e-9);
  CHECK(norm(end.angular - start.angular) <= 1e-9);
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
}

TEST_CASE("a motion at a constant rate: from the start, from the current position, and after a lock") {
  // A bead on a hoop that rotates at a constant rate: sin θ (ω² cos θ − g/r) = θ̈ has the integral θ̇²/2 − ω² sin²θ/2 − (g/r) cos
  // θ.
  constexpr double g = 9.81, r = 0.5, omega = 7;
  Model model({.gravity = {0, 0, -g}});
  const BodyId hoop = model.add({.name = "hoop",
                                 .mass = 1,
                                 .inertia = diagonal(0.1),
                                 .joint = Revolute{.axis = z_axis, .drive = motion_drive(Signal::ramp_from_here(omega))},
                                 .q = 0.4});
  model.add({.name = "bead", .mass = 0.3, .com = {0, 0, -r}, .parent = hoop, .joint = Revolute{.axis = y_axis}, .q = 0.2});
  Simulation sim(model, exactly());
  const auto integral = [&] {
    const double angle = sim.world().joint({1}).q[0], rate = sim.world().joint({1}).v[0], s = std::sin(angle);
    return rate * rate / 2 - omega * omega * s * s / 2 - g / r * std::cos(angle);
  };
  CHECK(sim.world().joint({0}).q[0] == 0.4);
  CHECK(sim.world().joint({0}).v[0] == omega);
  const double start = integral();
  REQUIRE(sim.run_until(2) == Status::ok);
  CHECK(integral() == doctest::Approx(start).epsilon(1e-8));
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(0.4 + 2 * omega).epsilon(1e-14));
  CHECK(std::fabs(sim.energy().error) <= 1e-8 * scale(sim));

  sim.apply(lock("hoop"));
  const double stands = sim.world().joint({0}).q[0];
  REQUIRE(sim.run_until(2.3) == Status::ok);
  sim.apply(unlock("hoop"));  // continues from there
  REQUIRE(sim.run_until(2.5) == Status::ok);
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(stands + 0.2 * omega).epsilon(1e-13));
  JointParameters back;
  back.drive = motion_drive(Signal::ramp_from_here(-1));
  sim.apply(set_parameters("hoop", back));
  REQUIRE(sim.run_until(3) == Status::ok);
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(stands + 0.2 * omega - 0.5).epsilon(1e-13));
  CHECK(std::fabs(sim.energy().error) <= 1e-8 * scale(sim));
}

TEST_CASE("a dry run does not judge motions by the joint positions before the run") {
  Simulation sim(floating(Signal::sine(0.6, 1)), exactly());
  JointParameters moved, none;
  none.effort = 0;
  moved.drive = motion_drive(Signal(5));
  sim.at(0.1).then(set_parameters("arm", none));
  sim.at(0.2).then(set_parameters("arm", moved));
  const std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end());
  CHECK(sim.dry_run().issues.empty());
  CHECK(q == std::vector<double>(sim.world().state().q().begin(), sim.world().state().q().end()));
  CHECK(sim.run_until(1) == Status::refused);
  CHECK(sim.result().reason.find("its motion is at 5 now") != std::string::npos);
  CHECK(sim.time() == 0.2);
}

TEST_CASE("snapshots, branches and state documents keep motions") {
  Simulation sim(floating(Signal::table({{0.05, 0}, {0.4, 0.5}, {0.8, -0.2}})), {.method = "rk4", .step = 2e-3});
  REQUIRE(sim.run_until(0.3) == Status::ok);
  const SimulationSnapshot there = sim.snapshot();
  Simulation other = sim.branch();
  REQUIRE(sim.run_until(1) == Status::ok);
  const std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end());
  REQUIRE(other.run_until(1) == Status::ok);
  CHECK(q == std::vector<double>(other.world().state().q().begin(), other.world().state().q().end()));
  sim.restore(there);
  REQUIRE(sim.run_until(1) == Status::ok);
  CHECK(q == std::vector<double>(sim.world().state().q().begin(), sim.world().state().q().end()));
  other.restore(0.4, {}, {});
  CHECK(other.world().joint({1}).q[0] == 0.5);
}

TEST_CASE("a body with a prescribed motion is added and removed") {
  Simulation sim(floating(Signal::sine(0.6, 1)), exactly());
  REQUIRE(sim.run_until(0.2) == Status::ok);
  const std::vector<BodyMotion> before = sim.world().motions();
  const Signal turn = Signal::sine(1, 0.5, 0.2);
  const BodyId added = sim.add({.name = "fan",
                                .mass = 0.3,
                                .com = {0.1, 0, 0},
                                .inertia = diagonal(0.02),
                                .parent = {2},
                                .at = {0, 0, 0.3},
                                .joint = Revolute{.drive = motion_drive(turn)}});
  CHECK(sim.world().joint({added.index}).q[0] == Curve(turn).at(0.2).value);
  CHECK(sim.world().joint({added.index}).v[0] == doctest::Approx(Curve(turn).at(0.2).rate));
  for (std::size_t b = 0; b < 3; ++b) CHECK(norm(sim.world().motions()[b].angular - before[b].angular) <= 1e-12);
  REQUIRE(sim.run_until(0.7) == Status::ok);
  CHECK(sim.world().joint({added.index}).q[0] == Curve(turn).at(0.7).value);
  CHECK(std::fabs(sim.energy().error) <= 1e-9 * scale(sim));
  sim.remove(added);
  REQUIRE(sim.run_until(1) == Status::ok);
  CHECK(sim.world().joint({1}).q[0] == Curve(Signal::sine(0.6, 1)).at(1).value);
}

TEST_CASE("a joint that changes kind may move at a constant rate from its position") {
  Model model({.gravity = {}});
  model.add({.name = "hoop", .mass = 1, .inertia = diagonal(0.1), .joint = Revolute{.axis = {0, 0, 1}}, .q = 0.3});
  Simulation sim(model);
  REQUIRE(sim.run_until(0.5) == Status::ok);
  const JointSpec slide = Prismatic{.axis = {0, 0, 1}, .drive = motion_drive(Signal::ramp_from_here(2))};
  sim.apply(change_joint("hoop", slide));
  REQUIRE(sim.run_until(1) == Status::ok);
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(1).epsilon(1e-12));
  CHECK(sim.world().joint({0}).v[0] == 2);
}
