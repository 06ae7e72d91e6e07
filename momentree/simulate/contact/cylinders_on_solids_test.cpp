// Cylinders that roll, stand, rock and hit each other on boxes and hulls, against closed forms and the same on a plane.
#include <cmath>
#include <numbers>
#include <string_view>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;

namespace {

constexpr double radius = 0.3, length = 0.8, mass = 2, g = 9.81;
const Quat lying = from_axis_angle({1, 0, 0}, std::numbers::pi / 2);
const Integration accurate{.method = "dop853", .step = 1e-2, .rtol = 1e-12, .atol = 1e-14};

BodyId add_can(Model& model, const Pose& pose, const Values& v) {
  const double across = mass * (3 * radius * radius + length * length) / 12;
  const Quat& r = pose.rotation;
  const BodyId can = model.add({.name = "can/can",
                                .mass = mass,
                                .inertia = diagonal(across, across, mass * radius * radius / 2),
                                .joint = Free{},
                                .q = {pose.position.x, pose.position.y, pose.position.z, r.w, r.x, r.y, r.z},
                                .v = v});
  model.add_collider({.body = can, .solid = contact::cylinder(radius, length)});
  return can;
}

enum class Below : unsigned char { floor, box, hull, narrow };
// A can above z = 0.
Model can_above(Below below, const Pose& pose, const Values& v, double friction, double restitution = 0) {
  Model model({.gravity = {0, 0, -g}});
  add_can(model, pose, v);
  const Pose under(Vec3{0, 0, -0.5});
  if (below == Below::floor) model.add_collider({.plane = true});
  if (below == Below::box) model.add_collider({.solid = contact::box({20, 20, 1}, under)});
  if (below == Below::narrow) model.add_collider({.solid = contact::box({20, 0.5, 1}, under)});
  if (below == Below::hull) model.add_collider({.solid = contact::hull(contact::box({20, 20, 1}, under).vertices)});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = restitution}});
  return model;
}

double difference(const BodyMotion& a, const BodyMotion& b) {
  return norm(a.pose.position - b.pose.position) + norm(a.linear - b.linear) + norm(a.angular - b.angular);
}

}  // namespace

TEST_CASE("cylinders on solids: one that slides at first rolls with two thirds of its speed") {
  constexpr double v0 = 3, mu = 0.2, rolls = v0 / (3 * mu * g);
  for (const Below below : {Below::floor, Below::box, Below::hull, Below::narrow}) {
    CAPTURE(static_cast<int>(below));
    Simulation sim(can_above(below, Pose(Vec3{-3, 0, radius}, lying), {v0, 0, 0, 0, 0, 0}, mu), accurate);
    const RunResult run = sim.run_until(2);
    INFO(run.reason);
    REQUIRE(run);
    const BodyMotion& end = sim.world().motions()[0];
    CHECK(std::fabs(end.linear.x - 2.0 / 3 * v0) < 1e-9);
    CHECK(std::fabs(end.angular.y - 2.0 / 3 * v0 / radius) < 1e-9);
    CHECK(std::fabs(end.pose.position.x + 3 - (v0 * rolls - 0.5 * mu * g * rolls * rolls + 2.0 / 3 * v0 * (2 - rolls))) < 1e-8);
    CHECK(std::fabs(end.pose.position.z - radius) < 1e-12);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
    for (const Event& event : sim.events()) CHECK(event.name != "stepping");
  }
}

TEST_CASE("cylinders on solids: one that stands keeps still") {
  for (const Below below : {Below::box, Below::hull, Below::narrow})
    for (const char* method : {"dop853", "stepping"}) {
      CAPTURE(static_cast<int>(below));
      Simulation sim(can_above(below, Pose(Vec3{0.1, 0.05, length / 2}), {}, 0.5), {.method = method, .step = 1e-3});
      const RunResult run = sim.run_until(1);
      INFO(run.reason);
      REQUIRE(run);
      const BodyMotion& end = sim.world().motions()[0];
      CHECK(norm(end.pose.position - Vec3{0.1, 0.05, length / 2}) < 1e-9);
      CHECK(norm(end.linear) + norm(end.angular) < (std::string_view(method) == "dop853" ? 1e-9 : 1e-5));
    }
}

