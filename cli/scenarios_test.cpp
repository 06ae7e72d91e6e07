// Every file in scenarios/ is a test, too: run by the program as a user would, with its physics checked.
#include <cmath>
#include <map>
#include <numbers>
#include <set>
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
using test::vec;

/// The position of the outer end of the breaking chain, from row `k` of its table.
Vec3 tip(const std::map<std::string, std::vector<double>>& bodies, std::size_t k) {
  const auto at = [&](const char* column) { return bodies.at(std::string("chain/100.") + column).at(k); };
  return Pose{{at("x"), at("y"), at("z")}, {at("qw"), at("qx"), at("qy"), at("qz")}} * Vec3{0.05, 0, 0};
}

void check_break_of_the_chain(const Run& run) {
  REQUIRE(run.events.size() == 1);
  const Json& event = run.events[0];
  CHECK(event.at("time") == 1.8);
  CHECK(event.at("mechanisms").at("before") == Json{"chain"});
  CHECK(event.at("mechanisms").at("after") == Json{"chain", "chain/41"});
  const Json &before = event.at("before"), &after = event.at("after");
  for (const char* energy : {"kinetic", "potential"})
    CHECK(after.at(energy).get<double>() == doctest::Approx(before.at(energy).get<double>()).epsilon(1e-12));
  CHECK(norm(vec(after.at("linear")) - vec(before.at("linear"))) < 1e-12 * norm(vec(before.at("linear"))));
  CHECK(norm(vec(after.at("angular")) - vec(before.at("angular"))) < 1e-12 * norm(vec(before.at("angular"))));
  const Json& mechanisms = run.final_state.at("mechanisms");
  REQUIRE(mechanisms.size() == 2);
  CHECK(mechanisms[0].at("bodies").size() == 40);
  CHECK(mechanisms[1].at("bodies").size() == 60);
}

constexpr Vec3 tip_at_break{-3.78754545, 1.29043554, 0}, tip_at_end{-6.12448612, -4.14854984, 0};  // known to all digits

}  // namespace

