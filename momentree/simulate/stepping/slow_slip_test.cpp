// Bodies that begin to slip under forces that change slowly, and what happens while nothing moves: adaptive steps must not become
// so long that it is missed.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81, friction = 0.3;

// A box with its centre of mass at the floor, so that friction does not tilt it. `force`: on its centre of mass.
Model box_on_floor(std::array<Signal, 3> force) {
  Model model;
  const BodyId box = model.add(
      {.name = "box", .mass = 1, .com = {0, 0, -0.1}, .inertia = diagonal(0.02), .joint = Free{}, .q = {0, 0, 0.1, 1, 0, 0, 0}});
  model.add_collider({.body = box, .solid = contact::box({0.4, 0.4, 0.2})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
  model.add_force({.body = box, .point = {0, 0, -0.1}, .force = std::move(force)});
  return model;
}

const Event* first(const Simulation& sim, const char* name) {
  for (const Event& event : sim.events())
    if (event.name == name) return &event;
  return nullptr;
}

struct Plane {
  double x, y;
};
Plane operator+(Plane a, Plane b) { return {a.x + b.x, a.y + b.y}; }
Plane operator*(double s, Plane a) { return {s * a.x, s * a.y}; }
double size(Plane a) { return std::hypot(a.x, a.y); }

// The velocity at time `end` of a unit mass that begins to slide at t0, from the series at the start and by small steps, which
// are as short as friction requires.
template <class Force>
Plane slide(Force force, double t0, double end) {
  constexpr double bit = 1e-6;
  const double rate = (size(force(t0 + bit)) - size(force(t0 - bit))) / (2 * bit);
  double t = t0 + 1e-3;
  Plane v = (0.5 * rate * 1e-6 / size(force(t0))) * force(t0);
  const auto acceleration = [&](double at, Plane u) { return force(at) + (-friction * g / size(u)) * u; };
  while (t < end) {
    const double h = std::min({end - t, 0.2 * size(v) / (friction * g), 1e-4});
    const Plane k1 = acceleration(t, v), k2 = acceleration(t + h / 2, v + (h / 2) * k1),
                k3 = acceleration(t + h / 2, v + (h / 2) * k2), k4 = acceleration(t + h, v + h * k3);
    v = v + (h / 6) * (k1 + 2 * k2 + 2 * k3 + k4);
    t = h < end - t ? t + h : end;
  }
  return v;
}

}  // namespace

TEST_CASE("slow slip: a force that grows and turns sets a box in motion at the instant, and the box follows it") {
  const auto force = [](double t) { return Plane{4 * t, 2 * std::sin(std::numbers::pi * t)}; };
  double low = 0.1, high = 0.9;
  while (high - low > 1e-15) (size(force(0.5 * (low + high))) < friction * g ? low : high) = 0.5 * (low + high);
  for (const auto& [method, accuracy, steps] : {std::tuple{"dopri5", 1e-8, 600l}, {"dop853", 1e-8, 600l}, {"rk4", 2e-6, 1700l}}) {
    CAPTURE(method);
    Simulation sim(box_on_floor({Signal::ramp(4, 0), Signal::sine(2, 0.5), Signal()}), {.method = method});
    for (const double t : {0.6, 0.65, 1.0}) {
      CAPTURE(t);
      REQUIRE(sim.run_until(t));
      const Vec3 v = sim.world().motions()[0].linear;
      const Plane expected = slide(force, low, t);
      CHECK(std::hypot(v.x - expected.x, v.y - expected.y) < (t < 0.63 ? 20 : 1) * accuracy);
    }
    REQUIRE(first(sim, "slip") != nullptr);
    CHECK(std::fabs(first(sim, "slip")->time - low) < 1e-9);
    CHECK(first(sim, "stepping") == nullptr);
    CHECK(sim.statistics().steps < steps);
  }
}

TEST_CASE(
    "slow slip: a box that was at rest for long is set in motion by the first peak of a force that is hardly large enough") {
  for (const char* method : {"dopri5", "dop853"})
    for (const double frequency : {0.4, 1.3, 7.7, 31.0}) {
      CAPTURE(method);
      CAPTURE(frequency);
      const double amplitude = friction * g * 1.002;
      Simulation sim(box_on_floor({Signal::sine(amplitude, frequency), Signal(), Signal()}), {.method = method});
      REQUIRE(sim.run_until(0.3 / frequency));
      REQUIRE(first(sim, "slip") != nullptr);
      CHECK(std::fabs(first(sim, "slip")->time - std::asin(1 / 1.002) / (2 * std::numbers::pi * frequency)) < 1e-8);
    }
}

TEST_CASE("adaptive steps: what is locked breaks at the first peak that exceeds its strength") {
  for (const char* method : {"dopri5", "dop853"})
    for (const double frequency : {0.4, 3.0, 17.0}) {
      CAPTURE(method);
      CAPTURE(frequency);
      Model model({.gravity = {}});
      Revolute joint{.axis = z_axis};
      joint.strength.force = 10;
      const BodyId arm = model.add({.name = "arm", .mass = 1, .inertia = diagonal(1), .joint = joint});
      model.add_force({.body = arm, .force = {Signal::sine(6, frequency), Signal::sine(8.02, frequency), Signal()}});
      Simulation sim(model, {.method = method});
      sim.apply(lock("arm"));
      REQUIRE(sim.run_until(20.3 / frequency));
      const Event* const broken = first(sim, "strength of arm");
      REQUIRE(broken != nullptr);
      CHECK(std::fabs(broken->time - std::asin(10 / std::hypot(6, 8.02)) / (2 * std::numbers::pi * frequency)) < 1e-8);
    }
}

TEST_CASE("adaptive steps: a joint leaves its stop at the first pull") {
  for (const char* method : {"dopri5", "dop853"})
    for (const double frequency : {0.4, 3.0, 17.0}) {
      CAPTURE(method);
      CAPTURE(frequency);
      Model model({.gravity = {0, 0, -1}});
      Prismatic joint{.axis = z_axis};
      joint.limits.lower = 0;
      const BodyId slider = model.add({.name = "slider", .mass = 1, .inertia = diagonal(1), .joint = joint});
      model.add_force({.body = slider, .force = {Signal(), Signal(), Signal::sine(1.01, frequency)}});
      Simulation sim(model, {.method = method});
      REQUIRE(sim.run_until(20.3 / frequency));
      double left = -1;
      for (const Event& e : sim.events())
        if (left < 0 && !e.actions.empty() && e.actions[0].kind == "leave") left = e.time;
      CHECK(std::fabs(left - std::asin(1 / 1.01) / (2 * std::numbers::pi * frequency)) < 1e-8);
    }
}

TEST_CASE("slow slip: where both ends of a rolling body stop to slip at once, it goes straight on") {
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    oracle::Prng random(3);
    for (int k = 0; k < 100; ++k) {
      const double r = random.uniform(0.05, 0.4), length = random.uniform(0.1, 1), mu = random.uniform(0.05, 1),
                   v = random.uniform(0.3, 4);
      const double across = (3 * r * r + length * length) / 6;
      Model model;
      const BodyId log = model.add({.name = "log",
                                    .mass = 2,
                                    .inertia = diagonal(across, across, r * r),
                                    .joint = Free{},
                                    .q = {0, 0, r, std::sqrt(0.5), std::sqrt(0.5), 0, 0},
                                    .v = {v, 0, 0, 0, 0, 0}});
      model.add_collider({.body = log, .solid = k % 2 == 0 ? contact::cylinder(r, length) : contact::capsule(r, length)});
      model.add_collider({.plane = true});
      model.add_contact_rule({.law = {.friction = mu, .static_friction = mu}});
      Simulation sim(model, {.method = method, .step = 1e-3});
      const double sticks = v / (3 * mu * 9.81);
      REQUIRE(sim.run_until(2 * sticks));
      const Vec3 end = sim.world().motions()[0].pose.position;
      CAPTURE(method);
      CAPTURE(k);
      CHECK(end.x == doctest::Approx(v * sticks - 0.5 * mu * 9.81 * sticks * sticks + 2 * v / 3 * sticks).epsilon(1e-6));
      CHECK(std::fabs(end.y) < 1e-8);
    }
  }
}

