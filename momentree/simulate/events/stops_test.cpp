// Hard stops: the instants of impacts, the velocities after them, how bouncing ends, and that a stop pushes and never pulls.
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81;

// A body that falls along z onto a stop 0.5 m below and rebounds with restitution e.
Model falling(double e) {
  Model model;
  model.add(
      {.name = "ball", .mass = 2, .inertia = diagonal(0.1), .joint = Prismatic{.limits = {.lower = -0.5, .restitution = e}}});
  return model;
}

std::vector<const Event*> of(const Simulation& sim, const char* what) {
  std::vector<const Event*> found;
  for (const Event& e : sim.events())
    if (!e.actions.empty() && e.actions[0].text().find(what) == 0) found.push_back(&e);
  return found;
}

}  // namespace

TEST_CASE("a ball bounces at the instants and with the speeds of the closed form, and comes to rest") {
  for (const double step : {1e-3, 0.02}) {
    const double e = 0.6;
    Simulation sim(falling(e), {.step = step});
    REQUIRE(sim.run_until(3) == Status::ok);
    const auto hits = of(sim, "hit ball lower");
    REQUIRE(hits.size() > 10);
    double t = std::sqrt(2 * 0.5 / g), v = g * t;
    for (const Event* hit : hits) {
      CHECK(std::fabs(hit->time - t) < 2e-9);  // errors of the instants, 1e-10 s each, add up
      CHECK(hit->lost == doctest::Approx((1 - e * e) * 0.5 * 2 * v * v).epsilon(1e-6));
      CHECK(hit->ground_impulse[2] == doctest::Approx((1 + e) * 2 * v).epsilon(1e-6));
      v *= e;
      t += 2 * v / g;
    }
    CHECK(v < 1.1e-3);  // the last speeds are below the rest speed
    const auto rests = of(sim, "rest ball lower");
    REQUIRE(rests.size() == 1);
    CHECK(rests[0]->time < 3);
    const JointView joint = sim.world().joint({0});
    CHECK(joint.q[0] == doctest::Approx(-0.5).epsilon(1e-9));
    CHECK(joint.v[0] == 0);
    CHECK(joint.locked == 0);
    CHECK(joint.resting == 1);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("elastic stops lose no energy; bounces shorter than a step are all detected") {
  Simulation sim(falling(1), {.step = 0.05});
  REQUIRE(sim.run_until(2) == Status::ok);
  CHECK(of(sim, "hit").size() == 3);  // at 0.319 s, then every 0.639 s
  CHECK(std::fabs(sim.energy().lost_in_impacts) < 1e-12);
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  // A box of 2 cm, crossed in a fraction of a step.
  Model model({.gravity = {}});
  model.add({.name = "ball",
             .mass = 1,
             .inertia = diagonal(1),
             .joint = Prismatic{.limits = {.lower = -0.01, .upper = 0.01, .restitution = 1}},
             .v = 1.0});
  Simulation box(model, {.step = 0.5});
  REQUIRE(box.run_until(1.0) == Status::ok);
  CHECK(of(box, "hit").size() == 50);  // at 0.01, 0.03 … 0.99 s
  CHECK(std::fabs(box.world().joint({0}).q[0]) < 1e-8);
}

TEST_CASE("a joint that exceeds its limit and returns within one step hits its stop") {
  Model model({.gravity = {0, 0, -g}});
  const double v = 1.0, top = v * v / (2 * g);
  model.add({.name = "ball",
             .mass = 1,
             .inertia = diagonal(1),
             .joint = Prismatic{.limits = {.upper = 0.99 * top, .restitution = 0.5}},
             .v = v});
  Simulation sim(model, {.step = 2 * v / g});  // up and down again in one step
  REQUIRE(sim.run_until(2 * v / g) == Status::ok);
  REQUIRE(of(sim, "hit ball upper").size() == 1);
  CHECK(of(sim, "hit")[0]->time == doctest::Approx(v / g * (1 - std::sqrt(0.01))).epsilon(1e-8));
}

TEST_CASE("bouncing ends, whatever the load, the mass, the restitution, the rest speed and where the stop is") {
  std::mt19937_64 random(5);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int k = 0; k < 200; ++k) {
    const double a = std::pow(10, between(-2, 7)), mass = std::pow(10, between(-6, 3)), e = between(0, 0.95);
    const double limit = k % 4 == 0 ? 0 : -std::pow(10, between(-3, 3)), height = std::pow(10, between(-4, 0));
    CAPTURE(a);
    CAPTURE(mass);
    CAPTURE(e);
    CAPTURE(limit);
    CAPTURE(height);
    Model model({.gravity = {0, 0, -a}});
    model.add({.name = "ball",
               .mass = mass,
               .inertia = diagonal(mass),
               .joint = Prismatic{.limits = {.lower = limit, .restitution = e, .rest_speed = 1e-12}},
               .q = limit + height});
    const double fall = std::sqrt(2 * height / a), end = fall * (1 + 2 * e / (1 - e));  // the limit of infinitely many bounces
    Simulation sim(model, {.method = k % 2 == 0 ? "rk4" : "dopri5", .step = fall / 8, .rtol = 1e-9, .atol = 1e-12});
    const Status status = sim.run_until(1.01 * end);
    CAPTURE(sim.result().reason);
    REQUIRE(status == Status::ok);
    const auto rests = of(sim, "rest ball lower");
    REQUIRE(rests.size() == 1);
    const double slowest = std::max(8e-10 * a, std::sqrt(2e-14 * a * (1 + std::fabs(limit))));  // the lowest speeds not hidden by
                                                                                                // rounding
    CHECK(std::fabs(rests[0]->time - end) < 1e-9 + 1e-6 * end + 3 * slowest / a / (1 - e));
    CHECK(sim.world().joint({0}).q[0] == limit);
    CHECK(sim.events().size() < 1000);
    CHECK(std::fabs(sim.energy().error) < 1e-5 * mass * a * height);
  }
}

TEST_CASE("a stop releases its joint at the instant at which it would have to pull") {
  // A cart on a spring, and a slider on it along the same track with a stop that keeps it from falling behind the cart. The stop
  // can push the slider while the cart accelerates forwards: until the spring is unstressed.
  Model model({.gravity = {}});
  const BodyId cart = model.add({.name = "cart",
                                 .mass = 1,
                                 .inertia = diagonal(1),
                                 .joint = Prismatic{.axis = {1, 0, 0}, .stiffness = 4},
                                 .q = 1.0,
                                 .joint_name = "track"});
  model.add({.name = "slider",
             .mass = 0.5,
             .inertia = diagonal(1),
             .parent = cart,
             .joint = Prismatic{.axis = {1, 0, 0}, .limits = {.lower = 0, .restitution = 0}},
             .v = -2.0});  // immediately onto the cart's stop; it leaves, and meets the slider again on its way back
  Simulation sim(model, {.step = 1e-3});
  REQUIRE(sim.run_until(6) == Status::ok);
  const auto leaves = of(sim, "leave slider lower");
  REQUIRE(leaves.size() >= 1);
  for (const Event* e : leaves) {
    CHECK(e->before.potential < 1e-16);  // of the spring: 2 (q/m)² J
    CHECK(std::fabs(e->lost) < 1e-12);
  }
  CHECK(std::fabs(sim.energy().error) < 1e-8);
}

TEST_CASE("a joint that rests on a stop leaves at once when its drive reverses the load") {
  Model model;  // a lid that its weight keeps closed
  model.add({.name = "lid",
             .mass = 1,
             .com = {0.5, 0, 0},
             .inertia = diagonal(0.1),
             .joint = Revolute{.axis = {0, -1, 0}, .limits = {.lower = 0, .upper = 1.2, .restitution = 0.3}}});
  Simulation sim(model, {.step = 1e-3});
  sim.at(0.5).then(set_parameters("lid", {.effort = 0.5 * g + 1}));
  REQUIRE(sim.run_until(0.4) == Status::ok);
  CHECK(sim.world().joint({0}).resting == 1);
  CHECK(sim.world().joint({0}).q[0] == 0);
  REQUIRE(sim.run_until(0.6) == Status::ok);
  REQUIRE(of(sim, "leave lid lower").size() == 1);
  CHECK(of(sim, "leave lid lower")[0]->time == 0.5);
  CHECK(sim.world().joint({0}).q[0] > 1e-3);
  REQUIRE(sim.run_until(20) == Status::ok);
  CHECK(of(sim, "hit lid upper").size() > 3);
  CHECK(sim.world().joint({0}).resting == 1);
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(1.2).epsilon(1e-9));
  CHECK(std::fabs(sim.energy().error) < 1e-7);
}

