// Stops of joints that are hit, or transmit impulses, while bodies touch: one impact, in closed form.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81;
constexpr double box = 3, slider = 2;  // kg

// A box that moves along z above a floor, and a slider in it that moves along z too and is pushed up.
struct Machine {
  double height = 0;  ///< of the box above the floor (m)
  JointLimits limits{};
  double q = 0, v = 0;  ///< of the slider
  double push = 0;      ///< N
};
Simulation simulation(const Machine& machine) {
  Model model;
  const BodyId a = model.add({.name = "box",
                              .mass = box,
                              .inertia = diagonal(0.02),
                              .joint = Prismatic{.axis = {0, 0, 1}},
                              .q = {machine.height + 0.1}});
  model.add({.name = "slider",
             .mass = slider,
             .inertia = diagonal(0.01),
             .parent = a,
             .joint = Prismatic{.axis = {0, 0, 1}, .effort = machine.push, .limits = machine.limits},
             .q = {machine.q},
             .v = {machine.v}});
  model.add_collider({.body = a, .solid = contact::box({0.2, 0.2, 0.2})});
  model.add_collider({.plane = true});
  return Simulation(model, {.method = "dop853", .step = 1e-2, .rtol = 1e-12, .atol = 1e-14});
}

double lost(const Simulation& sim) {
  double all = 0;
  for (const Event& event : sim.events()) all += event.lost;
  return all;
}
double speed(const Simulation& sim, const char* joint) {
  return std::fabs(sim.world().joint(sim.world().model().joint(joint)).v[0]);
}
std::vector<const Event*> impacts(const Simulation& sim) {
  std::vector<const Event*> found;
  for (const Event& event : sim.events())
    if (event.name == "impact") found.push_back(&event);
  return found;
}

}  // namespace

