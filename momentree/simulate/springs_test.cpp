// Springs between two points of bodies. (Random mechanisms against an independent oracle: tests/oracle/springs_test.cpp.)
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/forces/springs.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/stiffness.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

BodySpec slider(std::string name, double mass, double at, double speed = 0) {
  return {
      .name = std::move(name), .mass = mass, .inertia = diagonal(1), .joint = Prismatic{.axis = {1, 0, 0}}, .q = at, .v = speed};
}

// A mass below the ceiling, along z.
BodySpec hanging(double mass, double height, double speed = 0) {
  return {.name = "m/a", .mass = mass, .inertia = diagonal(1), .joint = Prismatic{.axis = {0, 0, 1}}, .q = height, .v = speed};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Integration precise(Variables variables) {
  return {.method = "dop853", .variables = variables, .step = 1e-3, .rtol = 1e-12, .atol = 1e-13};
}

// Two masses that slide along x, on a spring between points of them.
Model pair_of_masses(double damping = 0) {
  Model model({.gravity = {}});
  const BodyId a = model.add(slider("m/a", 2, 0, 0.5)), b = model.add(slider("n/b", 3, 2));
  model.add_spring(
      {.name = "rod", .from = {a, {0.25, 0, 0}}, .to = {b, {-0.25, 0, 0}}, .stiffness = 40, .rest = 1.2, .damping = damping});
  return model;
}

}  // namespace

TEST_CASE("two masses on a spring: the closed form, undamped and damped, in momenta and in velocities") {
  const double m = 2 * 3 / 5.0, k = 40;
  for (const Variables variables : {Variables::momenta, Variables::velocities})
    for (const double c : {0.0, 3.0}) {
      Simulation sim(pair_of_masses(c), precise(variables));
      // x = length − rest obeys m x″ + c x′ + k x = 0 with the reduced mass m.
      const double decay = c / (2 * m), w = std::sqrt(k / m - decay * decay), x0 = 0.3, v0 = -0.5;
      for (const double t : {0.2, 0.7, 1.9}) {
        REQUIRE(sim.run_until(t));
        const double B = (v0 + decay * x0) / w, e = std::exp(-decay * t);
        const double x = e * (x0 * std::cos(w * t) + B * std::sin(w * t));
        const double rate = e * (w * (B * std::cos(w * t) - x0 * std::sin(w * t))) - decay * x;
        const SpringView spring = sim.world().spring({0});
        CHECK(spring.length == doctest::Approx(1.2 + x).epsilon(1e-10));
        CHECK(spring.rate == doctest::Approx(rate).epsilon(1e-9));
        CHECK(spring.tension == doctest::Approx(k * x + c * rate).epsilon(1e-9));
        CHECK(norm(spring.place_of_to - spring.place_of_from) == spring.length);
        CHECK(sim.world().totals().linear.x == doctest::Approx(2 * 0.5).epsilon(1e-14));
        CHECK(sim.world().totals().potential == doctest::Approx(0.5 * k * x * x).epsilon(1e-9));
        CHECK(std::fabs(sim.energy().error) < 1e-10);
        if (c == 0) CHECK(sim.energy().dissipated == 0);
        if (c > 0) CHECK(sim.energy().dissipated > 0.1);
      }
    }
}