TEST_CASE("an impact elsewhere does not pull on a stop") {
  // A load lies on a lift. A blow from below takes the load along; one from above leaves it behind.
  Model model;
  const BodyId lift =
      model.add({.name = "lift", .mass = 3, .inertia = diagonal(1), .joint = Prismatic{.damping = 1, .effort = 4 * g}});
  model.add({.name = "load",
             .mass = 1,
             .inertia = diagonal(1),
             .parent = lift,
             .joint = Prismatic{.limits = {.lower = 0, .restitution = 0}}});
  Simulation down(model), up(model);
  for (Simulation* sim : {&down, &up}) {
    REQUIRE(sim->run_until(0.1) == Status::ok);
    REQUIRE(sim->world().joint({1}).resting == 1);
  }
  up.apply(impulse("lift", {0, 0, 4}));
  CHECK(up.world().motions()[0].linear.z == doctest::Approx(1));  // 4 N s on 4 kg: it takes the load along
  CHECK(up.world().motions()[1].linear.z == doctest::Approx(1));
  down.apply(impulse("lift", {0, 0, -3}));
  CHECK(down.world().motions()[0].linear.z == doctest::Approx(-1));  // −3 N s on 3 kg: the load stays behind
  CHECK(down.world().motions()[1].linear.z == doctest::Approx(0));
  CHECK(down.world().joint({1}).resting == 0);
  CHECK(of(down, "leave").size() == 1);
  CHECK(of(up, "leave").empty());
}

