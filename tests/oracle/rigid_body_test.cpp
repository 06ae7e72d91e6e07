// Free bodies, tops and a floating robot against closed forms.
#include <cmath>
#include <numbers>

#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

constexpr double degree = std::numbers::pi / 180;

Model turning_body(Kind kind, Vec3 w) {
  Model model({.gravity = {0, 0, 0}});
  BodySpec body{.name = "b", .mass = 1, .inertia = diagonal(1, 2, 3), .joint = joint_of(kind)};
  body.v = kind == Kind::free ? Values{0, 0, 0, w.x, w.y, w.z} : Values{w.x, w.y, w.z};
  model.add(body);
  return model;
}
/// Angular velocity in body axes.
Vec3 spin(const Simulation& run, Kind kind) {
  const auto v = run.world().joint({0}).v.subspan(kind == Kind::free ? 3 : 0);
  return {v[0], v[1], v[2]};
}

/// The top of the reference, its axis tilted about x.
Model top(double tilt, Vec3 w) {
  Model model;
  model.add({.name = "top",
             .mass = 1,
             .com = {0, 0, 0.1},
             .inertia = diagonal(0.002, 0.002, 0.004),
             .joint = joint_of(Kind::ball),
             .q = {std::cos(tilt / 2), std::sin(tilt / 2), 0, 0},
             .v = {w.x, w.y, w.z}});
  return model;
}
Vec3 axis_of(const Simulation& run) { return rotation_matrix(run.world().motions()[0].pose.rotation) * Vec3{0, 0, 1}; }
/// Angle from a to b about the vertical, in (−π, π].
double azimuth(const Vec3& a, const Vec3& b) { return std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y); }

}  // namespace

TEST_CASE("a body free of torque, on a ball joint and free") {
  const auto data = reference("closed_forms.json")["torque_free_rigid_body"];
  for (const Kind kind : {Kind::ball, Kind::free}) {
    CAPTURE(static_cast<int>(kind));
    Simulation run(turning_body(kind, {1, 0, 1}), {.step = 1e-3});
    for (const auto& row : data["values"]) {
      REQUIRE(run.run_until(row["t"]) == Status::ok);
      CAPTURE(run.time());
      check_near(spin(run, kind), vec3_of(row["w"]), 1e-8, "angular velocity");
      if (!row.contains("quat_body_to_world_wxyz")) continue;
      const double off = apart(run.world().motions()[0].pose.rotation, quat_of(row["quat_body_to_world_wxyz"]));
      INFO("attitude off by " << off);
      CHECK(off <= 1e-8);
    }
  }
}

TEST_CASE("Dzhanibekov's flip") {
  const auto data = reference("closed_forms.json")["dzhanibekov_flip"];
  REQUIRE(data["values"].size() == 4);
  for (const auto& row : data["values"]) {
    const double eps = row["eps"], flip = row["flip_time"];
    CAPTURE(eps);
    Simulation run(turning_body(Kind::free, {0, 1, eps}), {.step = 1e-3});
    // Halfway, the middle component passes zero: divided by its rate ẇ2 = (I3 − I1)/I2 w3 w1 it is the time error.
    REQUIRE(run.run_until(flip / 2) == Status::ok);
    const Vec3 half = spin(run, Kind::free);
    check_near(half.y / (half.z * half.x), 0, 1e-8, "lateness half way");
    REQUIRE(run.run_until(flip) == Status::ok);
    const Vec3 w = spin(run, Kind::free);
    check_near(w.y, -1, 1e-8, "turned over");
    // There w1 passes zero, at the rate (I2 − I3)/I1 w2 w3. A round-off error from halfway has grown by 1/eps by then and is
    // compared with eps: beyond 1e-3 this is meaningless in double precision.
    if (eps >= 1e-3) check_near(w.x / (-w.y * w.z), 0, 1e-8, "lateness");
  }
}