TEST_CASE("contact and stops: a slider that hits its lower stop stops dead, in a box that stands on the floor") {
  for (const double v : {0.3, 2.0}) {
    Simulation sim = simulation({.limits = {.lower = 0}, .q = 0.05, .v = -v});
    REQUIRE(sim.run_until(1) == Status::ok);
    CHECK(lost(sim) == doctest::Approx(0.5 * slider * v * v + slider * g * 0.05).epsilon(1e-9));
    CHECK(speed(sim, "box") < 1e-12);
    CHECK(speed(sim, "slider") < 1e-12);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("contact and stops: a slider that hits its upper stop takes the box with it, which lands again") {
  const double v = 2, rise = 0.05, at_stop = std::sqrt(v * v - 2 * g * rise), both = slider * at_stop / (slider + box);
  Simulation sim = simulation({.limits = {.lower = 0, .upper = rise}, .v = v});
  REQUIRE(sim.run_until(0.5) == Status::ok);
  REQUIRE(!sim.events().empty());
  CHECK(lost(sim) > 0);
  const double hit = (v - at_stop) / g;
  for (const Event& event : sim.events()) {
    if (event.time > hit + 1e-6 || event.lost < 1e-9) continue;
    CHECK(event.time == doctest::Approx(hit).epsilon(1e-9));
    CHECK(event.lost == doctest::Approx(0.5 * slider * box / (slider + box) * at_stop * at_stop).epsilon(1e-9));
  }
  REQUIRE_FALSE(impacts(sim).empty());
  CHECK(impacts(sim).front()->time == doctest::Approx(hit + 2 * both / g).epsilon(1e-9));
  CHECK(std::fabs(sim.energy().error) < 1e-9);
}

TEST_CASE("contact and stops: what rests on a stop takes part in a landing if the stop need not pull") {
  const double height = 0.3;
  for (const bool lower : {true, false}) {  // on its lower stop; or pushed against its upper one
    Simulation sim = simulation(
        {.height = height, .limits = {.lower = 0, .upper = 0.05}, .q = lower ? 0 : 0.05, .push = lower ? 0 : 2 * slider * g});
    REQUIRE(sim.run_until(1) == Status::ok);
    REQUIRE_FALSE(impacts(sim).empty());
    const double mass = lower ? box + slider : box;
    CHECK(impacts(sim).front()->time == doctest::Approx(std::sqrt(2 * height / g)).epsilon(1e-9));
    double at_landing = 0;
    for (const Event& event : sim.events())
      if (event.time < impacts(sim).front()->time + 1e-6) at_landing += event.lost;
    CHECK(at_landing == doctest::Approx(mass * g * height).epsilon(1e-9));
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("contact: slip that no finite force allows ends at once, by an impact, and may begin again in another direction") {
  // A rod leans on the floor and slips slowly in the direction of its lean: Painlevé's example. It may also be pushed sideways.
  for (const double push : {0.0, 60.0}) {
    CAPTURE(push);
    constexpr double mass = 2, half = 1, radius = 0.01, mu = 2, lean = 0.55, v = 1e-4, moment = mass * half * half / 3;
    Model model;
    const double z = half * std::cos(lean) + radius, x = half * std::sin(lean);  // the end is at −x
    const BodyId rod = model.add({.name = "rod",
                                  .mass = mass,
                                  .inertia = diagonal(moment, moment, 0.01),
                                  .joint = Free{},
                                  .q = {0, 0, z, std::cos(lean / 2), 0, std::sin(lean / 2), 0},
                                  .v = {-v * std::cos(lean), 0, -v * std::sin(lean), 0, 0, 0}});
    model.add_collider({.body = rod, .solid = contact::sphere(radius, {0, 0, -half})});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = mu, .static_friction = mu}});
    model.add_force({.body = rod, .point = {0, 0, -half}, .force = {Signal{}, Signal{push}, Signal{}}});
    Simulation sim(model, {.method = "dop853", .step = 1e-3, .rtol = 1e-12, .atol = 1e-14});
    const double nn = 1 / mass + x * x / moment, tt = 1 / mass + z * z / moment, nt = x * z / moment;
    REQUIRE(nn < mu * nt);  // no finite force
    REQUIRE(sim.run_until(0.05) == Status::ok);
    const double impact = 0.5 * v * v * nn / (nn * tt - nt * nt);  // until it stops
    CHECK(sim.energy().lost_in_impacts / impact == doctest::Approx(1).epsilon(1e-5));
    const auto named = [](const Event& event) { return event.reason.find("Painlevé") != std::string::npos; };
    CHECK(std::count_if(sim.events().begin(), sim.events().end(), named) == 1);
    const Event& jam = *std::find_if(sim.events().begin(), sim.events().end(), named);
    CHECK(jam.lost / impact == doctest::Approx(1).epsilon(1e-5));
    CHECK(jam.before.kinetic - jam.lost == doctest::Approx(jam.after.kinetic).epsilon(1e-12));
    CHECK(norm(jam.after.linear - jam.before.linear - jam.contact.impulse) < 1e-12 * mass * v);
    CHECK(norm(jam.contact.impulse) > 0.1 * mass * v);
    for (const ContactPoint& contact : sim.world().contacts()) CHECK(contact.force.z > 0);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
    CHECK(jam.name == (push > 0 ? "slip" : "rest"));
    Simulation soon(model, {.method = "dop853", .step = 1e-3, .rtol = 1e-12, .atol = 1e-14});
    REQUIRE(soon.run_until(1e-4) == Status::ok);
    REQUIRE(soon.world().contacts().size() == 1);
    const ContactPoint contact = soon.world().contacts().front();
    CHECK(std::hypot(contact.force.x, contact.force.y) < mu * contact.force.z * (1 + 1e-9));
    CHECK(contact.slips == (push > 0));
    if (push > 0) CHECK(contact.slip.y > 0);
  }
}

TEST_CASE("contact and stops: arms that fall on a floor come to rest, however slowly their last points slip") {
  std::mt19937 random(7);
  const auto gauss = [&](double sigma) { return std::normal_distribution<>(0, sigma)(random); };
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<>(a, b)(random); };
  const auto solid = [&] {
    switch (random() % 4) {
      case 0: return contact::box({0.2, 0.15, 0.1});
      case 1: return contact::sphere(0.08);
      case 2: return contact::capsule(0.05, 0.2);
      default: return contact::cylinder(0.06, 0.2);
    }
  };
  for (int i = 0; i < 24; ++i) {
    CAPTURE(i);
    Model model;
    const double a = gauss(1), b = gauss(1), c = gauss(1), d = gauss(1), size = std::sqrt(a * a + b * b + c * c + d * d);
    const BodyId base = model.add({.name = "base",
                                   .mass = 2,
                                   .inertia = diagonal(0.02),
                                   .joint = Free{},
                                   .q = {0, 0, 0.8, a / size, b / size, c / size, d / size},
                                   .v = {gauss(1), gauss(1), gauss(1), gauss(3), gauss(3), gauss(3)}});
    const double limit = between(0.1, 1), e = i % 2 == 0 ? 0 : 0.3;
    const Vec3 axis{gauss(1), gauss(1), gauss(1)};
    const BodyId arm = model.add({.name = "arm",
                                  .mass = between(0.3, 2),
                                  .inertia = diagonal(0.01, 0.012, 0.008),
                                  .parent = base,
                                  .at = {0.15, 0, 0.1},
                                  .joint = Revolute{.axis = axis, .limits = {.lower = -limit, .upper = limit, .restitution = e}},
                                  .q = {between(-0.1, 0.1)},
                                  .v = {gauss(2)},
                                  .child_at = {-0.15, 0, 0}});
    model.add_collider({.body = base, .solid = solid()});
    model.add_collider({.body = arm, .solid = solid()});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0.4, .static_friction = 0.4}});
    const bool fixed = i % 3 == 2;
    Simulation sim(model, {.method = i % 3 == 0 ? "dop853" : i % 3 == 1 ? "dopri5" : "rk4", .step = 1e-3});
    REQUIRE(sim.run_until(1.2) == Status::ok);
    for (const Event& event : sim.events()) CHECK(event.lost > -1e-9);
    CHECK(std::fabs(sim.energy().error) < (fixed ? 1e-4 : 1e-5));
    CHECK(sim.statistics().steps < 10000);
  }
}

