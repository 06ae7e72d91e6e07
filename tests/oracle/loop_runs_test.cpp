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
  const auto across = [](double component) { return 1e-5 + (1 - component * component) / 12; };
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

TEST_CASE("loops: Bricard's mechanism keeps its energy for 10 s, at rank 4 of 5") {
  const Simulation sim(bricard());
  CHECK(sim.world().loop_status().rows == 5);
  CHECK(sim.world().loop_status().rank == 4);
  CHECK(drift(bricard(), accurately(Variables::velocities)) < 1e-11);
  CHECK(drift(bricard(), accurately(Variables::momenta)) < 1e-11);
  CHECK(drift(bricard(), {.method = "rk4", .step = 1e-3}) < 1e-9);
}

}  // namespace momentree