// A high box that is pulled at its top, so that its corners share its weight more and more unequally, and then tips.
TEST_CASE("slow slip: corners of a pulled box reach their cones, or end their slip, one after the other without false events") {
  constexpr double lift = 0.1;
  const auto pulled = [](double x, double y, double mu, const char* method) {
    Model model({.gravity = {0, 0, -g}});
    const BodyId box = model.add(
        {.name = "box", .mass = 1, .inertia = diagonal(0.0167, 0.0167, 0.0067), .joint = Free{}, .q = {0, 0, 0.2, 1, 0, 0, 0}});
    model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.4})});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = mu, .static_friction = mu}});
    model.add_force(
        {.body = box, .point = {0, 0, 0.2}, .force = {Signal::ramp(x, 0), Signal::ramp(y, 0), Signal::ramp(lift, 0)}});
    return Simulation(model, {.method = method});
  };
  for (const char* const method : {"dopri5", "dop853"}) {
    CAPTURE(method);
    for (const double angle : {0.1, 0.4, 0.78}) {  // across the diagonal corners reach their cones, while all stick together
      CAPTURE(angle);
      Simulation sim = pulled(1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.4, method);
      REQUIRE(sim.run_until(1));
      CHECK(sim.events().size() == 1);
      CHECK(norm(sim.world().motions()[0].linear) < 1e-12);
    }
    // It slips shortly before it tips about an edge, whose corners then come to rest together, which adaptive steps follow.
    Simulation sim = pulled(2, 0.7, 0.26, method);
    REQUIRE(sim.run_until(1.5));
    std::vector<std::string> names;
    for (const Event& event : sim.events()) names.push_back(event.name);
    CHECK(names == std::vector<std::string>{"rest", "slip", "stick"});
    const double slips = 0.26 * g / (std::hypot(2, 0.7) + 0.26 * lift);  // friction is at its limit
    CHECK(std::fabs(first(sim, "slip")->time - slips) < 1e-8);
    CHECK(std::fabs(first(sim, "stick")->time - 1.373343) < 2e-6);  // with rtol 1e-11
  }
}