TEST_CASE("contact: a ball that slides over the edge of a box falls from it, and not at the end of a step only") {
  // Without friction it leaves the edge where its weight no longer suffices for the circle about it: cos θ = 2/3 + v²/(3 g R).
  constexpr double radius = 0.15, v = 0.3, x = 0.1, edge = 0.2, top = 0.5;
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    for (const bool other : {false, true}) {  // another contact elsewhere changes nothing
      CAPTURE(method);
      Model model;
      const BodyId table = model.add({.name = "table", .mass = 1, .inertia = diagonal(1), .at = {0, 0, top - 0.1}});
      model.add_collider({.body = table, .solid = contact::box({0.4, 0.4, 0.2})});
      const BodyId ball = model.add({.name = "ball",
                                     .mass = 1,
                                     .inertia = diagonal(0.01),
                                     .joint = Free{},
                                     .q = {x, 0, top + radius, 1, 0, 0, 0},
                                     .v = {v, 0, 0, 0, 0, 0}});
      model.add_collider({.body = ball, .solid = contact::sphere(radius)});
      model.add_contact_rule({.law = {.friction = 0, .static_friction = 0}});
      if (other) {
        const BodyId far =
            model.add({.name = "far", .mass = 1, .inertia = diagonal(0.01), .joint = Free{}, .q = {30, 0, 1.1, 1, 0, 0, 0}});
        model.add_collider({.body = far, .solid = contact::sphere(0.1)});
        model.add_collider({.plane = true});
      }
      Simulation sim(model, {.method = method, .step = 1e-3, .rtol = 1e-11, .atol = 1e-13});
      REQUIRE(sim.run_until(0.8) == Status::ok);
      double lifts = -1;
      for (const Event& event : sim.events())
        if (event.name == "lift") lifts = event.time;
      // From θ = 0 at the edge, with θ'² = (v/R)² + 2 g/R (1 − cos θ).
      const double leaves = std::acos(2.0 / 3 + v * v / (3 * g * radius));
      double time = (edge - x) / v;
      constexpr int parts = 4000;
      for (int i = 0; i <= parts; ++i) {
        const double angle = leaves * i / parts, weight = (i == 0 || i == parts ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) / 3;
        time += weight * leaves / parts / std::sqrt(v * v / (radius * radius) + 2 * g / radius * (1 - std::cos(angle)));
      }
      CHECK(std::fabs(lifts - time) < (std::string(method) == "rk4" ? 1e-7 : 1e-8));
      CHECK(std::fabs(sim.energy().error) < 1e-8);
    }
  }
}