TEST_CASE("an impact that pulls joints off several stops ends") {
  // A chain folds up: its joints come to rest on their stops one after the other; two of them are pulled by springs between
  // joints.
  Model model({.gravity = {0, 0, -g}});
  const Vec3 axis = normalized(Vec3{0.187, -0.589, 0.435});
  BodyId parent = ground;
  for (int k = 0; k < 5; ++k)
    parent = model.add({.name = std::to_string(k + 1),
                        .mass = 0.5,
                        .com = {0.0785, 0, 0},
                        .inertia = diagonal(1e-3),
                        .parent = parent,
                        .at = Pose{{k > 0 ? 0.157 : 0.0, 0, 0}},
                        .joint = Revolute{.axis = axis, .damping = 0.2, .limits = {.lower = -0.34, .restitution = 0}},
                        .q = 0.0794});
  Simulation sim(model, {.step = 4e-3});
  const auto spring = [&sim](int joint, int leader, double multiplier, double offset, double stiffness, double damping) {
    const auto effort = [=](const EvaluationContext& m) {
      return -stiffness * (m.q({joint})[0] - multiplier * m.q({leader})[0] - offset) -
             damping * (m.v({joint})[0] - multiplier * m.v({leader})[0]);
    };
    sim.drive(std::to_string(joint + 1), effort);
    sim.drive(std::to_string(leader + 1), [=](const EvaluationContext& m) { return -multiplier * effort(m); });
  };
  spring(1, 0, -1.24, 0.905, 1, 0.03);
  spring(3, 2, 1, 0.876, 3, 0.2);
  REQUIRE(sim.run_until(1) == Status::ok);
  CHECK(of(sim, "rest").size() + of(sim, "hit").size() > 2);  // with steps too long to be accurate: the run must still end
}