TEST_CASE("cylinders on solids: one that rolls on its rim moves as on a plane") {
  const Quat leaning = from_axis_angle({0, 1, 0}, 0.5);
  const Vec3 centre{0, 0, length / 2 * std::cos(0.5) + radius * std::sin(0.5)};
  const auto end = [&](Below below) {
    Simulation sim(can_above(below, Pose(centre, leaning), {0, 0.5, 0, 2, 0.4, 6}, 0.4), accurate);
    const RunResult run = sim.run_until(0.3);
    INFO(run.reason);
    CHECK(run);
    CHECK(std::fabs(sim.energy().error) < 1e-8);
    return sim.world().motions()[0];
  };
  const BodyMotion on_floor = end(Below::floor);
  CHECK(difference(end(Below::box), on_floor) < 1e-8);
  CHECK(difference(end(Below::hull), on_floor) < 1e-8);
}

TEST_CASE("cylinders on solids: one that leans falls back on its end and rocks until it rests") {
  const Quat leaning = from_axis_angle({0, 1, 0}, 0.2);
  const Vec3 centre{0, 0, length / 2 * std::cos(0.2) + radius * std::sin(0.2)};
  const auto ratio = [&](Below below) {
    Simulation sim(can_above(below, Pose(centre, leaning), {}, 1), {.method = "dop853", .step = 1e-2});
    const RunResult run = sim.run_until(3);
    INFO(run.reason);
    CHECK(run);
    const BodyMotion& end = sim.world().motions()[0];
    CHECK(std::fabs(end.pose.position.z - length / 2) < 1e-9);
    CHECK(norm(end.linear) + norm(end.angular) < 1e-9);
    for (const Event& event : sim.events())
      if (event.name == "impact" && event.before.kinetic > 0.1) return event.after.kinetic / event.before.kinetic;
    return -1.0;
  };
  const double about_rim = mass * (3 * radius * radius + length * length) / 12 + mass * (radius * radius + length * length / 4);
  const double kept = 1 - 2 * mass * radius * radius / about_rim;
  for (const Below below : {Below::box, Below::hull}) CHECK(std::fabs(ratio(below) - kept * kept) < 1e-6);
}

TEST_CASE("cylinders on solids: stepped through one rolls as well, to the order of the step") {
  for (const Below below : {Below::box, Below::narrow}) {
    Simulation sim(can_above(below, Pose(Vec3{-3, 0, radius}, lying), {3, 0, 0, 0, 0, 0}, 0.2),
                   {.method = "stepping", .step = 1e-3});
    REQUIRE(sim.run_until(2));
    const BodyMotion& end = sim.world().motions()[0];
    CHECK(std::fabs(end.linear.x - 2) < 5e-3);
    CHECK(std::fabs(end.pose.position.z - radius) < 1e-4);
    CHECK(std::fabs(end.pose.position.y) < 1e-3);
    CHECK(std::fabs(end.linear.z) < 1e-3);
  }
}

TEST_CASE("cylinders on solids: momentum is exact at impacts of free bodies, and energy is never gained") {
  oracle::Prng random(41);
  int impacts = 0;
  for (int k = 0; k < 900; ++k) {
    Model model({.gravity = {}});
    Values v;
    for (int i = 0; i < 6; ++i) v.push_back(random.uniform(-2, 2));
    v[2] = -3;
    add_can(model, Pose(Vec3{0, 0, 1.2}, random.rotation()), v);
    const Quat r = random.rotation();
    const BodyId block = model.add({.name = "block/block",
                                    .mass = 3,
                                    .inertia = diagonal(0.1, 0.15, 0.12),
                                    .joint = Free{},
                                    .q = {0, 0, 0, r.w, r.x, r.y, r.z},
                                    .v = {0, 0, 0, random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)}});
    const contact::Solid box = contact::box({0.5, 0.6, 0.7});
    const contact::Solid solids[] = {box, contact::hull(box.vertices), contact::capsule(0.2, 0.6), contact::cylinder(0.25, 0.6)};
    model.add_collider({.body = block, .solid = solids[k % 4]});
    const double mu = random.uniform(0, 1);
    model.add_contact_rule({.law = {.friction = mu, .static_friction = mu, .restitution = random.uniform(0, 1)}});
    Simulation sim(model, {.method = "dop853", .step = 1e-2, .rtol = 1e-10, .atol = 1e-12});
    const RunResult run = sim.run_until(1);
    CAPTURE(k);
    INFO(run.reason);
    REQUIRE(run);
    for (const Event& event : sim.events()) {
      CHECK(event.name != "stepping");
      if (event.name != "impact") continue;
      ++impacts;
      CHECK(event.lost > -1e-12);
      CHECK(norm(event.after.linear - event.before.linear) < 1e-12);
      CHECK(norm(event.after.angular - event.before.angular) < 1e-12);
    }
  }
  CHECK(impacts > 150);
}