TEST_CASE("a mass bounces on a cord that only pulls: free flight, then half of a harmonic motion, with that period") {
  const double g = 9.81, L = 1, k = 500, m = 2, w = std::sqrt(k / m);
  for (const Variables variables : {Variables::momenta, Variables::velocities}) {
    Model model({.gravity = {0, 0, -g}});
    const BodyId a = model.add(hanging(m, -0.4));
    model.add_spring({.name = "cord", .from = {ground, {}}, .to = {a, {}}, .stiffness = k, .rest = L, .tension_only = true});
    Simulation sim(model, precise(variables));
    const double fall = std::sqrt(2 * 0.6 / g), v = g * fall, sag = m * g / k;
    // While it is taut, its depth is L + sag + A cos(w t + phase), from −sag and v to −sag and −v.
    const double amplitude = std::hypot(sag, v / w), taut = 2 * (std::numbers::pi - std::atan2(v / w, sag)) / w;
    REQUIRE(sim.run_until(fall - 1e-6));
    CHECK(sim.world().spring({0}).tension == 0);
    REQUIRE(sim.run_until(fall + taut / 2));  // lowest
    CHECK(sim.world().state().q()[0] == doctest::Approx(-(L + sag + amplitude)).epsilon(1e-8));
    CHECK(sim.world().spring({0}).tension == doctest::Approx(k * (sag + amplitude)).epsilon(1e-8));
    REQUIRE(sim.run_until(3 * (2 * fall + taut)));  // after three periods
    CHECK(sim.world().state().q()[0] == doctest::Approx(-0.4).epsilon(1e-7));
    CHECK(std::fabs(sim.world().v()[0]) < 1e-5);
    CHECK(std::fabs(sim.energy().error) < 1e-7);
    CHECK(sim.energy().dissipated == 0);
  }
}

TEST_CASE("the law of a spring: a cord never pushes, with its damper neither, and dissipation is never negative") {
  const SpringLaw both{.stiffness = 10, .rest = 1, .damping = 4},
      cord{.stiffness = 10, .rest = 1, .damping = 4, .tension_only = true};
  CHECK(both.tension(1.5, -2) == doctest::Approx(-3));
  CHECK(cord.tension(1.5, -2) == 0);
  CHECK(cord.tension(1.5, 2) == doctest::Approx(13));
  CHECK(both.tension(0.5, 2) == doctest::Approx(3));
  CHECK(cord.tension(0.5, 2) == 0);  // slack: the damper does not act either
  CHECK(cord.tension(1, 2) == 0);
  CHECK(cord.energy(0.5) == 0);
  CHECK(both.energy(0.5) == doctest::Approx(1.25));
  CHECK(cord.dissipated(1.5, -2) == doctest::Approx(10));  // the cord goes slack: what it stored is lost
  for (double length = 0; length < 2; length += 0.1)
    for (double rate = -3; rate < 3; rate += 0.1) {
      CHECK(both.dissipated(length, rate) >= -1e-15);
      CHECK(cord.dissipated(length, rate) >= -1e-15);
      CHECK(cord.tension(length, rate) >= 0);
    }
}