TEST_CASE("stops belong to the joint: a re-rooted mechanism bounces and rests as before") {
  Model model({.gravity = {}});
  const BodyId hull =
      model.add({.name = "hull", .mass = 3, .com = {0.1, 0, 0}, .inertia = diagonal(0.2, 0.3, 0.4), .joint = Free{}});
  const BodyId arm =
      model.add({.name = "arm",
                 .mass = 1,
                 .com = {0.4, 0, 0.05},
                 .inertia = diagonal(0.01, 0.06, 0.06),
                 .parent = hull,
                 .at = {0.3, 0, 0},
                 .joint = Revolute{.axis = {0, 1, 0}, .stiffness = 2, .rest = 1, .limits = {.lower = -0.5, .upper = 0.4}},
                 .v = 2.0});
  model.add({.name = "slide",
             .mass = 0.5,
             .inertia = diagonal(0.01),
             .parent = arm,
             .at = {0.8, 0, 0},
             .joint = Prismatic{.axis = {1, 0, 0}, .limits = {.lower = -0.1, .upper = 0.1, .restitution = 0.7}},
             .v = -0.3});
  Simulation as_declared(model), turned(model);
  turned.apply(reroot("slide"));
  REQUIRE(turned.world().joint({1}).reversed);
  REQUIRE(as_declared.run_until(1.5) == Status::ok);
  REQUIRE(turned.run_until(1.5) == Status::ok);
  REQUIRE(as_declared.events().size() + 1 == turned.events().size());
  CHECK(as_declared.events().size() > 3);
  for (std::size_t i = 0; i < as_declared.events().size(); ++i) {
    const Event &one = as_declared.events()[i], &other = turned.events()[i + 1];
    CHECK(one.actions == other.actions);
    CHECK(std::fabs(one.time - other.time) < 1e-8);
    CHECK(one.lost == doctest::Approx(other.lost).epsilon(1e-6));
    CHECK(norm(one.after.linear - one.before.linear) < 1e-12);
  }
  for (std::size_t b = 0; b < 3; ++b)
    CHECK(norm(as_declared.world().motions()[b].linear - turned.world().motions()[b].linear) < 1e-7);
  CHECK(as_declared.world().joint({1}).resting == turned.world().joint({1}).resting);
  CHECK(as_declared.world().joint({1}).resting == 1);  // its spring keeps it there
}

TEST_CASE("snapshots contain active limits; locks and unlocks override them") {
  Simulation sim(falling(0.2));
  REQUIRE(sim.run_until(2) == Status::ok);
  REQUIRE(sim.world().joint({0}).resting == 1);
  Simulation branch = sim.branch();
  CHECK(branch.world().joint({0}).resting == 1);
  CHECK(branch.world().joint({0}).locked == 0);
  sim.apply(lock("ball"));
  CHECK(sim.world().joint({0}).locked == 1);
  CHECK(sim.world().joint({0}).resting == 0);
  sim.apply(unlock("ball"));
  CHECK(sim.world().joint({0}).locked == 0);
  CHECK(sim.world().joint({0}).resting == 1);  // at once
  CHECK(sim.apply(unlock("ball")).actions[0].text().find("skipped") != std::string::npos);
}