// With a constant force, d/dt |v| (μ g + F cos θ) = F² − (μ g)², where θ is the angle between the velocity and the force.
TEST_CASE("slow slip: slip that a constant force turns ends at the instant, whatever its speed") {
  constexpr double limit = friction * g, force = 2;
  for (const char* const method : {"dopri5", "dop853"})
    for (const double speed : {4e-4, 4e-2, 1.0})
      for (const double angle : {0.5, 2.0, 2.5, 3.0}) {
        CAPTURE(method);
        CAPTURE(speed);
        CAPTURE(angle);
        Model model;
        const BodyId box = model.add({.name = "box",
                                      .mass = 1,
                                      .com = {0, 0, -0.1},
                                      .inertia = diagonal(0.02),
                                      .joint = Free{},
                                      .q = {0, 0, 0.1, 1, 0, 0, 0},
                                      .v = {speed, 0, 0, 0, 0, 0}});
        model.add_collider({.body = box, .solid = contact::box({0.4, 0.4, 0.2})});
        model.add_collider({.plane = true});
        model.add_contact_rule({.law = {.friction = friction, .static_friction = friction}});
        const double x = force * std::cos(angle), y = force * std::sin(angle);
        model.add_force({.body = box, .point = {0, 0, -0.1}, .force = {Signal(x), Signal(y), Signal()}});
        Simulation sim(model, {.method = method});
        const double ends = speed * (limit + x) / (limit * limit - force * force);
        REQUIRE(sim.run_until(ends + 0.1));
        const Event* const stick = first(sim, "stick");
        REQUIRE(stick != nullptr);
        CHECK(std::fabs(stick->time - ends) < 1e-7 + 1e-6 * ends);
        CHECK(std::fabs(sim.energy().error) < 1e-6 * sim.energy().largest_kinetic);
      }
}