TEST_CASE("ends that coincide: no direction, no force, no NaN") {
  Model model({.gravity = {}});
  const BodyId a = model.add({.name = "m/a", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
  model.add_spring({.name = "s", .from = {ground, {}}, .to = {a, {}}, .stiffness = 10, .rest = 0.5, .damping = 1});
  for (const Variables variables : {Variables::momenta, Variables::velocities}) {
    Simulation sim(model, precise(variables));
    CHECK(sim.world().spring({0}).tension == 0);
    CHECK(sim.world().spring({0}).length == 0);
    REQUIRE(sim.run_until(0.1));
    for (const double x : sim.world().state().q()) CHECK(std::isfinite(x));
    CHECK(sim.world().state().q()[0] == 0);
    sim.apply(impulse("m/a", {1, 0, 0}));
    REQUIRE(sim.run_until(2));  // it swings through the point again and again
    for (const double x : sim.world().state().q()) CHECK(std::isfinite(x));
  }
}

TEST_CASE("without a rest length a spring is relaxed at the start, also with prescribed motions and placements") {
  Model model({.gravity = {}});
  const BodyId a = model.add({.name = "m/a",
                              .mass = 1,
                              .inertia = diagonal(1),
                              .at = {{1, 2, 3}, {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}},
                              .joint = Revolute{.axis = {0, 1, 1}},
                              .q = 0.3,
                              .child_at = {{0.1, 0, 0.2}, {std::sqrt(0.5), std::sqrt(0.5), 0, 0}}});
  const BodyId b = model.add({.name = "m/b",
                              .mass = 1,
                              .inertia = diagonal(1),
                              .parent = a,
                              .at = {{0, 0, 1}, {}},
                              .joint = Prismatic{.axis = {1, 0, 0}, .drive = motion_drive(Signal::sine(0.2, 1, 0.4, 0.7))}});
  model.add_spring({.name = "s", .from = {ground, {1, 0, 0}}, .to = {b, {0.3, 0.4, 0.5}}, .stiffness = 10});
  Simulation sim(model);
  const SpringView spring = sim.world().spring({0});
  CHECK(spring.length == doctest::Approx(spring.law.rest).epsilon(1e-14));
  CHECK(spring.length > 1);
  CHECK(*model.springs()[0].rest == spring.law.rest);
  CHECK(std::fabs(spring.tension) < 1e-12);
}

TEST_CASE("a spring breaks by an event: momentum stays to the bit, its energy is released, and only then is it gone") {
  for (const Variables variables : {Variables::momenta, Variables::velocities}) {
    Simulation sim(pair_of_masses(), precise(variables));
    sim.at(0.3).then(break_spring("rod"));
    REQUIRE(sim.run_until(1));
    REQUIRE(sim.events().size() == 1);
    const Event& event = sim.events()[0];
    CHECK(event.before.linear == event.after.linear);
    CHECK(event.before.angular == event.after.angular);
    CHECK(event.before.kinetic == event.after.kinetic);
    CHECK(event.released == event.before.potential);
    CHECK(event.released > 0.01);
    CHECK(event.after.potential == 0);
    CHECK(event.lost == 0);
    CHECK(event.work == 0);
    CHECK(event.impulse.empty());
    CHECK(event.topology.broken_springs == std::vector<std::string>{"rod"});
    CHECK(event.topology.joints.empty());
    CHECK(event.topology.gone.empty());
    CHECK(event.topology.moved.empty());
    CHECK(event.mechanisms_before == event.mechanisms_after);
    CHECK(event.actions[0].text() == "break rod");
    CHECK(event.actions[0].spring == "rod");
    CHECK(event.actions[0].joint.empty());
    const SpringView spring = sim.world().spring({0});
    CHECK(spring.broken);
    CHECK(spring.tension == 0);
    CHECK(spring.length > 0);  // the distance of its ends
    CHECK(sim.world().tree().loads().bodies.empty());
    CHECK(std::fabs(sim.energy().error) < 1e-12);
    CHECK(sim.apply(break_spring("rod")).actions[0].skipped == "the spring is broken already");
  }
}

TEST_CASE("a spring with a strength breaks when its force, pulling or pushing, exceeds it") {
  for (const double speed : {1.0, -1.0}) {
    Model model({.gravity = {}});
    const BodyId a = model.add(slider("m/a", 2, 1, speed));
    model.add_spring({.name = "s", .from = {ground, {}}, .to = {a, {}}, .stiffness = 50, .strength = 4});
    Simulation sim(model, {.method = "dopri5", .rtol = 1e-10, .atol = 1e-12});
    sim.after("strength of s", 0.1).then(lock("m/a")).named("caught");
    REQUIRE(sim.run_until(1));
    REQUIRE(sim.events().size() == 2);
    CHECK(sim.events()[0].name == "strength of s");
    CHECK(sim.events()[0].actions[0].text() == "break s");
    // x = v/w sin(w t) = 4/50
    const double w = 5, t = std::asin(4.0 / 50 * w) / w;
    CHECK(sim.events()[0].time == doctest::Approx(t).epsilon(1e-8));
    CHECK(sim.events()[0].released == doctest::Approx(0.5 * 50 * 0.08 * 0.08).epsilon(1e-7));
    CHECK(sim.events()[0].before.linear == sim.events()[0].after.linear);
    CHECK(sim.events()[1].name == "caught");
  }
}

TEST_CASE("triggers and actions take the names of springs where they make sense, and say so where they do not") {
  Simulation sim(pair_of_masses(), {.method = "dopri5"});
  sim.when(reaction_force("rod").exceeds(12.3)).then(lock("m/a")).named("pulled");
  const auto says = [&](auto act, const std::string& part) {
    const std::string text = error_of(act);
    CAPTURE(text);
    CHECK(contains(text, part));
  };
  says([&] { static_cast<void>(sim.when(reaction_torque("rod").exceeds(5))); }, "'rod' is a spring, not a joint");
  says([&] { static_cast<void>(sim.when(position_of("rod").exceeds(5))); }, "'rod' is a spring, not a joint");
  says([&] { sim.apply(lock("rod")); }, "'rod' is a spring, not a joint");
  says([&] { sim.apply(break_joint("rodd")); }, "there is no joint or spring 'rodd'");
  says([&] { sim.apply(set_parameters("rod", {.armature = 1})); }, "a spring has only");
  says([&] { sim.apply(set_parameters("rod", {.stiffness = -1})); }, "stiffness: must not be negative");
  REQUIRE(sim.run_until(1));
  REQUIRE(sim.events().size() == 1);
  CHECK(sim.events()[0].name == "pulled");
  // It begins with 12 N; half a period later it pushes with 12.3 N.
  const double w = std::sqrt(40 / 1.2), phase = std::atan2(0.5 / w, 0.3), amplitude = std::hypot(0.3, 0.5 / w);
  const double t = (std::numbers::pi - std::acos(12.3 / 40 / amplitude) - phase) / w;
  CHECK(sim.events()[0].time == doctest::Approx(t).epsilon(1e-6));
}

TEST_CASE("set changes the law of a spring; the energy of the change is work") {
  Simulation sim(pair_of_masses(), precise(Variables::momenta));
  const double before = sim.world().totals().potential;
  const Event event = sim.apply(set_parameters("rod", {.damping = 2, .stiffness = 100, .rest = 1, .strength = {.force = 1e4}}));
  const SpringLaw law = sim.world().spring({0}).law;
  CHECK(law == SpringLaw{.stiffness = 100, .rest = 1, .damping = 2, .strength = 1e4});
  CHECK(event.work == doctest::Approx(50 * 0.25 - before).epsilon(1e-12));
  CHECK(event.actions[0].spring == "rod");
  CHECK(event.topology.empty());
  REQUIRE(sim.run_until(0.5));
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  Simulation branch = sim.branch();
  CHECK(branch.world().spring({0}).law == law);
}

TEST_CASE("snapshots, undo and branches know which springs are broken, to the bit") {
  Model model = pair_of_masses(0.5);
  model.add_spring(
      {.name = "other", .from = {ground, {0, 1, 0}}, .to = {model.body("n/b"), {}}, .stiffness = 7, .tension_only = true});
  Simulation sim(model, {.method = "rk4", .step = 1e-3});
  sim.keep_history();
  sim.at(0.2).then(break_spring("rod"));
  REQUIRE(sim.run_until(0.1));
  const SimulationSnapshot intact = sim.snapshot();
  REQUIRE(sim.run_until(0.3));
  const SimulationSnapshot broken = sim.snapshot();
  REQUIRE(sim.run_until(0.5));
  const std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end());
  const auto same = [&](const Simulation& other) { return std::equal(q.begin(), q.end(), other.world().state().q().begin()); };
  sim.restore(broken);
  CHECK(sim.world().spring({0}).broken);
  CHECK(!sim.world().spring({1}).broken);
  REQUIRE(sim.run_until(0.5));
  CHECK(same(sim));
  sim.restore(intact);
  CHECK(!sim.world().spring({0}).broken);
  Simulation branch = sim.branch();
  for (Simulation* each : {&branch, &sim}) {
    REQUIRE(each->run_until(0.3));  // steps end there, as they did the first time
    REQUIRE(each->run_until(0.5));
    CHECK(same(*each));
  }
  sim.undo(0);
  CHECK(sim.time() == 0.2);
  CHECK(!sim.world().spring({0}).broken);
  REQUIRE(sim.run_until(0.5));
  CHECK(!same(sim));  // the event does not happen again
}

TEST_CASE("springs follow their bodies through breaks, joins and re-rooting, and leave the world with one of them") {
  Model model({.gravity = {}});
  const BodyId a = model.add({.name = "m/a", .mass = 1, .inertia = diagonal(1), .joint = Revolute{.axis = {0, 1, 0}}});
  const BodyId b =
      model.add({.name = "m/b", .mass = 1, .inertia = diagonal(1), .parent = a, .at = {{1, 0, 0}, {}}, .joint = Ball{}});
  const BodyId c = model.add({.name = "n/c", .mass = 1, .inertia = diagonal(1), .joint = Free{}, .q = {0, 0, 2, 1, 0, 0, 0}});
  model.add_spring({.name = "s", .from = {b, {0.5, 0, 0}}, .to = {c, {0, 0.1, 0}}, .stiffness = 100, .rest = 1});
  Simulation sim(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-13});
  sim.apply(break_joint("m/b"));
  REQUIRE(sim.run_until(0.2));
  const Vec3 linear = sim.world().totals().linear, angular = sim.world().totals().angular;
  sim.apply(weld("n/c", "m/b"));  // both ends in one mechanism: the spring keeps its length from now on
  const double length = sim.world().spring({0}).length;
  CHECK(std::fabs(sim.world().spring({0}).rate) < 1e-13);
  REQUIRE(sim.run_until(0.6));
  CHECK(sim.world().spring({0}).length == doctest::Approx(length).epsilon(1e-12));
  CHECK(norm(sim.world().totals().linear - linear) < 1e-12);
  CHECK(norm(sim.world().totals().angular - angular) < 1e-12);
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  sim.apply(reroot("m/b"));
  REQUIRE(sim.run_until(0.8));
  CHECK(norm(sim.world().totals().angular - angular) < 1e-12);
  sim.remove(c);
  CHECK(sim.events().back().topology.broken_springs == std::vector<std::string>{"s"});
  CHECK(sim.world().spring({0}).broken);
  REQUIRE(sim.run_until(1));
  CHECK(std::fabs(sim.energy().error) < 1e-9);
}