TEST_CASE("a joint no longer rests on a stop that is moved, made soft or taken away") {
  constexpr double m = 2, start = 1.25, fall = 0.3, k = 400;
  for (const bool loop : {false, true}) {
    const auto resting = [loop](const JointLimits& limits) {
      const Prismatic slide{.limits = {.lower = -0.5}};
      Model model;
      BodySpec ball{.name = "ball", .mass = m, .inertia = diagonal(0.1), .joint = slide, .q = -0.5};
      if (loop) ball.joint = Free{}, ball.q = {0, 0, -0.5, 1, 0, 0, 0};
      const BodyId body = model.add(ball);
      if (loop) model.add_loop({.name = "slide", .body = body, .joint = slide});
      Simulation sim(model, {.method = "rk4", .step = 1e-3});
      sim.at(start).then(set_parameters(loop ? "slide" : "ball", {.limits = limits}));
      REQUIRE(sim.run_until(start));
      return sim;
    };
    const auto height = [](const Simulation& sim) { return sim.world().motions()[0].pose.position.z; };
    const auto below = [](double t) { return -0.5 - 0.5 * g * t * t; };
    Simulation lower = resting({.lower = -0.5 - fall});
    REQUIRE(lower.run_until(start + 0.1));
    CHECK(height(lower) == doctest::Approx(below(0.1)).epsilon(1e-10));
    REQUIRE(lower.run_until(start + 0.5));
    const auto hits = of(lower, "hit");
    REQUIRE(!hits.empty());
    CHECK(hits.back()->time == doctest::Approx(start + std::sqrt(2 * fall / g)).epsilon(1e-8));
    CHECK(height(lower) == doctest::Approx(-0.5 - fall).epsilon(1e-9));
    Simulation soft = resting({.lower = -0.5, .stiffness = k});
    REQUIRE(soft.run_until(start + 0.1));
    CHECK(height(soft) == doctest::Approx(-0.5 - m * g / k * (1 - std::cos(std::sqrt(k / m) * 0.1))).epsilon(1e-8));
    Simulation gone = resting({.upper = 1});
    REQUIRE(gone.run_until(start + 0.1));
    CHECK(height(gone) == doctest::Approx(below(0.1)).epsilon(1e-10));
    Simulation same = resting({.lower = -0.5, .upper = 1, .restitution = 0.5});
    const std::size_t events = same.events().size();
    REQUIRE(same.run_until(start + 0.1));
    CHECK(height(same) == doctest::Approx(-0.5).epsilon(1e-12));
    CHECK(same.events().size() == events);
    for (const Simulation* sim : {&lower, &soft, &gone, &same}) CHECK(std::fabs(sim->energy().error) < 1e-8);
  }
}

TEST_CASE("impossible limits are errors") {
  const auto message = [](JointSpec joint, Values q = {}) {
    Model model;
    try {
      model.add({.name = "b", .mass = 1, .inertia = diagonal(1), .joint = std::move(joint), .q = q});
    } catch (const Error& e) {
      return e.message();
    }
    return std::string();
  };
  CHECK(message(Revolute{.limits = {.lower = 1, .upper = -1}}).find("'lower' must be less") != std::string::npos);
  CHECK(message(Revolute{.limits = {.lower = -1, .upper = 1}}, 2.0).find("beyond its limits") != std::string::npos);
  CHECK(message(Revolute{.limits = {.lower = -1, .restitution = 1.5}}).find("create energy") != std::string::npos);
  CHECK(message(Cylindrical{.limits = {.lower = {-1, 2, 3}}}).find("2 degrees of freedom") != std::string::npos);
  JointSpec ball = Ball{};
  ball.parameters.limits.upper = 1;
  CHECK(message(ball).find("limited") != std::string::npos);
}

TEST_CASE("a stop is located well within steps that are shorter than the event tolerance") {
  Model model({.gravity = {0, 0, -1e20}});
  model.add({.name = "ball",
             .mass = 1,
             .inertia = diagonal(0.1),
             .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.lower = 0, .restitution = 0.9}},
             .q = 0.5});
  Simulation sim(model, {.step = 7e-12});
  REQUIRE(sim.run_until(1.2e-9) == Status::ok);
  CHECK(of(sim, "hit ball lower").size() >= 5);
  CHECK(of(sim, "rest ball lower").empty());
  CHECK(sim.world().joint({0}).q[0] >= 0);
  CHECK(std::fabs(sim.energy().error) < 1e-6 * sim.energy().largest_kinetic);
}

TEST_CASE("a stop with nearly no force does not alternate between rest and release without end") {
  Model model({.gravity = {}});
  const BodyId hull = model.add(
      {.name = "hull", .mass = 2, .com = {0.175, 0.295, -0.256}, .inertia = diagonal(0.096, 0.112, 0.096), .joint = Free{}});
  Planar joint;
  joint.limits.lower = -0.873;
  joint.limits.upper = {0.579, 0.953, 0.528};
  model.add({.name = "rod",
             .mass = 3,
             .com = {0.254, -0.0605, -0.238},
             .inertia = diagonal(0, 0.0675, 0.0675),
             .parent = hull,
             .joint = joint,
             .q = {-0.222, -0.254, 0.146},
             .v = {-0.765, -0.981, 0.919}});
  Simulation sim(model, {.method = "damped", .step = 4e-3});
  long steps = 0;
  sim.watch([&steps](double) { return ++steps < 2000; });
  CHECK(sim.run_until(1) == Status::ok);
  CHECK(of(sim, "hit rod [2] upper").size() >= 1);
  CHECK(of(sim, "leave").size() < 20);
}