namespace {

// A slider that is pushed down on its lower stop, and one below it that touches it and is pushed up.
struct Pushed {
  double down = 0, up = 0;  ///< N
  double speed = 0;         ///< of the lower one, upwards (m/s)
};
constexpr double upper_mass = 2, lower_mass = 0.5;
Simulation simulation(const Pushed& pushed) {
  Model model({.gravity = {}});
  const BodyId a =
      model.add({.name = "upper",
                 .mass = upper_mass,
                 .inertia = diagonal(0.02),
                 .joint = Prismatic{.axis = {0, 0, 1}, .effort = -pushed.down, .limits = {.lower = 0.5, .restitution = 0.2}},
                 .q = {0.5}});
  const BodyId b = model.add({.name = "lower",
                              .mass = lower_mass,
                              .inertia = diagonal(0.02),
                              .joint = Prismatic{.axis = {0, 0, 1}, .effort = pushed.up},
                              .q = {0.3},
                              .v = {pushed.speed}});
  for (const BodyId body : {a, b}) model.add_collider({.body = body, .solid = contact::box({0.2, 0.2, 0.2})});
  return Simulation(model, {.method = "stepping", .step = 1e-3});
}

}  // namespace

TEST_CASE("contact and stops: stepping keeps a joint on its stop, or lets a contact push it off") {
  for (const double up : {2.0, 7.9, 8.1, 20.0}) {
    CAPTURE(up);
    Simulation sim = simulation({.down = 8, .up = up});
    REQUIRE(sim.run_until(0.5));
    const double a = std::max(0.0, (up - 8) / (upper_mass + lower_mass)), t = 0.5;
    CHECK(std::fabs(speed(sim, "upper") - a * t) < 2e-3 * (1 + a));
    CHECK(std::fabs(sim.world().joint(sim.world().model().joint("upper")).q[0] - 0.5 - 0.5 * a * t * t) < 2e-3 * (1 + a));
    CHECK(sim.events().size() < 10);
    CHECK(std::fabs(sim.energy().error) < 1e-3 * (1 + sim.world().totals().kinetic));
  }
}

// What was hit keeps the mean force of the hit until the next steps: it must not bounce on its stop because of that.
TEST_CASE("contact and stops: stepping follows a joint that was hit off its stop until it rests there again") {
  std::mt19937 random(99);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
  for (int k = 0; k < 50; ++k) {
    CAPTURE(k);
    Simulation sim = simulation({.down = uniform(0.5, 40), .up = uniform(-0.4, 0.4), .speed = uniform(0.01, 4)});
    REQUIRE(sim.run_until(uniform(1, 3)));
    CHECK(sim.statistics().steps < 5000);
    CHECK(sim.world().joint(sim.world().model().joint("upper")).q[0] > 0.5 - 1e-9);
    CHECK(std::fabs(sim.energy().error) < 1e-3 * (1 + sim.world().totals().kinetic));
  }
}

TEST_CASE("a motion that presses a body on the floor by a joint at its stop is said to have forced what results") {
  for (const char* method : {"dop853", "rk4", "stepping"}) {
    CAPTURE(method);
    Model model;
    BodySpec arm{.name = "arm", .mass = 1, .inertia = diagonal(0.01), .joint = Prismatic{.axis = {0, 0, 1}}};
    arm.at = {{0, 0, 0.3}};
    arm.joint.parameters.limits.upper = {0.1};
    const BodyId upper = model.add(arm);
    BodySpec foot{.name = "foot", .mass = 1, .inertia = diagonal(0.01), .parent = upper, .joint = Prismatic{.axis = {0, 0, -1}}};
    foot.joint.parameters.drive = motion_drive(Signal::ramp(1, 0));
    model.add_collider({.body = model.add(foot), .solid = contact::sphere(0.05)});
    model.add_collider({.plane = true});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(1));
    // The floor is at 0.05 m below the foot, 1 m below the arm: 0.65 m above the stop.
    const std::vector<std::string> warnings = sim.warnings();
    REQUIRE(!warnings.empty());  // bodies may overlap until the joint gives way
    CHECK(warnings[0].find("joint 'arm' is 0.6") != std::string::npos);
    for (const std::string& warning : warnings) CHECK(warning.find("a prescribed motion has forced this") != std::string::npos);
    CHECK(sim.events().size() < 20);
  }
}