TEST_CASE("slow slip: a box on an incline slides or rests, however near its friction is to the one that holds it") {
  for (const char* const method : {"rk4", "dop853"})
    for (const double slope : {10.0, 20.0, 45.0})
      for (const double off : {1e-2, 1e-4, 1e-6, 1e-7, -1e-2, -1e-4, -1e-6, -1e-7}) {
        CAPTURE(std::string(method));
        CAPTURE(slope);
        CAPTURE(off);
        const double a = slope * std::numbers::pi / 180, mu = std::tan(a) * (1 + off);
        const Vec3 normal{std::sin(a), 0, std::cos(a)}, centre = 0.1 * normal;
        Model model({.gravity = {0, 0, -g}});
        const BodyId box = model.add({.name = "box",
                                      .mass = 2,
                                      .inertia = diagonal(0.02),
                                      .joint = Free{},
                                      .q = {centre.x, 0, centre.z, std::cos(a / 2), 0, std::sin(a / 2), 0}});
        model.add_collider({.body = box, .solid = contact::box({0.4, 0.4, 0.2})});
        model.add_collider({.plane = true, .normal = normal});
        model.add_contact_rule({.law = {.friction = mu, .static_friction = mu}});
        Simulation sim(model, {.method = method, .step = 1e-2});
        REQUIRE(sim.run_until(2));
        const double slid = dot(sim.world().motions()[0].pose.position - centre, Vec3{std::cos(a), 0, -std::sin(a)});
        const double expected = std::max(0.0, 2 * g * (std::sin(a) - mu * std::cos(a)));
        CHECK(std::fabs(slid - expected) < 1e-6 * expected + 3e-12);  // round-off of the velocity over 2 s
        CHECK(sim.statistics().steps < 250);
      }
}

TEST_CASE("slow slip: a box that breaks away leaves behind what kinetic friction cannot carry, at the same instant") {
  // Both plates rest until the lower one breaks away from the floor, which then holds it so much less that the upper one slips.
  constexpr double on_floor = 0.6, kinetic = 0.1, between = 0.3, between_kinetic = 0.25, lower = 2, upper = 1, pull = 20;  // N/s
  Model model;
  for (const auto& [name, mass, height] : {std::tuple{"lower", lower, 0.01}, {"upper", upper, 0.03}}) {
    const BodyId plate =
        model.add({.name = name, .mass = mass, .inertia = diagonal(0.2), .joint = Free{}, .q = {0, 0, height, 1, 0, 0, 0}});
    model.add_collider({.body = plate, .solid = contact::box({1, 1, 0.02})});
  }
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = kinetic, .static_friction = on_floor}});
  model.add_contact_rule(
      {.one = {BodyId{1}}, .other = {BodyId{0}}, .law = {.friction = between_kinetic, .static_friction = between}});
  model.add_force({.body = BodyId{0}, .force = {Signal::ramp(pull, 0), Signal(), Signal()}});
  const double begins = on_floor * (lower + upper) * g / pull, t = 0.1;  // after that, at a constant growth of the force
  for (const char* method : {"dop853", "rk4"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method});
    REQUIRE(sim.run_until(begins + t));
    CHECK(first(sim, "stepping") == nullptr);
    int slips = 0;
    for (const Event& event : sim.events()) {
      if (event.name != "slip") continue;
      CHECK(std::fabs(event.time - begins) < 1e-9);
      ++slips;
    }
    CHECK(slips == 2);
    const double force = pull * (begins * t + t * t / 2) - (kinetic * (lower + upper) + between_kinetic * upper) * g * t;
    CHECK(std::fabs(sim.world().motions()[0].linear.x - force / lower) < 1e-8);
    CHECK(std::fabs(sim.world().motions()[1].linear.x - between_kinetic * g * t) < 1e-8);
  }
}