TEST_CASE("cylinders on solids: thrown on boxes they never gain energy and never sink in") {
  oracle::Prng random(42);
  int impacts = 0, stepped = 0;
  for (int k = 0; k < 90; ++k) {
    Values v;
    for (int i = 0; i < 6; ++i) v.push_back(random.uniform(-2, 2));
    const double mu = random.uniform(0, 1);
    const double e = random.uniform(0, 0.7);
    const Pose start(Vec3{0, 0, 0.8}, random.rotation());
    Simulation sim(can_above(k % 2 == 0 ? Below::narrow : Below::hull, start, v, mu, e),
                   {.method = "dop853", .step = 1e-2, .rtol = 1e-11, .atol = 1e-13});
    const RunResult run = sim.run_until(1);
    CAPTURE(k);
    INFO(run.reason);
    REQUIRE(run);
    for (const Event& event : sim.events()) {
      impacts += event.name == "impact" ? 1 : 0, stepped += event.name == "stepping" ? 1 : 0;
      CHECK(event.lost > -1e-10);
    }
    CHECK(std::fabs(sim.energy().error) < 1e-6);
    const std::optional<BodyGap> gap = sim.world().gap({0}, ground);
    CHECK((gap && gap->distance > -1e-12));
  }
  CHECK(impacts > 1000);
}

TEST_CASE("cylinders on solids: cylinders stand on each other and roll on a fixed one") {
  for (const char* method : {"dop853", "stepping"}) {
    Model model({.gravity = {0, 0, -g}});
    add_can(model, Pose(Vec3{0.1, 0.05, length / 2}), {});
    model.add_collider({.solid = contact::cylinder(0.4, 1, Pose(Vec3{0, 0, -0.5}))});
    Simulation sim(model, {.method = method, .step = 1e-3});
    const RunResult run = sim.run_until(1);
    INFO(run.reason);
    REQUIRE(run);
    CHECK(norm(sim.world().motions()[0].pose.position - Vec3{0.1, 0.05, length / 2}) < 1e-9);
  }
  // From the top of a fixed one, without slip, until it leaves: its centre is on a circle, 3/4 of v² is g times the fall.
  constexpr double large = 1, start = 0.1, sum = large + radius;
  Model model({.gravity = {0, 0, -g}});
  add_can(model, Pose(Vec3{sum * std::sin(start), 0, sum * std::cos(start) - large}, lying), {});
  model.add_collider({.solid = contact::cylinder(large, 2, Pose(Vec3{0, 0, -large}, lying))});
  model.add_contact_rule({.law = {.friction = 5, .static_friction = 5}});
  Simulation sim(model, accurate);
  const RunResult run = sim.run_until(1);
  INFO(run.reason);
  REQUIRE(run);
  const BodyMotion& end = sim.world().motions()[0];
  const double height = end.pose.position.z + large;
  REQUIRE(height < 0.97 * sum);
  CHECK(std::fabs(std::hypot(end.pose.position.x, height) - sum) < 1e-11);
  CHECK(std::fabs(0.75 * dot(end.linear, end.linear) - g * (sum * std::cos(start) - height)) < 1e-9);
}
