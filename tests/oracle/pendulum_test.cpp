// Pendulums against closed forms.
#include <cmath>
#include <numbers>
#include <string>

#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

constexpr double degree = std::numbers::pi / 180;

/// A point mass of 1 kg at 1 m below a revolute joint; the angle is measured from the downward vertical.
Model pendulum(double angle) {
  Model model({.gravity = {0, -9.81, 0}});
  model.add({.name = "p", .mass = 1, .com = {0, -1, 0}, .joint = joint_of(Kind::revolute), .q = angle});
  return model;
}
double q(const Simulation& run, int body, int i = 0) { return run.world().joint({body}).q[static_cast<std::size_t>(i)]; }
double v(const Simulation& run, int body, int i = 0) { return run.world().joint({body}).v[static_cast<std::size_t>(i)]; }

}  // namespace

TEST_CASE("the simple pendulum of the benchmark library, 2,000 s") {
  const auto data = reference("closed_forms.json")["A01_simple_pendulum"];
  Simulation run(pendulum(90 * degree), {.step = 4e-4});
  for (const auto& row : data["values"]) {
    const double t = row["t"];
    REQUIRE(run.run_until(t) == Status::ok);
    CAPTURE(t);
    check_near(q(run, 0), row["theta"], 1e-8, "angle");
    check_near(v(run, 0), row["thetadot"], 1e-8, "rate");
    check_near(std::sin(q(run, 0)), row["x"], 1e-8, "x");
    check_near(-std::cos(q(run, 0)), row["y"], 1e-8, "y");
  }
}

TEST_CASE("periods of the pendulum from 1 to 179 degrees") {
  const auto data = reference("closed_forms.json")["pendulum_periods"];
  int amplitudes = 0;
  for (const auto& row : data["values"].items()) {
    const std::string name = row.key();  // "30deg"
    CAPTURE(name);
    const double amplitude = std::stod(name) * degree, T = row.value();
    Simulation run(pendulum(amplitude), {.step = 1e-4});
    // Through the vertical after a quarter and after nine quarters of a period: the angle there is the time error times the rate.
    for (const int quarters : {1, 9}) {
      REQUIRE(run.run_until(quarters * T / 4) == Status::ok);
      const double late = q(run, 0) / v(run, 0);
      check_near(T + 4 * late / quarters, T, 1e-8, "period");
    }
    ++amplitudes;
  }
  CHECK(amplitudes == 8);
}

TEST_CASE("the double pendulum of point masses") {
  const auto data = reference("closed_forms.json")["double_pendulum_point"];
  Model model({.gravity = {0, -9.81, 0}});
  const BodyId upper =
      model.add({.name = "1", .mass = 1, .com = {0, -1, 0}, .joint = joint_of(Kind::revolute), .q = 90 * degree});
  model.add({.name = "2", .mass = 1, .com = {0, -1, 0}, .parent = upper, .at = {0, -1, 0}, .joint = joint_of(Kind::revolute)});
  Simulation run(model, {.step = 1e-4});
  for (const auto& row : data["values"]) {
    REQUIRE(run.run_until(row["t"]) == Status::ok);
    CAPTURE(run.time());
    check_near(q(run, 0), row["th1"], 1e-8, "first angle");
    check_near(q(run, 0) + q(run, 1), row["th2"], 1e-8, "second angle");
    check_near(v(run, 0), row["w1"], 1e-8, "first rate");
    check_near(v(run, 0) + v(run, 1), row["w2"], 1e-8, "second rate");
    const Vec3 tip = run.world().motions()[1].pose * Vec3{0, -1, 0};
    check_near(tip, {row["tip"][0], row["tip"][1], 0}, 1e-8, "tip");
  }
}

TEST_CASE("the spherical pendulum, from one extreme to the next") {
  const auto data = reference("closed_forms.json")["spherical_pendulum"];
  const double g = 9.81;
  for (const auto& row : data["values"]) {
    const double v0 = row["v0"];
    CAPTURE(v0);
    Model model;
    model.add({.name = "p",
               .mass = 1,
               .com = {0, 0, -1},
               .joint = joint_of(Kind::universal, x_axis, y_axis),
               .q = {0, 60 * degree},
               .v = {v0 / 0.5, 0}});
    Simulation run(model, {.step = 5e-5});
    const double half = row["half_period"];
    const Vec3 start = run.world().motions()[0].pose * Vec3{0, 0, -1};
    REQUIRE(run.run_until(half) == Status::ok);
    const BodyMotion& m = run.world().motions()[0];
    const Vec3 end = m.pose * Vec3{0, 0, -1};
    check_near(-start.z, row["z_min"], 1e-12, "start");
    check_near(-end.z, row["z_max"], 1e-8, "extreme");
    // The height is stationary there: its rate divided by its acceleration is the time error. z is measured downwards from the
    // pivot.
    const double z = -end.z, zdot = -cross(m.angular, end).z, energy = v0 * v0 / 2 - g * 0.5;
    const double acceleration = g * (1 - z * z) - 2 * z * (energy + g * z);
    check_near(zdot / acceleration, 0, 1e-8, "lateness");
    const double azimuth = std::abs(std::atan2(start.x * end.y - start.y * end.x, start.x * end.x + start.y * end.y));
    check_near(azimuth, row["apsidal_angle_rad"], 1e-8, "apsidal angle");
  }
}
