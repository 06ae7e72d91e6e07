// The scenarios with contact in scenarios/, run by the program as a user would, with their physics checked.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <tests/scenario_run.hpp>

namespace momentree {
namespace {

using test::Json;
using test::Run;

std::vector<Json> named(const Run& run, const std::string& event) {
  std::vector<Json> found;
  std::copy_if(run.events.begin(), run.events.end(), std::back_inserter(found),
               [&](const Json& each) { return each.at("event") == event; });
  return found;
}

double time_of(const Json& event) { return event.at("time").get<double>(); }

/// The share of its speed that a system keeps, of which all kinetic energy is that of one rotation.
double kept(const Json& impact) {
  return std::sqrt(impact.at("after").at("kinetic").get<double>() / impact.at("before").at("kinetic").get<double>());
}

double speed_of(const Json& state, const std::string& body) {
  return norm(test::vec(state.at("bodies").at(body).at("linear"))) + norm(test::vec(state.at("bodies").at(body).at("angular")));
}

/// Lean and steer (rad) of the bicycle at that speed every 10 ms, after it was pushed over by that rate.
struct Ride {
  Run run;
  std::vector<double> lean, steer;
  Ride(double speed, double push, int seconds)
      : run("bicycle", [&] {
          char text[512];
          std::snprintf(text, sizeof text,
                        "--set mechanism.bicycle.state.velocity='{linear=[%.17g,0,0],angular=[%g,0,0]}' "
                        "--set mechanism.bicycle.state.joints='{rear={v=%.17g},front={v=%.17g}}' "
                        "--set integrate='{method=\"dop853\",until=%d,rtol=1e-12,atol=1e-14}' --set output.every=0.01",
                        speed, push, speed / 0.3, speed / 0.35, seconds);
          return std::string(text);
        }()) {
    const auto bodies = run.table("bodies.csv");
    const auto of = [&](const char* key, std::size_t k) { return bodies.at(std::string("bicycle/frame.") + key).at(k); };
    for (std::size_t k = 0; k < bodies.at("time").size(); ++k)
      lean.push_back(std::asin(2 * (of("qw", k) * of("qx", k) + of("qy", k) * of("qz", k))));
    steer = run.table("joints.csv").at("bicycle/steer.q0");
  }
  /// The largest lean of a second.
  double most(int second) const {
    double found = 0;
    for (std::size_t k = 0; k < 100; ++k) found = std::max(found, std::fabs(lean.at(100 * static_cast<std::size_t>(second) + k)));
    return found;
  }
};

}  // namespace

TEST_CASE("rocking_block: each impact keeps the share of the speed that Housner gives, and it comes to stand again") {
  const Run run("rocking_block");
  const double housner = 1 - 1.5 * 0.1;  // 1 − 3/2 sin²α, tan α = 1/3
  int impacts = 0;
  for (const Json& impact : named(run, "impact")) {
    if (time_of(impact) < 0.8 || impact.at("before").at("kinetic").get<double>() < 1e-6)
      continue;  // the table moves, or round-off
    CHECK(kept(impact) == doctest::Approx(housner).epsilon(1e-9));
    ++impacts;
  }
  CHECK(impacts > 20);
  for (const Json& slip : named(run, "slip")) CHECK(slip.at("before").at("kinetic").get<double>() < 1e-20);  // round-off at rest
  CHECK(speed_of(run.final_state, "block/block") < 1e-10);
  CHECK(std::abs(run.energy("final") - run.energy("initial")) < 1e-6);
  CHECK(run.energy("work") == doctest::Approx(run.energy("lost_in_impacts")).epsilon(1e-9));
  CHECK(std::abs(run.energy("error")) < 1e-8);
}

TEST_CASE("rimless_wheel: a step keeps the share of the speed that the angular momentum about the new foot gives") {
  const Run run("rimless_wheel");
  const double half = std::numbers::pi / 12, height = 0.98 * std::cos(half) + 0.02, side = 0.98 * std::sin(half);
  const double share = (1.5 + 10 * (height * height - side * side)) / (1.5 + 10 * (height * height + side * side));
  const std::vector<Json> impacts = named(run, "impact");
  REQUIRE(impacts.size() > 12);
  for (const Json& impact : impacts) CHECK(kept(impact) == doctest::Approx(share).epsilon(1e-10));
  // The gait: what a step downhill gives is what its impact takes.
  const double gained = 10 * 9.81 * std::sin(std::numbers::pi / 30) * (2 * side + 0.02 * 2 * half);
  const double before = impacts.back().at("before").at("kinetic").get<double>();
  CHECK(before == doctest::Approx(gained / (1 - share * share)).epsilon(0.05));
  CHECK(before > impacts[impacts.size() - 2].at("before").at("kinetic").get<double>());
  CHECK(std::abs(run.energy("error")) < 1e-10);
}

TEST_CASE("leaking_gripper: the can slips at the force that friction gives, and lands on its side") {
  const Run run("leaking_gripper");
  const std::vector<Json> slips = named(run, "slip grip");
  REQUIRE(slips.size() == 2);
  const double force = 0.3 * 9.81 / (2 * 0.6);  // of 12 to 2 N within a second
  for (const Json& slip : slips) CHECK(time_of(slip) == doctest::Approx(1.2 + (12 - force) / 10).epsilon(1e-9));
  CHECK(named(run, "lift grip").size() == 2);
  CHECK(run.final_state.at("bodies").at("can/can").at("position").at(2).get<double>() == doctest::Approx(0.03).epsilon(1e-9));
  CHECK(speed_of(run.final_state, "can/can") < 1e-9);
  CHECK(std::abs(run.energy("error")) < 1e-9);
}

TEST_CASE("crane_sets_down: the crate lands on an edge, tips flat, slides, and stays") {
  const Run run("crane_sets_down");
  CHECK(named(run, "impact").size() > 4);
  CHECK_FALSE(named(run, "slip").empty());
  const Json& crate = run.final_state.at("bodies").at("crate/crate");
  CHECK(crate.at("position").at(2).get<double>() == doctest::Approx(0.6).epsilon(1e-9));
  CHECK(crate.at("quaternion").at(0).get<double>() == doctest::Approx(1).epsilon(1e-12));
  CHECK(speed_of(run.final_state, "crate/crate") < 1e-9);
  for (const Json& impact : named(run, "impact")) CHECK(impact.at("lost").get<double>() > 0);
  CHECK(std::abs(run.energy("error")) < 0.01);  // slings that go slack have a bend in their force
}

TEST_CASE("chimney_comes_to_rest: it breaks once, and its parts come to lie flat on the ground") {
  const Run run("chimney_comes_to_rest");
  REQUIRE(run.events.size() > 10);
  CHECK(run.events[0].at("actions") == Json{"break chimney/piece3"});  // 10 of 30 m
  for (int piece = 1; piece <= 6; ++piece) CHECK(speed_of(run.final_state, "chimney/piece" + std::to_string(piece)) < 1e-9);
  CHECK(run.final_state.at("joints").at("chimney/foot").at("q").at(0).get<double>() ==
        doctest::Approx(std::numbers::pi / 2).epsilon(1e-9));
  CHECK(run.energy("final") == doctest::Approx(60'000 * 9.81 * 0.8).epsilon(1e-9));
  CHECK(run.energy("lost_in_impacts") == doctest::Approx(run.energy("initial") - run.energy("final")).epsilon(1e-9));
  CHECK(std::abs(run.energy("error")) < 1e-6);
}

TEST_CASE("hanging_boxes_fall: the link parts at its strength, and the linked crates come to lie on the floor") {
  const Run run("hanging_boxes_fall");
  REQUIRE(run.events.size() > 10);
  CHECK(run.events[0].at("event") == "strength of crates/worn link");
  CHECK(run.events[0].at("mechanisms").at("after") == Json{"crates", "crates/middle"});
  for (const char* crate : {"crates/middle", "crates/bottom"}) CHECK(speed_of(run.final_state, crate) < 1e-3);
  // No corner was ever below the floor.
  const auto bodies = run.table("bodies.csv");
  for (const std::string crate : {"crates/middle", "crates/bottom"})
    for (std::size_t k = 0; k < bodies.at("time").size(); ++k) {
      const auto at = [&](const char* column) { return bodies.at(crate + column).at(k); };
      const Pose pose{{at(".x"), at(".y"), at(".z")}, {at(".qw"), at(".qx"), at(".qy"), at(".qz")}};
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 point{corner & 1 ? 0.2 : -0.2, corner & 2 ? 0.2 : -0.2, corner & 4 ? -0.1 : -0.5};
        CHECK((pose * point).z > -1e-9);
      }
    }
  CHECK(std::abs(run.energy("error")) < 1e-5);
}

TEST_CASE("dominoes: all of them fall, and the energy balance closes to the order of the steps") {
  const Run run("dominoes");
  for (int i = 1; i <= 12; ++i) {
    const Json& tile = run.final_state.at("bodies").at(i == 1 ? "first/tile" : "domino" + std::to_string(i) + "/tile");
    CHECK(tile.at("position").at(2).get<double>() < 0.07);  // 0.1 upright
    CHECK(tile.at("position").at(2).get<double>() > 0.009);
  }
  CHECK(std::abs(run.energy("error")) < 0.01 * run.energy("lost_in_impacts"));
  CHECK(run.energy("projection") < 0.05 * run.energy("lost_in_impacts"));
}

TEST_CASE("walker_falls: steps of a steady gait, each of which loses what the slope gives, until a knee seizes") {
  const Run run("walker_falls");
  std::vector<Json> landings;
  std::vector<double> lost{0};  // since the landing before
  for (const Json& event : run.events) {
    lost.back() += event.at("lost").get<double>();
    if (event.at("event") != "impact" || time_of(event) > 5.3 || event.at("lost").get<double>() < 1) continue;
    landings.push_back(event), lost.push_back(0);
  }
  REQUIRE(landings.size() == 8);
  const auto energy = [](const Json& event, const char* kind) { return event.at("after").at(kind).get<double>(); };
  for (std::size_t k = 1; k < landings.size(); ++k) {
    CHECK(landings[k].at("bodies") != landings[k - 1].at("bodies"));
    CHECK(time_of(landings[k]) - time_of(landings[k - 1]) == doctest::Approx(0.6757).epsilon(2e-3));
    CHECK(energy(landings[k], "kinetic") == doctest::Approx(energy(landings[k - 1], "kinetic")).epsilon(2e-3));
    const double given = energy(landings[k - 1], "potential") - energy(landings[k], "potential");
    CHECK(lost[k] == doctest::Approx(given).epsilon(5e-3));
  }
  for (const char* body : {"hip", "left shank", "right shank"})
    CHECK(speed_of(run.final_state, std::string("walker/") + body) < 1e-9);
  CHECK(run.final_state.at("bodies").at("walker/hip").at("position").at(2).get<double>() < 0.3);
  CHECK(std::abs(run.energy("error")) < 1e-6 * run.energy("initial"));
}

TEST_CASE("wrecking_ball: two cables hold the ball, one is cut, and it swings through the wall") {
  const Run run("wrecking_ball");
  REQUIRE(!run.events.empty());
  CHECK(run.events[0].at("actions") == Json{"break tagline"});
  const auto springs = run.table("springs.csv");
  // Statics of two cables before; the length of the other one to rounding and overlaps after.
  const double a = std::atan2(3.8567, 4.5983), b = std::atan2(1.3567, 4.4017);
  const double hoist = 900 * 9.81 / (std::sin(a) + std::cos(a) * std::tan(b));
  CHECK(springs.at("hoist.tension").at(20) == doctest::Approx(hoist).epsilon(1e-4));
  for (const double length : springs.at("hoist.length")) CHECK(length < std::hypot(4.5983, 3.8567) + 1e-4);
  double fallen = 0;
  for (int i = 1; i <= 21; ++i)
    fallen += run.final_state.at("bodies").at("brick" + std::to_string(i) + "/brick").at("position").at(2).get<double>() < 0.5;
  CHECK(fallen > 6);
  CHECK(std::abs(run.energy("error")) < 1e-6 * run.energy("initial"));
  CHECK(run.energy("projection") < 0.01 * run.energy("lost_in_impacts"));
}

TEST_CASE("chain_piles_up: the part that comes off falls, and lies on the floor") {
  const Run run("chain_piles_up");
  REQUIRE(run.events.size() == 1);
  for (int link = 3; link <= 20; ++link) {
    const double height = run.final_state.at("bodies").at("chain/" + std::to_string(link)).at("position").at(2).get<double>();
    CHECK(height > 0);  // of a joint: the capsules end before it
    CHECK(height < 0.3);
  }
  CHECK(std::abs(run.energy("error")) < 0.02 * run.energy("lost_in_impacts"));
}

TEST_CASE("bicycle: it moves with the eigenvalues that Meijaard, Papadopoulos, Ruina and Schwab published (2007)") {
  using Complex = std::complex<double>;
  const Ride ride(5, 1e-6, 3);
  // Sums of exp(λ t): samples in a distance h obey the difference equation whose characteristic roots are exp(λ h).
  constexpr std::size_t apart = 10;
  std::vector<Complex> polynomial{1};  // by powers, from the lowest
  for (const Complex value : {Complex(-0.775341882, 4.464867713), Complex(-0.775341882, -4.464867713), Complex(-0.322866429, 0),
                              Complex(-14.078389693, 0)}) {
    polynomial.insert(polynomial.begin(), 0);
    for (std::size_t k = 0; k + 1 < polynomial.size(); ++k) polynomial[k] -= std::exp(0.01 * apart * value) * polynomial[k + 1];
  }
  for (const std::vector<double>& angle : {ride.lean, ride.steer}) {
    const double most = std::fabs(*std::ranges::max_element(angle, {}, [](double x) { return std::fabs(x); }));
    CHECK(most > 1e-8);
    for (std::size_t k = 0; k + 4 * apart < angle.size(); ++k) {
      double left = 0;
      for (std::size_t j = 0; j < polynomial.size(); ++j) left += polynomial[j].real() * angle[k + j * apart];
      CHECK(std::fabs(left) < 2e-9 * most);
    }
  }
}

TEST_CASE("bicycle: it weaves less and less above the published speed, and capsizes above the other one") {
  // After 6 s the other modes are below 0.3 % of the weave, after 15 s the weave is below 1e-9 of the capsize mode.
  const auto growth = [](double speed, int from, int to) {
    const Ride ride(speed, 1e-6, to + 1);
    return ride.most(to) / ride.most(from);
  };
  CHECK(growth(4.27, 6, 18) > 1);
  CHECK(growth(4.31, 6, 18) < 1);
  CHECK(growth(6.024, 15, 24) < 1);
  CHECK(growth(6.0245, 15, 24) > 1);
}

TEST_CASE("bicycle: at 4.6 m/s it comes upright again, and what leaning had is speed; at 3 m/s it falls") {
  const Ride ride(4.6, 0.5, 20);
  CHECK(ride.most(0) > 0.1);
  CHECK(ride.most(19) < 1e-4);
  CHECK(std::abs(ride.run.energy("error")) < 1e-8);
  // All of the kinetic energy is that of rolling ahead: 94 kg and both wheels.
  const double rolling = 0.5 * (94 + 0.12 / (0.3 * 0.3) + 0.28 / (0.35 * 0.35)),
               potential = 9.81 * (85 * 0.9 + 2 * 0.3 + 4 * 0.7 + 3 * 0.35);
  const double speed = 0.3 * ride.run.final_state.at("joints").at("bicycle/rear").at("v").at(0).get<double>();
  CHECK(speed == doctest::Approx(std::sqrt((ride.run.energy("initial") - potential) / rolling)).epsilon(1e-8));
  CHECK(speed == doctest::Approx(4.622).epsilon(1e-4));
  CHECK(ride.run.events.size() == 2);  // both wheels rest
  const Ride slow(3, 0.01, 5);
  CHECK(slow.run.final_state.at("bodies").at("bicycle/frame").at("position").at(2).get<double>() < 0.5);
}

}  // namespace momentree