TEST_CASE("breaking_chain: 40 links stay, 60 fly off; the paper's step costs about a joule") {
  const Run run("breaking_chain");
  check_break_of_the_chain(run);
  const auto bodies = run.table("bodies.csv");
  REQUIRE(bodies.at("time").size() == 151);
  CHECK(norm(tip(bodies, 90) - tip_at_break) < 5e-3);
  CHECK(norm(tip(bodies, 150) - tip_at_end) < 0.5);
  CHECK(std::abs(run.energy("error")) > 0.1);  // the error is reported, not hidden
  CHECK(std::abs(run.energy("error")) < 2);

  REQUIRE(run.command("view '" + run.path("") + "' --svg '" + run.path("chain.svg") + "' >/dev/null") == 0);
  const std::string svg = run.text("chain.svg");
  std::size_t frames = 0;
  for (std::size_t at = svg.find("<g opacity"); at != std::string::npos; at = svg.find("<g opacity", at + 1)) ++frames;
  CHECK(frames == 16);
  CHECK(svg.find("chain/41, from 1.8 s") != std::string::npos);
  CHECK(svg.size() < 100'000);
}

TEST_CASE("breaking_chain_accurate: the free end is at its reference position, the energy balance closes") {
  const Run run("breaking_chain_accurate");
  check_break_of_the_chain(run);
  const auto bodies = run.table("bodies.csv");
  CHECK(norm(tip(bodies, 90) - tip_at_break) < 1e-6);
  CHECK(norm(tip(bodies, 150) - tip_at_end) < 5e-5);
  CHECK(std::abs(run.energy("error")) < 2e-4);
  CHECK(run.energy("dissipated") > 0.01);
}

TEST_CASE("pendulum: it swings for as long as the elliptic integral says") {
  const Run run("pendulum");
  CHECK(std::abs(run.energy("error")) < 1e-9);
  const auto joints = run.table("joints.csv");
  const auto &time = joints.at("time"), &angle = joints.at("pendulum/pin.q0");
  CHECK(angle.front() == doctest::Approx(2 * std::numbers::pi / 3).epsilon(1e-15));
  std::vector<double> crossings;
  for (std::size_t k = 1; k < time.size(); ++k)
    if (angle[k - 1] * angle[k] < 0)
      crossings.push_back(time[k - 1] + (time[k] - time[k - 1]) * angle[k - 1] / (angle[k - 1] - angle[k]));
  REQUIRE(crossings.size() == 2);
  CHECK(crossings[1] - crossings[0] == doctest::Approx(0.5 * 2.248704928854736).epsilon(1e-5));
}

TEST_CASE("spinning_top: its spin and its angular momentum about the vertical are constant; it precesses") {
  const Run run("spinning_top");
  CHECK(std::abs(run.energy("error")) < 1e-8);
  const auto joints = run.table("joints.csv");
  for (const double spin : joints.at("top/tip.v2")) CHECK(spin == doctest::Approx(150).epsilon(1e-9));
  const double vertical = 4e-4 * 150 * std::sqrt(3.0) / 2;
  CHECK(vec(run.final_state.at("totals").at("angular")).z == doctest::Approx(vertical).epsilon(1e-9));

  const auto bodies = run.table("bodies.csv");
  double turned = 0, last = 0;
  for (std::size_t k = 0; k < bodies.at("time").size(); ++k) {
    const auto at = [&](const char* column) { return bodies.at(std::string("top/disk.") + column)[k]; };
    const Vec3 axis = rotation_matrix(Quat{at("qw"), at("qx"), at("qy"), at("qz")}) * Vec3{0, 0, 1};
    const double heading = std::atan2(axis.y, axis.x);
    if (k > 0) turned += std::remainder(heading - last, 2 * std::numbers::pi);
    last = heading;
    CHECK(std::acos(axis.z) > 29.9 * std::numbers::pi / 180);  // it never rises above its start
  }
  CHECK(turned > 8);  // m g l/(I spin) is 4.9 rad/s
  CHECK(turned < 13);
}

TEST_CASE("free_robot: without a force from outside there is no momentum, and the base turns nevertheless") {
  const Run run("free_robot");
  CHECK(std::abs(run.energy("error")) < 1e-8);
  CHECK(run.energy("work") > 0);
  CHECK(norm(vec(run.final_state.at("totals").at("linear"))) < 1e-10);
  CHECK(norm(vec(run.final_state.at("totals").at("angular"))) < 1e-10);
  const auto bodies = run.table("bodies.csv");
  Vec3 first{}, end{};  // mass times centre of mass
  for (const auto& [name, body] : run.model.at("bodies").items()) {
    const auto place = [&, prefix = name + "."](std::size_t k) {
      const auto at = [&](const char* c) { return bodies.at(prefix + c).at(k); };
      return Pose{{at("x"), at("y"), at("z")}, {at("qw"), at("qx"), at("qy"), at("qz")}};
    };
    first += body.at("mass").get<double>() * (place(0) * vec(body.at("com")));
    end += body.at("mass").get<double>() * (place(bodies.at("time").size() - 1) * vec(body.at("com")));
  }
  CHECK(norm(end - first) < 1e-8);
  CHECK(std::abs(bodies.at("robot/base.qw").back()) < std::cos(5 * std::numbers::pi / 180));  // by more than 10 degrees
  CHECK(std::abs(run.table("joints.csv").at("robot/shoulder.v0").back()) < 0.05);             // the arm has come to rest
}

TEST_CASE("falling_chimney: it breaks a third of its height above the ground, once, where the closed form says when") {
  const Run run("falling_chimney");
  REQUIRE(run.events.size() == 1);
  CHECK(run.events[0].at("actions") == Json{"break chimney/5"});  // 10 of 30 m
  CHECK(std::abs(run.events[0].at("time").get<double>() - 3.8829086443661773) < 1e-8);
  CHECK(run.events[0].at("mechanisms").at("after") == Json{"chimney", "chimney/5"});
  CHECK(std::abs(run.energy("error")) < 1e-10 * run.events[0].at("before").at("kinetic").get<double>());
}

TEST_CASE("tree_of_joints: all nine kinds, and the energy balance closes") {
  const Run run("tree_of_joints");
  CHECK(std::abs(run.energy("error")) < 1e-7);
  CHECK(run.energy("dissipated") > 1);
  std::set<std::string> kinds;
  for (const auto& [name, joint] : run.final_state.at("joints").items()) kinds.insert(joint.at("kind").get<std::string>());
  CHECK(kinds ==
        std::set<std::string>{"revolute", "prismatic", "helical", "cylindrical", "universal", "ball", "planar", "free", "weld"});
  REQUIRE(run.command("view '" + run.path("") + "' --svg '" + run.path("tree.svg") + "' --look 1,1,-1 >/dev/null") == 0);
}

TEST_CASE("crane: the trolley keeps to its plan, the rope parts at its strength, the load lands, slides and stays") {
  const Run run("crane");
  REQUIRE(run.events.size() > 2);
  CHECK(run.events[0].at("event") == "strength of crane/rope3");
  CHECK(run.events[1].at("event") == "impact landing");
  CHECK(std::fabs(run.energy("error")) < 1e-5);
  CHECK(run.energy("dissipated") > 500);
  const auto joints = run.table("joints.csv");
  const std::vector<double>& time = joints.at("time");
  for (const auto& [instant, position] : {std::pair{1.0, 0.5}, {2.0, 2.2}, {3.0, 4.6}, {3.6, 5.2}, {5.0, 5.2}})
    for (std::size_t k = 0; k < time.size(); ++k)
      if (std::fabs(time[k] - instant) < 1e-6) CHECK(joints.at("crane/rail.q0")[k] == doctest::Approx(position).epsilon(1e-9));
  // The gust has moved it sideways; it slides on from where it hits the ground, and lies flat and still in the end.
  const auto bodies = run.table("bodies.csv");
  CHECK(bodies.at("crane/load.y").back() > 0.05);
  CHECK(bodies.at("crane/load.x").back() > run.events[1].at("point").at(0).get<double>() + 0.9);  // a corner of 1.8 m × 1.8 m
  CHECK(bodies.at("crane/load.z").back() == doctest::Approx(1.5).epsilon(1e-9));
  const std::size_t last = time.size() - 1;
  for (std::size_t k = last - 50; k < last; ++k)
    CHECK(std::fabs(bodies.at("crane/load.x")[k] - bodies.at("crane/load.x")[last]) < 1e-12);
}

TEST_CASE("guyed_mast: the guys hold it in the wind, the west one parts at its strength, the mast stays where it lands") {
  const Run run("guyed_mast");
  REQUIRE(run.events.size() == 2);
  CHECK(run.events[0].at("event") == "strength of west guy");
  CHECK(run.events[0].at("actions") == Json{"break west guy"});
  CHECK(run.events[0].at("changes")[0].at("spring") == "west guy");
  CHECK(run.events[0].at("topology").at("broken_springs") == Json{"west guy"});
  CHECK(run.events[0].at("released").get<double>() == doctest::Approx(0.5 * 1e8 / 250e3).epsilon(0.05));  // but for its damper
  CHECK(run.events[1].at("event") == "lands");
  CHECK(std::fabs(run.energy("error")) < 1e-2);
  const auto springs = run.table("springs.csv"), bodies = run.table("bodies.csv");
  const double parts = run.events[0].at("time");
  const std::vector<double>& time = springs.at("time");
  for (std::size_t k = 0; k < time.size(); ++k) {
    CHECK(springs.at("north guy.tension")[k] >= 0);
    CHECK(std::isnan(springs.at("west guy.tension")[k]) == (time[k] >= parts));
    if (time[k] >= parts) continue;
    CHECK(springs.at("west guy.tension")[k] < 10e3);
    CHECK(std::fabs(bodies.at("mast/pole.qw")[k]) > std::cos(0.5 * std::numbers::pi / 180));  // upright to a degree
  }
  CHECK(springs.at("north guy.tension")[0] == doctest::Approx(5e3).epsilon(0.1));
  CHECK(run.final_state.at("springs").at("west guy").at("broken") == true);
  CHECK(run.final_state.at("springs").at("north guy").at("broken") == false);
  REQUIRE(run.command("view '" + run.path("") + "' --svg '" + run.path("mast.svg") + "' >/dev/null") == 0);
}

TEST_CASE("servo_arm: soft stops give way a little, a jam holds, the motors bring the arm to its target") {
  const Run run("servo_arm");
  REQUIRE(run.events.size() == 2);
  CHECK(std::fabs(run.energy("error")) < 1e-4);
  const auto joints = run.table("joints.csv");
  const std::vector<double>&time = joints.at("time"), &elbow = joints.at("arm/elbow.q0");
  const double deg = std::numbers::pi / 180;
  double highest = -10, jam = NAN;
  for (std::size_t k = 0; k < time.size(); ++k) {
    highest = std::max(highest, elbow[k]);
    if (time[k] < 4.0 - 1e-6 || time[k] > 5.1 - 1e-6) continue;
    if (std::isnan(jam)) jam = elbow[k];
    CHECK(elbow[k] == jam);
  }
  CHECK(highest > 45 * deg);  // on the rubber stop
  CHECK(highest < 48 * deg);  // 35 N m against 2 kN m/rad, and the forearm's swing
  // The column turns to its target, except for friction: 3 N m against 600 N m/rad.
  for (std::size_t k = 0; k < time.size(); ++k)
    if (std::fabs(time[k] - 4.9) < 1e-6) CHECK(std::fabs(joints.at("arm/turn.q0")[k] - 50 * deg) < 0.01);
}

}  // namespace momentree