TEST_CASE("steady precession of a heavy top, slow and fast") {
  const auto data = reference("closed_forms.json")["heavy_symmetric_top"];
  REQUIRE(data["steady"].size() == 3);
  for (const auto& row : data["steady"])
    for (const char* branch : {"slow", "fast"}) {
      const double spin3 = row["omega3"], tilt = row["theta_deg"].get<double>() * degree, rate = row[branch];
      CAPTURE(spin3);
      CAPTURE(branch);
      Simulation run(top(tilt, {0, rate * std::sin(tilt), spin3}), {.step = 1e-5});
      const Vec3 start = axis_of(run);
      const double turn = 0.25;  // s
      REQUIRE(run.run_until(turn) == Status::ok);
      const Vec3 end = axis_of(run);
      check_near(end.z, std::cos(tilt), 1e-8, "cosine of the tilt");
      check_near(std::remainder(azimuth(start, end) - rate * turn, 2 * std::numbers::pi), 0, 1e-8, "precession");
    }
}

TEST_CASE("nutation of a heavy top released at rest") {
  const auto data = reference("closed_forms.json")["heavy_symmetric_top"];
  REQUIRE(data["nutation"].size() == 3);
  for (const auto& row : data["nutation"]) {
    const double spin3 = row["omega3"], period = row["nutation_period"], tilt = row["theta_min_deg"].get<double>() * degree;
    CAPTURE(spin3);
    Simulation run(top(tilt, {0, 0, spin3}), {.step = 1e-5});
    const Vec3 start = axis_of(run);
    REQUIRE(run.run_until(period / 2) == Status::ok);
    check_near(std::acos(axis_of(run).z) / degree, row["theta_max_deg"], 1e-8, "largest tilt");
    REQUIRE(run.run_until(period) == Status::ok);
    const Vec3 end = axis_of(run);
    check_near(std::acos(end.z), tilt, 1e-8, "smallest tilt");
    // The tilt's rate vanishes there, and its acceleration is m g l sin θ / A.
    const double acceleration = 9.81 * 0.1 * std::sin(tilt) / 0.012;
    const double tilt_rate = -cross(run.world().motions()[0].angular, end).z / std::sin(tilt);
    check_near(tilt_rate / acceleration, 0, 1e-8, "lateness");
    check_near(azimuth(start, end), row["precession_per_nutation_rad"], 1e-8, "precession");
  }
}

TEST_CASE("a floating robot without momentum turns as its arm does") {
  const auto data = reference("closed_forms.json")["free_floating_robot_zero_momentum"];
  Model model({.gravity = {0, 0, 0}});
  // Planar motion about z: the hinge 1 m from the centre of the base, the arm's centre 0.8 m beyond it.
  const BodyId base = model.add({.name = "base", .mass = 50, .inertia = diagonal(10), .joint = joint_of(Kind::free)});
  const BodyId arm = model.add({.name = "arm",
                                .mass = 10,
                                .com = {0.8, 0, 0},
                                .inertia = diagonal(2),
                                .parent = base,
                                .at = {1, 0, 0},
                                .joint = joint_of(Kind::revolute)});
  Simulation run(model, {.step = 1e-3});
  const JointStart starts[] = {{{base.index}, {}, {}, {0, 0, 0, 0, 0, 0}}, {{arm.index}, {}, {}, {2.0}}};
  run.restore(0, {}, starts);
  for (const auto& row : data["values"]) {
    const double goal = row["dq"];
    for (;;) {
      const JointView hinge = run.world().joint({arm.index});
      const double ahead = (goal - hinge.q[0]) / hinge.v[0];
      REQUIRE(hinge.v[0] > 0);
      if (ahead < 1e-12) break;
      REQUIRE(run.step(std::min(ahead, 1e-3)) == Status::ok);
    }
    const JointView hinge = run.world().joint({arm.index});
    CAPTURE(goal);
    check_near(hinge.q[0], goal, 1e-11, "hinge");
    const BodyMotion& m = run.world().motions()[0];
    const double turned = 2 * std::atan2(m.pose.rotation.z, m.pose.rotation.w);
    check_near(turned, row["base_rotation"], 1e-8, "turn of the base");
    const Totals sum = run.world().totals();
    check_near(norm(sum.linear) + norm(sum.angular), 0, 1e-11, "momentum");
  }
}
