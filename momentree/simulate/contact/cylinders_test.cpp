// Cylinders and hulls that roll, stand and rock.
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;

namespace {

constexpr double radius = 0.3, length = 0.8, mass = 2;

Model cylinder_at(const Pose& pose, const Values& v, double slope, double friction, double restitution = 0) {
  Model model({.gravity = {9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)}});
  const double across = mass * (3 * radius * radius + length * length) / 12;
  const Quat& r = pose.rotation;
  const BodyId can = model.add({.name = "can/can",
                                .mass = mass,
                                .inertia = diagonal(across, across, mass * radius * radius / 2),
                                .joint = Free{},
                                .q = {pose.position.x, pose.position.y, pose.position.z, r.w, r.x, r.y, r.z},
                                .v = v});
  model.add_collider({.body = can, .solid = contact::cylinder(radius, length)});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = restitution}});
  return model;
}

const Vec3 upward{0, 0, 1};

}  // namespace

TEST_CASE("cylinders: one on its side rolls down with two thirds of the acceleration") {
  const double slope = 0.2;
  const Quat lying = from_axis_angle({1, 0, 0}, std::numbers::pi / 2);
  Simulation sim(cylinder_at(Pose(Vec3{0, 0, radius}, lying), {}, slope, 0.5),
                 {.method = "dop853", .step = 1e-2, .rtol = 1e-12, .atol = 1e-14});
  REQUIRE(sim.run_until(2));
  const BodyMotion& end = sim.world().motions()[0];
  const double a = 2.0 / 3 * 9.81 * std::sin(slope);
  CHECK(std::fabs(end.pose.position.x - 0.5 * a * 4) < 1e-9);
  CHECK(std::fabs(end.pose.position.z - radius) < 1e-12);
  CHECK(std::fabs(end.angular.y - 2 * a / radius) < 1e-9);
  CHECK(std::fabs(sim.energy().error) < 1e-9);
}

TEST_CASE("cylinders: one that stands stays on a slope up to the angle at which it tips over") {
  const double limit = std::atan(2 * radius / length);
  for (const double slope : {0.98 * limit, 1.02 * limit}) {
    Simulation sim(cylinder_at(Pose(Vec3{0, 0, length / 2}), {}, slope, 2), {.method = "dop853", .step = 1e-2});
    const RunResult run = sim.run_until(0.3);
    INFO(run.reason);
    REQUIRE(run);
    const double upright = (sim.world().motions()[0].pose.rotation.w);
    CHECK((upright > 1 - 1e-12) == (slope < limit));
    CHECK(std::fabs(sim.energy().error) < 1e-7);
  }
}

TEST_CASE("cylinders: one that leans falls back on its end and rocks until it rests") {
  const double tilt = 0.2;
  const Quat leaning = from_axis_angle({0, 1, 0}, tilt);
  const Vec3 centre{0, 0, length / 2 * std::cos(tilt) + radius * std::sin(tilt)};
  Simulation sim(cylinder_at(Pose(centre, leaning), {}, 0, 1), {.method = "dop853", .step = 1e-2});
  const RunResult run = sim.run_until(3);
  INFO(run.reason);
  REQUIRE(run);
  const BodyMotion& end = sim.world().motions()[0];
  CHECK(std::fabs(end.pose.position.z - length / 2) < 1e-9);
  CHECK(norm(end.linear) + norm(end.angular) < 1e-9);
  // The first impact, about the opposite point of the rim, as Housner's block.
  const double about_rim = mass * (3 * radius * radius + length * length) / 12 + mass * (radius * radius + length * length / 4);
  const double kept = 1 - 2 * mass * radius * radius / about_rim;
  double ratio = -1;
  for (const Event& event : sim.events())
    if (ratio < 0 && event.name == "impact" && event.before.kinetic > 0.1) ratio = event.after.kinetic / event.before.kinetic;
  CHECK(std::fabs(sim.energy().projection) < 1e-7);
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  CHECK(std::fabs(ratio - kept * kept) < 1e-6);
}

TEST_CASE("cylinders: thrown on the floor they never gain energy and never sink in") {
  oracle::Prng random(21);
  for (int k = 0; k < 10; ++k) {
    Values v;
    for (int i = 0; i < 6; ++i) v.push_back(random.uniform(-2, 2));
    const Pose start(Vec3{0, 0, 1}, random.rotation());
    const double mu = random.uniform(0, 1);
    const double e = random.uniform(0, 0.6);
    Simulation sim(cylinder_at(start, v, 0, mu, e), {.method = "dop853", .step = 1e-2, .rtol = 1e-10, .atol = 1e-12});
    double lowest = 1;
    sim.watch([&](double) {
      const Pose pose = sim.world().motions()[0].pose;
      const Vec3 axis = rotation_matrix(pose.rotation) * upward;
      lowest = std::min(lowest, pose.position.z - length / 2 * std::fabs(axis.z) - radius * std::hypot(axis.x, axis.y));
      return true;
    });
    const RunResult run = sim.run_until(1);
    CAPTURE(k);
    INFO(run.reason);
    REQUIRE(run);
    CHECK(lowest > -1e-8);
    for (const Event& event : sim.events()) CHECK(event.lost > -1e-10);
    CHECK(std::fabs(sim.energy().error) < 1e-6);
  }
}
