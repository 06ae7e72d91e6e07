// The robot models in scenarios/models, each in a separate scenario whose physics is checked, and directly with every command.
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include <doctest/doctest.h>

#include <tests/scenario_run.hpp>

namespace momentree {
namespace {

using test::Json;
using test::Run;
using test::vec;

/// The certificates of an event of that name.
std::vector<Json> events_named(const Run& run, const std::string& name) {
  std::vector<Json> found;
  for (const Json& event : run.events)
    if (event.at("event") == name) found.push_back(event);
  return found;
}

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

}  // namespace

TEST_CASE("panda_lets_go: the hand separates when its joint transmits 6 N m, and keeps energy and momentum") {
  const Run run("panda_lets_go");
  const auto overload = events_named(run, "overload");
  REQUIRE(overload.size() == 1);
  CHECK(overload[0].at("mechanisms").at("after") == Json{"panda", "panda/panda_hand"});
  CHECK(overload[0].at("time") > 0.9);
  CHECK(overload[0].at("time") < 1.3);
  const Json &before = overload[0].at("before"), &after = overload[0].at("after");
  CHECK(after.at("kinetic").get<double>() == doctest::Approx(before.at("kinetic").get<double>()).epsilon(1e-12));
  CHECK(norm(vec(after.at("linear")) - vec(before.at("linear"))) < 1e-12);
  CHECK(std::fabs(run.energy("error")) < 1e-4);
  // The hand, its tool point and both fingers separate together; the arm stays.
  for (const Json& mechanism : run.final_state.at("mechanisms"))
    CHECK(mechanism.at("bodies").size() == (mechanism.at("name") == "panda" ? 9 : 4));
  CHECK(std::fabs(degrees(run.final_state.at("joints").at("panda/panda_joint2").at("q")[0].get<double>()) + 45) < 5);
}

TEST_CASE("quadruped_knee: in flight the centre of mass keeps its parabola, the jammed knee its angle") {
  const Run run("quadruped_knee");
  const auto jam = events_named(run, "jam");
  REQUIRE(jam.size() == 1);
  CHECK(jam[0].at("after").at("kinetic").get<double>() < jam[0].at("before").at("kinetic").get<double>());
  CHECK(norm(vec(jam[0].at("after").at("angular")) - vec(jam[0].at("before").at("angular"))) < 1e-10);
  CHECK(std::fabs(run.energy("error")) < 1e-5);
  const auto joints = run.table("joints.csv");
  double jammed = NAN, least = 10, most = -10;
  for (std::size_t k = 0; k < joints.at("time").size(); ++k) {
    const double other = joints.at("anymal/RF_KFE.q0")[k];
    least = std::min(least, other), most = std::max(most, other);
    if (joints.at("time")[k] < 0.4 - 1e-9) continue;
    const double knee = joints.at("anymal/LF_KFE.q0")[k];
    if (std::isnan(jammed)) jammed = knee;
    CHECK(knee == jammed);
  }
  CHECK(degrees(most - least) > 40);
  // Gravity is the only external force: m v changes by m g t, and the angular momentum about the centre of mass is constant.
  double mass = 0;
  for (const auto& [name, body] : run.model.at("bodies").items()) mass += body.at("mass").get<double>();
  const Vec3 first = vec(run.events.front().at("before").at("linear")), last = vec(run.final_state.at("totals").at("linear"));
  CHECK(norm(last - first - Vec3{0, 0, -mass * 9.81}) < 1e-9 * norm(first));
}

TEST_CASE("ur5_power_cut: it holds, falls, and its shoulder is caught; the elbow continues to fall") {
  const Run run("ur5_power_cut");
  REQUIRE(events_named(run, "brake").size() == 1);
  CHECK(events_named(run, "brake")[0].at("time").get<double>() == doctest::Approx(0.65).epsilon(1e-12));
  CHECK(std::fabs(run.energy("error")) < 1e-6);
  CHECK(run.energy("lost_in_impacts") > 0.5);
  const auto joints = run.table("joints.csv");
  const auto& lift = joints.at("ur5/shoulder_lift_joint.q0");
  for (std::size_t k = 0; k < lift.size(); ++k)
    if (joints.at("time")[k] > 0.66) CHECK(lift[k] == lift.back());
  const auto& elbow = joints.at("ur5/elbow_joint.q0");
  CHECK(std::fabs(degrees(elbow.back() - elbow.front())) > 20);
}

TEST_CASE("humanoid_wave: it has no momentum, before or after its elbow wears out, and turns nevertheless") {
  const Run run("humanoid_wave");
  REQUIRE(events_named(run, "worn out").size() == 1);
  CHECK(events_named(run, "worn out")[0].at("after").at("kinetic").get<double>() ==
        doctest::Approx(events_named(run, "worn out")[0].at("before").at("kinetic").get<double>()).epsilon(1e-12));
  CHECK(run.final_state.at("joints").at("humanoid/RARM_ELBOW").at("kind") == "ball");
  CHECK(norm(vec(run.final_state.at("totals").at("linear"))) < 1e-8);
  CHECK(norm(vec(run.final_state.at("totals").at("angular"))) < 1e-8);
  CHECK(std::fabs(run.energy("error")) < 1e-5);
  double upright = 1;
  for (const double w : run.table("bodies.csv").at("humanoid/base_link.qw")) upright = std::min(upright, std::fabs(w));
  CHECK(degrees(2 * std::acos(upright)) > 5);
}

TEST_CASE("humanoid_loses_a_forearm: what flies apart keeps its momentum, and the springs of its joints their energy") {
  const Run run("humanoid_loses_a_forearm");
  const auto torn = events_named(run, "torn off");
  REQUIRE(torn.size() == 1);
  CHECK(torn[0].at("mechanisms").at("after") == Json{"humanoid", "humanoid/lower_arm_right"});
  CHECK(norm(vec(torn[0].at("after").at("linear")) - vec(torn[0].at("before").at("linear"))) < 1e-11);
  CHECK(norm(vec(torn[0].at("after").at("angular")) - vec(torn[0].at("before").at("angular"))) < 1e-11);
  CHECK(std::fabs(run.energy("error")) < 1e-6);
  for (const Json& mechanism : run.final_state.at("mechanisms"))
    CHECK(mechanism.at("bodies").size() == (mechanism.at("name") == "humanoid" ? 23 : 2));
  // Gravity is the only external force.
  double mass = 0;
  for (const auto& [name, body] : run.model.at("bodies").items()) mass += body.at("mass").get<double>();
  const Vec3 last = vec(run.final_state.at("totals").at("linear")), then = vec(torn[0].at("after").at("linear"));
  CHECK(norm(last - then - Vec3{0, 0, -0.5 * mass * 9.81}) < 1e-9 * norm(then));
}

TEST_CASE("double_pendulum: the second arm leaves, and flies by gravity alone") {
  const Run run("double_pendulum");
  const auto fails = events_named(run, "axle fails");
  REQUIRE(fails.size() == 1);
  CHECK(fails[0].at("mechanisms").at("after") == Json{"pendulum", "pendulum/link2"});
  CHECK(std::fabs(run.energy("error")) < 1e-8);
}

TEST_CASE("iiwa_falls_to_its_stops: no joint passes the limits of its file") {
  const Run run("iiwa_falls_to_its_stops");
  CHECK(run.energy("lost_in_impacts") > 10);
  CHECK(std::fabs(run.energy("error")) < 5e-3);
  const auto joints = run.table("joints.csv");
  const double deg = std::numbers::pi / 180, limits[] = {170, 120, 170, 120, 170, 120, 175};
  for (int k = 1; k <= 7; ++k)
    for (const double q : joints.at("iiwa/iiwa_joint_" + std::to_string(k) + ".q0"))
      CHECK(std::fabs(q) <= limits[k - 1] * deg + 1e-9);
  const auto& brake = joints.at("iiwa/iiwa_joint_6.q0");
  CHECK(brake[brake.size() - 2] == brake.back());
}

TEST_CASE("arm_loses_its_grinder: the mount breaks, and the machine leaves with its momentum and energy") {
  const Run run("arm_loses_its_grinder");
  const auto breaks = events_named(run, "the mount breaks");
  REQUIRE(breaks.size() == 1);
  CHECK(breaks[0].at("mechanisms").at("after") == Json{"arm", "arm/grinder"});
  const Json &before = breaks[0].at("before"), &after = breaks[0].at("after");
  CHECK(after.at("kinetic").get<double>() == doctest::Approx(before.at("kinetic").get<double>()).epsilon(1e-12));
  CHECK(norm(vec(after.at("linear")) - vec(before.at("linear"))) < 1e-12);
}

}  // namespace momentree