TEST_CASE("a model refuses springs that mean nothing, by name and with a remedy") {
  Model model;
  const BodyId a = model.add(slider("m/a", 1, 0)), b = model.add(slider("n/b", 1, 1));
  const Spring good{.name = "s", .from = {a, {}}, .to = {b, {}}, .stiffness = 1};
  model.add_spring(good);
  const auto says = [&](auto change, const std::string& part) {
    Spring spring = good;
    spring.name = "t";
    change(spring);
    const std::string text = error_of([&] { model.add_spring(spring); });
    CAPTURE(text);
    CHECK(contains(text, part));
  };
  says([](Spring& s) { s.name = ""; }, "needs a name");
  says([](Spring& s) { s.name = "s"; }, "already a spring");
  says([](Spring& s) { s.name = "m/a"; }, "already a joint");
  says([](Spring& s) { s.from.body = {7}; }, "on no body of this model");
  says([&](Spring& s) { s.to = s.from; }, "same point");
  says([&](Spring& s) { s.to.body = s.from.body, s.to.point = {1, 0, 0}; }, "same body");
  says([](Spring& s) { s.stiffness = -1; }, "stiffness: must not be negative");
  says([](Spring& s) { s.stiffness = NAN; }, "stiffness: must be finite");
  says([](Spring& s) { s.stiffness = 0; }, "exerts no force");
  says([](Spring& s) { s.damping = -1; }, "damping: must not be negative");
  says([](Spring& s) { s.rest = -1; }, "rest: must not be negative");
  says([](Spring& s) { s.strength = 0; }, "strength: must be positive");
  says([](Spring& s) { s.from.point.x = HUGE_VAL; }, "from: the point must be finite");
  CHECK(contains(error_of([&] { model.add(slider("s", 1, 0)); }), "already a spring 's'"));
  CHECK(contains(error_of([&] { static_cast<void>(model.spring("S")); }), "there is no spring 'S'"));
  CHECK(model.springs().size() == 1);
  model.keep(1);
  CHECK(model.springs().empty());
}

