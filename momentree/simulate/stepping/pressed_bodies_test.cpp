// Bodies that prescribed motions press into others, which can't give way, and contacts whose forces are open.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/simulate/contact/contact_test_support.hpp>

using namespace momentree;
using namespace momentree::testing;

TEST_CASE(
    "pressed: a motion that goes through the floor and comes back is a warning, with the first time and the largest depth") {
  constexpr double amplitude = 0.5, above = 0.2, pi = std::numbers::pi;
  for (const char* method : {"rk4", "dop853", "stepping"}) {
    CAPTURE(method);
    Model model({.gravity = {0, 0, -g}});
    const BodyId ball = model.add({.name = "ball",
                                   .mass = 1,
                                   .inertia = diagonal(0.01),
                                   .at = {0, 0, above + 0.1},
                                   .joint = Prismatic{.axis = {0, 0, 1}, .drive = motion_drive(Signal::sine(amplitude, 0.5))}});
    model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
    model.add_collider({.plane = true});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(1.1));
    CHECK(sim.warnings().empty());
    Simulation branch = sim.branch();
    for (Simulation* each : {&sim, &branch}) {
      REQUIRE(each->run_until(2.1));
      CHECK(each->world().motions()[0].pose.position.z > above);
      const std::vector<std::string> warnings = each->warnings();
      REQUIRE(warnings.size() == 1);
      double time = 0, depth = 0;
      REQUIRE(std::sscanf(warnings[0].c_str(),
                          "from t = %lf s on 'ball' and 'ground' overlap by up to %lf m: a prescribed motion", &time,
                          &depth) == 2);
      CHECK(std::fabs(time - (1 + std::asin((above + 1e-3) / amplitude) / pi)) < 2e-3);
      CHECK(depth == doctest::Approx(amplitude - above).epsilon(1e-4));
    }
  }
}

TEST_CASE("pressed: two motions that cross each other name both bodies") {
  for (const char* method : {"rk4", "stepping"}) {
    Model model({.gravity = {}});
    for (const double side : {-1.0, 1.0}) {
      const BodyId body =
          model.add({.name = side < 0 ? "one" : "other",
                     .mass = 1,
                     .inertia = diagonal(0.01),
                     .at = {0.3 * side, 0.01 * side, 0},
                     .joint = Prismatic{.axis = {1, 0, 0}, .drive = motion_drive(Signal::sine(-0.25 * side, 0.5))}});
      model.add_collider({.body = body, .solid = contact::box({0.2, 0.2, 0.2})});
    }
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(1));
    REQUIRE(sim.warnings().size() == 1);
    double time = 0, depth = 0;
    CHECK(std::sscanf(sim.warnings()[0].c_str(), "from t = %lf s on 'one' and 'other' overlap by up to %lf m", &time, &depth) ==
          2);
    CHECK(std::fabs(time - std::asin(0.401 / 0.5) / std::numbers::pi) < 2e-3);
    CHECK(depth == doctest::Approx(0.1).epsilon(1e-4));
  }
}

TEST_CASE("open forces: those of four legs are marked, those of three without friction and of a ball are not") {
  const auto table = [](std::vector<Vec3> legs, double mu) {
    Model model({.gravity = {0, 0, -g}});
    const BodyId top =
        model.add({.name = "top", .mass = 2, .inertia = diagonal(0.1), .joint = Free{}, .q = {0, 0, 0.5, 1, 0, 0, 0}});
    for (const Vec3& leg : legs) model.add_collider({.body = top, .solid = contact::sphere(0.1, Pose(leg))});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = mu, .static_friction = mu}});
    Simulation sim(model, {.method = "rk4", .step = 1e-3});
    REQUIRE(sim.run_until(0.01));
    return sim.world().contacts();
  };
  const std::vector<Vec3> three{{0.3, 0, -0.4}, {-0.2, 0.2, -0.4}, {-0.2, -0.2, -0.4}};
  std::vector<Vec3> four = three;
  four.push_back({0.1, 0.3, -0.4});
  const auto marked = [](const std::vector<ContactPoint>& points) {
    std::size_t open = 0;
    for (const ContactPoint& point : points) open += point.determined == std::optional(false) ? 1 : 0;
    return open;
  };
  REQUIRE(table(three, 0).size() == 3);
  CHECK(marked(table(three, 0)) == 0);
  CHECK(marked(table(three, 0.5)) == 3);  // friction is open
  REQUIRE(table(four, 0).size() == 4);
  CHECK(marked(table(four, 0)) == 4);
  // A fourth leg that is in line with two others: the force of the third one follows from the moment about that line.
  std::vector<Vec3> in_line{{0.3, 0, -0.4}, {-0.2, 0.2, -0.4}, {-0.2, -0.2, -0.4}, {-0.2, 0.05, -0.4}};
  const std::vector<ContactPoint> points = table(in_line, 0);
  REQUIRE(points.size() == 4);
  CHECK(marked(points) == 3);
  for (const ContactPoint& point : points) {
    if (!*point.determined) continue;
    CHECK(point.point.x == doctest::Approx(0.3));
    CHECK(point.force.z == doctest::Approx(2 * g * 0.2 / 0.5));
  }
}

TEST_CASE("open forces: a joint that carries what redundant contacts leave open is marked, a joint beyond it is not") {
  for (const bool two_feet : {false, true}) {
    CAPTURE(two_feet);
    Model model({.gravity = {0, 0, -g}});
    const BodyId table = model.add({.name = "table", .mass = 2, .inertia = diagonal(0.1), .joint = Prismatic{.axis = z_axis}});
    const BodyId rider = model.add({.name = "rider", .mass = 1, .inertia = diagonal(0.1), .parent = table, .joint = Revolute{}});
    model.add_collider({.body = table, .solid = contact::sphere(0.1, Pose(Vec3{0.3, 0, 0.1}))});
    if (two_feet) model.add_collider({.body = table, .solid = contact::sphere(0.1, Pose(Vec3{-0.3, 0, 0.1}))});
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0, .static_friction = 0}});
    Simulation sim(model, {.method = "rk4", .step = 1e-3});
    REQUIRE(sim.run_until(0.01));
    const World& world = sim.world();
    CHECK(world.joint_forces({table.index}).determined == !two_feet);
    CHECK(world.joint_forces({rider.index}).determined);
    Vec3 force{}, torque{};
    for (const ContactPoint& point : world.contacts()) force += point.force, torque += cross(point.point, point.force);
    const Wrench reaction = world.joint_forces({table.index}).reaction;
    CHECK(norm(force + reaction.force - Vec3{0, 0, 3 * g}) < 1e-9 * g);
    CHECK(norm(torque + reaction.torque) < 1e-9 * g);
  }
}
