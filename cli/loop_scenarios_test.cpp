// The scenarios with closed loops in scenarios/, run by the program as a user would, with their physics checked.
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/math/vec.hpp>
#include <tests/scenario_run.hpp>

namespace momentree {
namespace {

using test::Json;
using test::Run;

using Table = std::map<std::string, std::vector<double>>;

/// A point of a body in the world, at row `k` of bodies.csv.
Vec3 point_of(const Table& bodies, const std::string& body, const Vec3& point, std::size_t k) {
  const auto at = [&](const char* column) { return bodies.at(body + column).at(k); };
  return Pose{{at(".x"), at(".y"), at(".z")}, {at(".qw"), at(".qx"), at(".qy"), at(".qz")}} * point;
}

}  // namespace

TEST_CASE("four_bar: the coupler breaks at its strength, and its rear half stays on the rocker") {
  const Run run("four_bar");
  REQUIRE(run.events.size() == 1);
  const Json& event = run.events[0];
  CHECK(event.at("event") == "strength of bar/middle");
  CHECK(event.at("before").at("loops").at("rank") == 3);
  CHECK_FALSE(event.at("after").contains("loops"));
  CHECK(std::fabs(event.at("lost").get<double>()) < 1e-12);
  CHECK(event.at("mechanisms").at("before") == event.at("mechanisms").at("after"));
  const Json& ball = run.final_state.at("joints").at("ball");
  CHECK_FALSE(ball.contains("loop"));
  CHECK(ball.at("parent") == "bar/rocker");
  CHECK(ball.at("child") == "bar/rear");
  const Table bodies = run.table("bodies.csv");
  for (std::size_t k = 0; k < bodies.at("time").size(); ++k)
    CHECK(norm(point_of(bodies, "bar/rear", {0.19, 0, 0}, k) - point_of(bodies, "bar/rocker", {0.25, 0, 0}, k)) < 1e-12);
  CHECK(std::fabs(run.energy("error")) < 1e-4);
  CHECK(std::fabs(run.energy("projection")) < 1e-6);
}

TEST_CASE("two_arms_hold_a_bar: they hold it level, and it swings down on the left arm") {
  const Run run("two_arms_hold_a_bar");
  REQUIRE(run.events.size() == 1);
  CHECK(std::fabs(run.energy("error")) < 1e-7);
  const Table bodies = run.table("bodies.csv"), joints = run.table("joints.csv");
  const std::vector<double>& time = bodies.at("time");
  for (std::size_t k = 0; k < time.size(); ++k) {
    const Vec3 left = point_of(bodies, "left/bar", {}, k), right = point_of(bodies, "left/bar", {0.6, 0, 0}, k);
    if (time[k] < 2) {  // everything is symmetric
      CHECK(std::fabs(left.z - right.z) < 1e-6);
      CHECK(std::fabs(left.x + right.x) < 1e-6);
      CHECK(norm(right - point_of(bodies, "right/fore", {0.4, 0, 0}, k)) < 1e-12);
    }
    CHECK(std::isnan(joints.at("right grip.q0")[k]) == (time[k] >= 2));
    CHECK(std::isnan(joints.at("right grip.p0")[k]));
  }
  CHECK(point_of(bodies, "left/bar", {0.6, 0, 0}, time.size() - 1).z < 0.1);
}

TEST_CASE("chain_to_ring: a ring, and a chain again that begins elsewhere") {
  const Run run("chain_to_ring");
  REQUIRE(run.events.size() == 3);
  CHECK(run.events[0].at("event") == "clasp");
  CHECK(run.events[0].at("after").at("loops").at("rows") == 5);
  CHECK(run.events[0].at("after").at("loops").at("rank") == 2);
  CHECK(run.events[0].at("lost").get<double>() > 0);
  CHECK(run.events[0].at("impulse").contains("clasp"));
  CHECK(run.events[2].at("event") == "cut");
  CHECK_FALSE(run.events[2].at("after").contains("loops"));
  CHECK(run.final_state.at("mechanisms").size() == 1);
  const Json& joints = run.final_state.at("joints");
  CHECK(joints.contains("clasp"));
  CHECK_FALSE(joints.contains("chain/8"));
  CHECK(std::fabs(run.energy("error")) < 1e-10);
}

TEST_CASE("excavator: the cylinders follow their plan; after the burst the boom sinks") {
  const Run run("excavator");
  REQUIRE(run.events.size() == 1);
  CHECK(std::fabs(run.energy("error")) < 1e-3);
  const Table bodies = run.table("bodies.csv"), joints = run.table("joints.csv");
  const std::vector<double>&time = bodies.at("time"), &rod = joints.at("digger/boom rod.q0"),
        &height = bodies.at("digger/bucket.z");
  std::size_t burst = 0;
  for (std::size_t k = 0; k < time.size(); ++k) {
    if (time[k] <= 5) burst = k;
    CHECK(norm(point_of(bodies, "digger/boom rod", {}, k) - point_of(bodies, "digger/boom", {1.3, 0, -0.1}, k)) < 1e-11);
    CHECK(norm(point_of(bodies, "digger/stick rod", {}, k) - point_of(bodies, "digger/stick", {-0.45, 0, 0.15}, k)) < 1e-11);
    CHECK(std::fabs(bodies.at("digger/bucket.y")[k]) < 1e-9);
  }
  CHECK(std::fabs(rod[burst] - 1.65) < 0.03);
  CHECK(height.back() < height[burst] - 0.3);
  for (const auto& [name, joint] : run.final_state.at("joints").items()) {
    CAPTURE(name);
    CHECK(joint.at("reaction").at("determined") == true);
  }
}

}  // namespace momentree