namespace {

// A slider that its weight presses on its lower stop, and a ball that comes from below, where it has the speed `v`.
struct Hit {
  const char* method;
  double v, step = 1e-3;
  double stop_restitution = 0;
  double until = 0.25;
};
constexpr double slider_mass = 2, ball_mass = 5;
Simulation simulation(const Hit& hit) {
  Model model;
  const BodyId a =
      model.add({.name = "slider",
                 .mass = slider_mass,
                 .inertia = diagonal(0.02),
                 .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.lower = 0.5, .restitution = hit.stop_restitution}},
                 .q = {0.5}});
  const BodyId b = model.add({.name = "ball",
                              .mass = ball_mass,
                              .inertia = diagonal(0.02),
                              .joint = Prismatic{.axis = {0, 0, 1}},
                              .q = {0.25},
                              .v = {hit.v}});
  for (const BodyId body : {a, b}) model.add_collider({.body = body, .solid = contact::box({0.2, 0.2, 0.2})});
  return Simulation(model, {.method = hit.method, .step = hit.step});
}
long events(const Simulation& sim, std::string_view text) {
  return std::ranges::count_if(sim.events(),
                               [&](const Event& event) { return event.name == "stop" && event.actions[0].text() == text; });
}

}  // namespace

TEST_CASE("contact and stops: what rests on a stop flies off when it is hit from below, and leaves its stop") {
  constexpr double v = 3, rise = 0.05;  // 0.25 m, without the size of the bodies
  const double at_hit = std::sqrt(v * v - 2 * g * rise), common = ball_mass * at_hit / (slider_mass + ball_mass);
  const double hit = (v - at_hit) / g, until = 0.25;
  const double speed_then = common - g * (until - hit), q = 0.5 + (until - hit) * (common + speed_then) / 2;
  for (const auto& [method, step] : {std::pair{"dop853", 1e-3}, {"rk4", 1e-3}, {"stepping", 1e-3}, {"stepping", 1e-4}}) {
    CAPTURE(method);
    Simulation sim = simulation(Hit{.method = method, .v = v, .step = step});
    REQUIRE(sim.run_until(until));
    const double error = std::fabs(sim.world().joint(sim.world().model().joint("slider")).q[0] - q);
    const bool stepped = std::string_view(method) == "stepping";
    CHECK(error < (stepped ? 2 * common * step : 1e-8));
    CHECK(events(sim, "rest slider lower") == 1);
    CHECK(events(sim, "leave slider lower") == 1);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
    CHECK(sim.energy().lost_in_impacts ==
          doctest::Approx(0.5 * slider_mass * ball_mass / (slider_mass + ball_mass) * at_hit * at_hit)
              .epsilon(stepped ? 0.02 : 1e-8));
  }
}

TEST_CASE("stepping: a joint bounces on its stop with its restitution, rests there, and the stop carries it") {
  constexpr double drop = 0.2, e = 0.5;
  Model model;
  const BodyId slider = model.add({.name = "slider",
                                   .mass = slider_mass,
                                   .inertia = diagonal(0.02),
                                   .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.lower = 0, .restitution = e}},
                                   .q = {drop}});
  model.add_collider({.body = slider, .solid = contact::sphere(0.1)});
  model.add_contact_rule({});
  const BodyId other = model.add({.name = "other", .mass = 1, .inertia = diagonal(1), .at = {9, 0, 0}});
  model.add_collider({.body = other, .solid = contact::sphere(0.1)});
  Simulation sim(model, {.method = "stepping", .step = 1e-4});
  const double fall = std::sqrt(2 * drop / g);
  REQUIRE(sim.run_until((1 + e) * fall));  // at the top of the first bounce
  CHECK(sim.world().joint(sim.world().model().joint("slider")).q[0] == doctest::Approx(e * e * drop).epsilon(0.01));
  REQUIRE(sim.run_until(2));
  const JointView at_rest = sim.world().joint(sim.world().model().joint("slider"));
  CHECK(std::fabs(at_rest.q[0]) < 1e-9);
  CHECK(at_rest.resting == 1);
  CHECK(at_rest.locked == 0);
  CHECK(events(sim, "rest slider lower") == 1);
  CHECK(events(sim, "hit slider lower") > 5);
  CHECK(sim.energy().lost_in_impacts == doctest::Approx(slider_mass * g * drop).epsilon(1e-6));
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  CHECK(sim.world().joint_forces(sim.world().model().joint("slider")).effort[0] ==
        doctest::Approx(slider_mass * g).epsilon(1e-6));
  CHECK(std::fabs(sim.world().joint_forces(sim.world().model().joint("slider")).a[0]) < 1e-6);
}

