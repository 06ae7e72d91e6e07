// A pendulum breaks when the tension in its joint reaches a threshold: the instant is checked against an elliptic integral, the
// flight against the parabola. The remaining error of the instant is that of the trajectory.
#include <cmath>
#include <string>

#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

constexpr double g = 9.81;

struct Case {
  nlohmann::json data = reference("pendulum_break.json");
  double threshold = data["threshold_force"];
  double time = std::stod(data["break_time"].get<std::string>());
  double angle = std::stod(data["break_angle_from_hanging"].get<std::string>());

  Model model() const {
    const auto& body = data["model"]["bodies"][0];
    const auto& j = body["inertia"];
    Model model({.gravity = vec3_of(data["model"]["gravity"])});
    model.add({.name = "rod",
               .mass = body["mass"],
               .com = vec3_of(body["com"]),
               .inertia = diagonal(j[0][0], j[1][1], j[2][2]),
               .joint = joint_of(Kind::revolute, vec3_of(body["joint"]["axis"])),
               .q = data["initial"]["q"][0].get<double>()});
    return model;
  }

  /// Rate of the tension at that instant (N/s): from J φ̈ = −m g l sin φ and the energy.
  double slope() const {
    const auto& body = data["model"]["bodies"][0];
    const double m = body["mass"], l = body["com"][0], J = body["inertia"][2][2].get<double>() + m * l * l;
    const double start = std::acos(0.0) + data["initial"]["q"][0].get<double>();  // from the hanging position
    const double k = m * g * l / J, rate = -std::sqrt(2 * k * (std::cos(angle) - std::cos(start)));
    const double along = m * (l * rate * rate + g * std::cos(angle)), across = m * g * std::sin(angle) * (1 - m * l * l / J);
    REQUIRE(std::abs(std::hypot(along, across) - threshold) < 1e-12);
    const double along_rate = m * (-2 * l * k * std::sin(angle) - g * std::sin(angle)) * rate,
                 across_rate = m * g * std::cos(angle) * (1 - m * l * l / J) * rate;
    return (along * along_rate + across * across_rate) / threshold;
  }
};

double tension(const World& world) { return norm(world.joint_forces({0}).reaction.force); }

Simulation breaking(const Case& the, const Integration& how) {
  Simulation run(the.model(), how);
  run.when(reaction_force("rod").exceeds(the.threshold)).then(break_joint("rod"));
  return run;
}

}  // namespace

TEST_CASE("a pendulum breaks at the instant of the closed form and flies off on its parabola") {
  const Case the;
  const auto& start = the.data["samples"][2]["world_pose"]["b1"];  // after the break
  const auto& last = the.data["samples"][3];
  const Vec3 com = vec3_of(start["com"]), velocity = vec3_of(start["vel"]), spin = vec3_of(start["omega"]);
  for (const Integration& how :
       {Integration{.step = 1e-3}, Integration{.step = 5e-3}, Integration{.method = "dopri5", .rtol = 1e-12, .atol = 1e-12}}) {
    CAPTURE(how.method);
    CAPTURE(how.step);
    Simulation run = breaking(the, how);
    int rows = 0;
    double off = 0, turned = 0;
    run.observe(0.02, [&](const World& world) {
      const double t = world.time() - the.time;
      if (t < 1e-6) return true;
      ++rows;
      const BodyMotion& m = world.motions()[0];
      const Vec3 arm = rotation_matrix(m.pose.rotation) * world.model()[{0}].com;
      off = std::max(off, apart(m.pose.position + arm, com + t * velocity + Vec3{0, -g / 2 * t * t, 0}));
      turned = std::max(turned, apart(m.angular, spin));
      off = std::max(off, apart(m.linear + cross(m.angular, arm), velocity + Vec3{0, -g * t, 0}));
      return true;
    });
    REQUIRE(run.run_until(last["t"]) == Status::ok);
    REQUIRE(run.events().size() == 1);
    check_near(run.events()[0].time, the.time, 1e-9, "instant of the break");
    MESSAGE(how.method << " at " << how.step << ": the break is " << run.events()[0].time - the.time
                       << " s late, the flight off by " << off << " m or m/s, " << turned << " rad/s");
    CHECK(rows > 30);
    CHECK(off < 3e-8);  // at 5 ms it is the error of the steps in flight: the rod's origin rotates about its centre
    CHECK(turned < 1e-8);
    check_near(run.world().motions()[0].pose.position +
                   rotation_matrix(run.world().motions()[0].pose.rotation) * run.world().model()[{0}].com,
               vec3_of(last["world_pose"]["b1"]["com"]), 2e-8, "place of the centre of mass at the end");
    CHECK(apart(run.world().motions()[0].pose.rotation, quat_of(last["world_pose"]["b1"]["quat"])) < 2e-8);
  }
}

TEST_CASE("at a step of 20 ms the error of the event time is that of the trajectory") {
  const Case the;
  Simulation located = breaking(the, {.step = 0.02});
  REQUIRE(located.run_until(0.4) == Status::ok);
  REQUIRE(located.events().size() == 1);
  Simulation free(the.model(), {.step = 0.02});  // the same trajectory, without the event
  REQUIRE(free.run_until(the.time) == Status::ok);
  const double wrong = tension(free.world()) - the.threshold, late = located.events()[0].time - the.time;
  MESSAGE("tension wrong by " << wrong << " N, rising by " << the.slope() << " N/s; the break is " << late << " s late");
  CHECK(std::abs(late) > 1e-9);  // otherwise there is nothing to observe
  check_near(late, -wrong / the.slope(), 2e-10, "lateness");
}