// The upper stop is set where the slider is, just before its inner dead centre: the slider may go on, but not come back from
// there, where no force along it holds the crank.
TEST_CASE("a stop at a turning point of a loop brings the crank to rest, with few events") {
  constexpr double r = 0.3, l = 0.7, q0 = 2;
  for (const char* method : {"rk4", "midpoint"})
    for (const double torque : {0.0, 5.0}) {
      CAPTURE(method);
      CAPTURE(torque);
      Model model({.gravity = {}});
      const BodyId crank = model.add({.name = "crank",
                                      .mass = 1,
                                      .com = {r / 2, 0, 0},
                                      .inertia = diagonal(0.01),
                                      .joint = Revolute{.axis = {0, 0, 1}},
                                      .q = q0,
                                      .v = 2.0});
      const double turn = std::asin(r / l * std::sin(q0));
      const BodyId rod = model.add({.name = "rod",
                                    .mass = 1,
                                    .com = {l / 2, 0, 0},
                                    .inertia = diagonal(0.02),
                                    .parent = crank,
                                    .at = {{r, 0, 0}, {}},
                                    .joint = Revolute{.axis = {0, 0, 1}},
                                    .q = -turn - q0});
      const BodyId slider = model.add({.name = "slider",
                                       .mass = 0.5,
                                       .inertia = diagonal(1e-3),
                                       .joint = Prismatic{.axis = {1, 0, 0}},
                                       .q = r * std::cos(q0) + l * std::cos(turn)});
      model.add_loop(
          {.name = "pin", .body = rod, .to = slider, .joint = Revolute{.axis = {0, 0, 1}}, .child_at = {{l, 0, 0}, {}}});
      Simulation sim(model, {.method = method, .step = 1e-4});
      sim.drive("crank", [torque](const EvaluationContext&) { return torque; });
      JointParameters stop;
      stop.limits.upper = l - r;
      sim.when(position_of("crank").exceeds(std::acos(-1.0) - 1e-3)).then(set_parameters("slider", stop));
      REQUIRE(sim.run_until(1.2) == Status::ok);
      CHECK(sim.events().size() < 50);
      const EnergyBalance energy = sim.energy();
      CHECK(sim.world().joint({0}).q[0] == doctest::Approx(std::acos(-1.0)).epsilon(2e-4));
      CHECK(sim.world().joint({2}).q[0] - (l - r) < 1e-7);
      CHECK(std::fabs(sim.world().joint({0}).v[0]) < 1e-6);
      CHECK(energy.lost_in_impacts == doctest::Approx(energy.initial + energy.work).epsilon(1e-5));
    }
}

TEST_CASE("a joint that loops make follow a prescribed motion into its stop ends the run, which names both") {
  for (const auto& [method, rest_speed] : {std::pair{"rk4", 0.01}, {"dop853", 0.01}, {"rk4", 1}, {"dop853", 1}}) {
    CAPTURE(method);
    CAPTURE(rest_speed);
    Model model({.gravity = {}});
    BodySpec one{.name = "one", .mass = 1, .inertia = diagonal(0.01), .joint = Prismatic{.axis = {1, 0, 0}}}, other = one;
    one.joint.parameters.drive = motion_drive(Signal::ramp(0.5, 0));
    other.name = "other";
    other.joint.parameters.limits.upper = {0.2}, other.joint.parameters.limits.rest_speed = rest_speed;
    const BodyId a = model.add(one), b = model.add(other);
    model.add_loop({.name = "rod", .body = a, .to = b, .joint = Ball{}});
    Simulation sim(model, {.method = method, .step = 1e-3});
    const RunResult run = sim.run_until(1);
    CHECK(run.status == Status::stalled);
    CHECK(run.reason.find("no progress at t = 0.4 s: joint 'other' can't be stopped at its limit") == 0);
    CHECK(run.reason.find("the motion of 'one' is prescribed") != std::string::npos);
    CHECK(sim.events().empty());
  }
}