TEST_CASE("contact and stops: a moving carriage sets what rests on its stop on the floor, and goes on") {
  constexpr double speed = 0.2, height = 0.4;  // of the load above the floor
  for (const char* method : {"dop853", "rk4", "stepping"}) {
    CAPTURE(method);
    Model model;
    BodySpec carriage{.name = "carriage", .mass = 2, .inertia = diagonal(0.02), .joint = Prismatic{.axis = {0, 0, 1}}};
    carriage.joint.parameters.drive = motion_drive(Signal::ramp(-speed, 1));
    const BodyId upper = model.add(carriage);
    const BodyId load = model.add({.name = "load",
                                   .mass = 1,
                                   .inertia = diagonal(0.01),
                                   .parent = upper,
                                   .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.lower = -0.5}},
                                   .q = {-0.5}});
    model.add_collider({.body = load, .solid = contact::sphere(0.1)});
    model.add_collider({.plane = true});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(3));
    CHECK(sim.warnings().empty());
    CHECK(events(sim, "leave load lower") == 1);
    const double q = sim.world().joint(sim.world().model().joint("load")).q[0];
    CHECK(q == doctest::Approx(-0.5 + speed * (3 - height / speed)).epsilon(1e-3));
    CHECK(sim.events().size() < 6);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
  }
}

TEST_CASE("contact and stops: a hit in an island that is stepped through is one event") {
  // A flood of changes at a column of boxes, whose topmost carries a slider that falls onto its stop: it is stepped through.
  Model model;
  BodyId top;
  for (int k = 0; k < 10; ++k) {
    const double z = 0.1 + 0.2 * k;
    top = model.add(
        {.name = "box" + std::to_string(k), .mass = 1, .inertia = diagonal(0.01), .joint = Free{}, .q = {0, 0, z, 1, 0, 0, 0}});
    model.add_collider({.body = top, .solid = contact::box({0.2, 0.2, 0.2})});
  }
  model.add({.name = "slider",
             .mass = 1,
             .inertia = diagonal(0.01),
             .parent = top,
             .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.lower = 0, .restitution = 0.5}},
             .q = {0.05}});
  const BodyId far =
      model.add({.name = "far", .mass = 1, .inertia = diagonal(0.01), .joint = Free{}, .q = {9, 0, 2, 1, 0, 0, 0}});
  model.add_collider({.body = far, .solid = contact::sphere(0.1)});
  model.add_collider({.plane = true});
  Simulation sim(model, {.method = "dop853", .step = 1e-3});
  REQUIRE(sim.run_until(0.5));
  REQUIRE(std::ranges::any_of(sim.events(), [](const Event& event) { return event.name == "stepping"; }));
  std::vector<double> times;
  for (const Event& event : sim.events())
    if (event.name == "stop" && event.actions[0].kind == "hit") times.push_back(event.time);
  CHECK(times.size() > 2);
  CHECK(std::ranges::adjacent_find(times) == times.end());
  CHECK(events(sim, "rest slider lower") == 1);
}

TEST_CASE("stepping: the record of a lock says so where the joint rests on its stop") {
  Model model;
  const BodyId slider = model.add({.name = "slider",
                                   .mass = 1,
                                   .inertia = diagonal(0.01),
                                   .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.lower = 0}},
                                   .q = {0.05}});
  model.add_collider({.body = slider, .solid = contact::sphere(0.1)});
  model.add_collider({.plane = true, .point = {0, 0, -9}});
  Simulation sim(model, {.method = "stepping", .step = 1e-3});
  REQUIRE(sim.run_until(0.5));
  REQUIRE(sim.world().joint({sim.world().find_joint("slider")}).resting == 1);
  sim.apply(lock("slider"));
  REQUIRE(sim.events().back().topology.joints.size() == 1);
  CHECK(sim.events().back().topology.joints[0].locked == 1);
}