TEST_CASE("tensions, rates and energies agree with the power of the forces in a step without forces of other kinds") {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId a =
      model.add({.name = "m/a", .mass = 1, .com = {0.3, 0, 0}, .inertia = diagonal(0.1), .joint = Ball{}, .v = {1, -2, 0.5}});
  const BodyId b = model.add({.name = "m/b",
                              .mass = 2,
                              .inertia = diagonal(0.2),
                              .parent = a,
                              .at = {{0.6, 0, 0}, {}},
                              .joint = Revolute{.axis = {0, 1, 0}},
                              .v = 3.0});
  model.add_spring(
      {.name = "s", .from = {ground, {0, 0, 2}}, .to = {b, {0.4, 0.1, 0}}, .stiffness = 300, .rest = 1.5, .damping = 8});
  Simulation sim(model, precise(Variables::velocities));
  REQUIRE(sim.run_until(0.37));
  const SpringView spring = sim.world().spring({0});
  const BodyMotion& motion = sim.world().motions()[1];
  const Vec3 end = motion.pose * Vec3{0.4, 0.1, 0}, direction = (1 / norm(end - Vec3{0, 0, 2})) * (end - Vec3{0, 0, 2});
  CHECK(spring.length == doctest::Approx(norm(end - Vec3{0, 0, 2})).epsilon(1e-13));
  CHECK(spring.rate == doctest::Approx(dot(direction, velocity_of(motion, {0.4, 0.1, 0}))).epsilon(1e-12));
  CHECK(spring.tension == doctest::Approx(300 * (spring.length - 1.5) + 8 * spring.rate).epsilon(1e-12));
  CHECK(std::fabs(sim.energy().error) < 1e-8);
}

