// Long runs of the two mechanisms with closed loops of the IFToMM benchmark library whose energy shows whether loops are handled
// at all: windows of parallelograms, which pass positions where the equations lose rank, and Bricard's mechanism, whose equations
// are dependent wherever it is closed.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>

namespace momentree {
namespace {

constexpr Vec3 y_direction{0, 1, 0};

/// A uniform rod of 1 m and 1 kg from its joint along `along`.
BodySpec rod(const std::string& name, Vec3 along, Vec3 axis) {
  BodySpec spec;
  const auto across = [](double component) { return std::max(1e-5, (1 - component * component) / 12); };
  spec.name = name, spec.mass = 1, spec.com = 0.5 * along;
  spec.inertia = diagonal(across(along.x), across(along.y), across(along.z));
  spec.joint.kind = Kind::revolute, spec.joint.axis = axis;
  return spec;
}

LoopSpec pin(const std::string& name, BodyId body, BodyId to, Vec3 axis, Vec3 at, Vec3 child_at) {
  LoopSpec loop;
  loop.name = name, loop.body = body, loop.to = to;
  loop.joint.kind = Kind::revolute, loop.joint.axis = axis;
  loop.at.position = at, loop.child_at.position = child_at;
  return loop;
}

/// Upright posts a metre apart on the ground, each tip joined to the next one's by a rod; they fall at 1 rad/s.
Model windows(int count) {
  Model model({.gravity = {0, 0, -9.81}});
  std::vector<BodyId> posts;
  for (int i = 0; i <= count; ++i) {
    BodySpec post = rod("post" + std::to_string(i), {1, 0, 0}, y_direction);
    post.at.position = {double(i), 0, 0};
    post.q = -std::numbers::pi / 2, post.v = 1;
    posts.push_back(model.add(post));
  }
  for (std::size_t i = 0; i + 1 < posts.size(); ++i) {
    BodySpec bar = rod("bar" + std::to_string(i), {1, 0, 0}, y_direction);
    bar.parent = posts[i], bar.at.position = {1, 0, 0};
    bar.q = std::numbers::pi / 2, bar.v = -1;
    const BodyId id = model.add(bar);
    model.add_loop(pin("pin" + std::to_string(i), id, posts[i + 1], y_direction, {1, 0, 0}, {1, 0, 0}));
  }
  return model;
}

/// Six edges of a cube, the last one on the ground; each joint's axis is perpendicular to both of its edges.
Model bricard() {
  constexpr std::array<Vec3, 5> edges{Vec3{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, 1, 0}};
  constexpr std::array<Vec3, 5> axes{Vec3{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Model model({.gravity = {0, -9.81, 0}});
  BodyId last = ground;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    BodySpec link = rod("link" + std::to_string(i), edges[i], axes[i]);
    link.parent = last;
    if (i > 0) link.at.position = edges[i - 1];
    last = model.add(link);
  }
  model.add_loop(pin("pin", last, ground, {1, 0, 0}, {0, 0, 1}, edges.back()));
  return model;
}

/// Largest change of the energy in 10 s, relative to the largest kinetic energy.
double drift(const Model& model, const Integration& how) {
  Simulation sim(model, how);
  const double start = sim.energy().initial;
  double largest = 0, most = 0;
  for (int k = 1; k <= 100; ++k) {
    REQUIRE(sim.run_until(0.1 * k) == Status::ok);
    const Totals now = sim.world().totals();
    largest = std::max(largest, now.kinetic);
    most = std::max(most, std::fabs(now.kinetic + now.potential - start));
    CHECK(sim.world().loop_status().residual < 3e-13);
  }
  CHECK(largest > 1);
  return most / largest;
}

Integration accurately(Variables variables) { return {.method = "dop853", .variables = variables, .rtol = 1e-12, .atol = 1e-13}; }

}  // namespace

TEST_CASE("loops: windows of parallelograms keep their energy for 10 s, through their singular positions") {
  for (const int count : {1, 2, 40}) {
    CAPTURE(count);
    const Model model = windows(count);
    CHECK(drift(model, accurately(Variables::velocities)) < 1e-9);
    if (count < 40) CHECK(drift(model, accurately(Variables::momenta)) < 1e-9);
  }
}

// The closed form of all posts as one pendulum, by elliptic functions: the tip of the first post.
TEST_CASE("loops: windows of parallelograms are where the closed form says, through their singular positions") {
  struct {
    int count;
    double x, z;
  } const cases[] = {{2, 0.32845811154082, 0.9445185381786}, {40, 0.18051222668673, 0.98357274058231}};
  for (const auto& one : cases) {
    const auto off = [&](double rtol) {
      Simulation sim(windows(one.count), {.method = "dop853", .rtol = rtol, .atol = 0.1 * rtol});
      REQUIRE(sim.run_until(10) == Status::ok);
      CHECK(std::fabs(sim.energy().projection) < 10 * rtol * sim.energy().largest_kinetic);
      CHECK(sim.warnings().empty());
      const double q = sim.world().joint(JointId{0}).q[0];
      return std::hypot(std::cos(q) - one.x, -std::sin(q) - one.z);
    };
    CAPTURE(one.count);
    CHECK(off(1e-12) < 2e-10);
    CHECK(off(1e-10) < 2e-8);
    CHECK(off(1e-8) < 2e-6);
  }
}

// A kite, whose coupler and rocker are as long as its crank and its base: its two positions in line are singular, and the crank
// turns through both. The way through is that on which the area keeps changing its sign; the speed follows from the energy.
TEST_CASE("loops: kites that pass both of their singular positions keep to their branch, at the speed of their energy") {
  struct {
    double crank, base, angle, speed;
  } const cases[] = {{0.5, 0.8, 1.2, 7}, {0.3, 1.1, 2.0, 9}, {0.9, 0.4, 0.7, 8}, {0.7, 1.0, 2.3, 6.5}, {0.6, 0.75, 1.7, 8}};
  using Real = long double;
  for (const auto& [crank, base, angle, speed] : cases) {
    CAPTURE(crank);
    const Real a = crank, d = base;
    struct Angles {
      Real coupler, rocker, rate_coupler, rate_rocker;  // angles, and their rates by that of the crank
    };
    // Coupler and rocker are the mirror images of crank and base in the diagonal between the crank's tip and the rocker's joint.
    const auto angles = [&](Real q) {
      const Real x = a * std::cos(q) - d, y = a * std::sin(q), square = x * x + y * y;
      const Real along = std::atan2(y, x), turning = (x * a * std::cos(q) + y * a * std::sin(q)) / square;
      return Angles{2 * along - q - std::numbers::pi_v<Real>, 2 * along - std::numbers::pi_v<Real>, 2 * turning - 1, 2 * turning};
    };
    const auto energies = [&](Real q, Real& inertia, Real& potential) {
      const Angles p = angles(q);
      // Uniform rods of 1 kg.
      const Real vx = -a * std::sin(q) - 0.5L * a * std::sin(p.coupler) * p.rate_coupler;
      const Real vy = a * std::cos(q) + 0.5L * a * std::cos(p.coupler) * p.rate_coupler;
      inertia = a * a / 3 + vx * vx + vy * vy + a * a / 12 * p.rate_coupler * p.rate_coupler +
                d * d / 3 * p.rate_rocker * p.rate_rocker;
      potential =
          9.81L * (0.5L * a * std::sin(q) + a * std::sin(q) + 0.5L * a * std::sin(p.coupler) + 0.5L * d * std::sin(p.rocker));
    };
    Real inertia = 0, potential = 0, q = angle;
    energies(q, inertia, potential);
    const Real energy = 0.5L * inertia * speed * speed + potential;
    const auto rate = [&](Real at) {
      energies(at, inertia, potential);
      return std::sqrt(2 * (energy - potential) / inertia);
    };
    constexpr int steps = 20000;
    const Real h = 3.0L / steps;
    for (int i = 0; i < steps; ++i) {
      const Real k1 = rate(q), k2 = rate(q + h / 2 * k1), k3 = rate(q + h / 2 * k2), k4 = rate(q + h * k3);
      q += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    REQUIRE(q - angle > 4 * std::numbers::pi);
    Model model({.gravity = {0, -9.81, 0}});
    const Angles start = angles(angle);
    const auto bar = [](const char* name, double length, double at, double turning) {
      BodySpec spec;
      spec.name = name, spec.mass = 1, spec.com = {0.5 * length, 0, 0};
      spec.inertia = diagonal(1e-5, length * length / 12, length * length / 12);
      spec.joint.kind = Kind::revolute, spec.joint.axis = {0, 0, 1}, spec.q = at, spec.v = turning;
      return spec;
    };
    const auto number = [](Real x) { return static_cast<double>(x); };
    const BodyId first = model.add(bar("crank", crank, angle, speed));
    BodySpec coupler = bar("coupler", crank, number(start.coupler) - angle, speed * (number(start.rate_coupler) - 1));
    coupler.parent = first, coupler.at.position = {crank, 0, 0};
    BodySpec rocker = bar("rocker", base, number(start.rocker), speed * number(start.rate_rocker));
    rocker.at.position = {base, 0, 0};
    const BodyId second = model.add(coupler), third = model.add(rocker);
    model.add_loop(pin("pin", second, third, {0, 0, 1}, {base, 0, 0}, {crank, 0, 0}));
    Simulation sim(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-13});
    REQUIRE(sim.run_until(3) == Status::ok);
    CHECK(std::fabs(sim.world().joint(JointId{first.index}).q[0] - number(q)) < 3e-10);
  }
}

TEST_CASE("loops: Bricard's mechanism keeps its energy for 10 s, at rank 4 of 5") {
  const Simulation sim(bricard());
  CHECK(sim.world().loop_status().rows == 5);
  CHECK(sim.world().loop_status().rank == 4);
  CHECK(drift(bricard(), accurately(Variables::velocities)) < 1e-11);
  CHECK(drift(bricard(), accurately(Variables::momenta)) < 1e-11);
  CHECK(drift(bricard(), {.method = "rk4", .step = 1e-3}) < 1e-9);
}

}  // namespace momentree
