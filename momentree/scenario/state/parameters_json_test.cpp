#include <momentree/scenario/state/parameters_json.hpp>

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <momentree/scenario/state/state_document.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/json.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

JointParameters back(const JointParameters& p) {
  std::string text;
  JsonWriter json(text);
  write_parameters(json, p);
  Diagnostics out("p.json", "");
  const JointParameters parameters = parameters_of(parse_json(text, "p.json"), out);
  CHECK(rendered(out.take()) == "");
  return parameters;
}

JointParameters everything() {
  JointParameters p;
  p.damping = 1.0 / 3, p.stiffness = {0.1, 0.2}, p.rest = {0.3, -0.0}, p.armature = 1e-300, p.effort = {1, 2};
  p.limits = {.lower = {-std::numeric_limits<double>::infinity(), 0.1}, .upper = 7, .stiffness = {2, 3}, .damping = 0.5};
  p.friction = {{0.1, 0.7}, 1e-3};
  p.strength.torque = 1.0 / 7;
  JointDrive drive;
  drive.effort = {Signal::table({{-0.1, 1.0 / 3}, {0.2, std::nextafter(1.0, 2)}}), 0.3};
  drive.pd.kp = {1, 2}, drive.pd.kd = 0.1, drive.pd.max_effort = {3, std::numeric_limits<double>::infinity()};
  drive.pd.target = {Signal::sine(0.1, 1.0 / 3, 0.2, 0.7), 0.1};
  drive.pd.target_speed = {Signal::sine(0, 2, 0, 1), 0.0};
  p.drive = std::make_shared<const JointDrive>(drive);
  return p;
}

}  // namespace

TEST_CASE("parameters of every sort come back to the same bits") {
  const JointParameters p = everything();
  CHECK(back(p) == p);
  JointParameters moved;
  moved.drive = motion_drive(Signal::table({{0, 0.1}, {1.0 / 3, 0.2}, {2, 0.3}}));
  CHECK(back(moved) == moved);
  for (const Signal& signal :
       {Signal::ramp(1.0 / 3, 0.1), Signal::ramp(1.0 / 3, 0), Signal::ramp_from_here(-2).begun_at(0.3, 1.7),
        Signal::table({{0, 0.1}, {1.0 / 3, 0.2}}, Signal::Ends::free)}) {
    moved.drive = motion_drive(signal);
    CHECK(back(moved) == moved);
  }
  CHECK(back({}) == JointParameters{});
}

TEST_CASE("a drive set by an event is in the document of the world, and continues from there") {
  Model model;
  model.add({.name = "m/a", .mass = 1, .com = {0, 0, -1}, .inertia = diagonal(0.1), .joint = Revolute{.axis = {0, 1, 0}}});
  Simulation first(model);
  JointParameters p;
  p.drive = effort_drive({Signal::sine(2, 0.7)});
  p.friction = {0.1, 0.05};
  first.apply(set_parameters("m/a", p));
  REQUIRE(first.run_until(0.5) == Status::ok);
  Simulation second(model);
  restore(second, {read_state(state_json(first.world(), {}), "s.json", model)});
  REQUIRE(first.run_until(1) == Status::ok);
  REQUIRE(second.run_until(1) == Status::ok);
  CHECK(state_json(second.world(), {}) == state_json(first.world(), {}));
  REQUIRE(second.world().joint({0}).parameters != nullptr);
  CHECK(*second.world().joint({0}).parameters == *first.world().joint({0}).parameters);
}

TEST_CASE("errors in parameters have their places") {
  const auto mistakes = [](const std::string& text) {
    Diagnostics out("p.json", "");
    parameters_of(parse_json(text, "p.json"), out);
    return rendered(out.take());
  };
  CHECK(mistakes(R"({"drive": {"effort": [{"table": [[1, 2], [1, 3]]}]}})")
            .starts_with("p.json:1:42: error: effort: the table's times must increase"));
  CHECK(mistakes(R"({"drive": {"motion": {"tabel": []}}})").find("did you mean 'table'?") != std::string::npos);
  CHECK(mistakes(R"({"drive": {"effort": [{}]}})").find("expected a number, { table = … }, { sine = … } or { rate = … }") !=
        std::string::npos);
  CHECK(mistakes(R"({"strenght": {}})") == "p.json:1:2: error: unknown key 'strenght' in parameters; did you mean 'strength'?\n");
  CHECK(mistakes(R"({"friction": {"coulomb": null, "speed": "1"}, "limits": {"lower": null, "upper": [1, "2 rad"]}})") ==
        "p.json:1:26: error: coulomb: expected a number, found null\n"
        "p.json:1:41: error: speed: expected a number, found a string\n"
        "p.json:1:86: error: upper: expected a number, found a string\n");
}