TEST_CASE("springs that are too stiff for fixed steps: the mass that they move, and steps on both sides of the limit") {
  const auto judged = [](const Model& model, std::string_view method, double step) {
    const Tree tree(model);
    return too_stiff_spring(tree, start_state(model, tree).q(), method, step);
  };
  const Model model = pair_of_masses();  // 40 N/m on 1.2 kg
  const double w = std::sqrt(40 / 1.2);
  CHECK(!judged(model, "rk4", 0.1));
  CHECK(!judged(model, "dopri5", 10));
  const auto stiff = judged(model, "rk4", 1);
  REQUIRE(stiff);
  CHECK(stiff->mass == doctest::Approx(1.2));
  CHECK(stiff->longest_step * w == doctest::Approx(2 * std::numbers::sqrt2).epsilon(0.06));  // not before it is certain
  CHECK(stiff->what("rod", 1) == "spring 'rod' (stiffness = 40 N/m on 1.2 kg) is too stiff for steps of 1 s");
  for (const double factor : {0.93, 1.05}) {
    Simulation sim(model, {.method = "rk4", .variables = Variables::momenta, .step = factor * stiff->longest_step});
    const RunResult run = sim.run_until(400 * stiff->longest_step);
    const bool stays = run && sim.world().totals().potential < 100;
    CHECK(stays == (factor < 1));
  }
  const auto damper = judged(pair_of_masses(300), "rk4", 0.05);
  REQUIRE(damper);
  CHECK(damper->damper);
  CHECK(damper->longest_step == doctest::Approx(2.785 * 1.2 / 300).epsilon(0.01));
  Model rope({.gravity = {}});
  const BodyId a = rope.add(hanging(1, -1));
  rope.add_spring({.name = "s", .from = {ground, {}}, .to = {a, {}}, .stiffness = 1e9, .rest = 2, .tension_only = true});
  CHECK(!judged(rope, "rk4", 1));  // slack
}

TEST_CASE("with fixed steps the error that the kink of a rope causes falls with the square of the step") {
  double errors[2] = {};
  for (int k = 0; k < 20; ++k) {
    const double L = 1 + 0.01 * k;
    Model model({.gravity = {0, 0, -9.81}});
    const BodyId a = model.add(hanging(2, -0.4));
    model.add_spring({.name = "cord", .from = {ground, {}}, .to = {a, {}}, .stiffness = 500, .rest = L, .tension_only = true});
    Simulation exact(model, precise(Variables::momenta));
    REQUIRE(exact.run_until(1));
    for (const int fine : {0, 1}) {
      Simulation sim(model, {.method = "rk4", .variables = Variables::momenta, .step = fine != 0 ? 1e-3 : 8e-3});
      REQUIRE(sim.run_until(1));
      errors[fine] += std::fabs(sim.world().state().q()[0] - exact.world().state().q()[0]);
    }
  }
  CHECK(errors[0] / errors[1] > 20);
  CHECK(errors[0] / errors[1] < 250);
}
