// A floor under scenarios that have none: where it is, what lands on it, and joints that break when they are pulled.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <momentree/pages/floor.hpp>
#include <momentree/pages/page_controls.hpp>
#include <momentree/scenario/test_support.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

Scenario read(const std::string& text) {
  ReadResult result = read_scenario_text(text, "s.toml");
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return std::move(*result.scenario);
}

std::string chain(int links, const std::string& more = "") {
  return "format = 1\n[[mechanism]]\nname = \"chain\"\n[mechanism.chain]\nlinks = " + std::to_string(links) +
         "\nlength = 0.1\nmass = 0.05\ninertia = 4e-5\naxis = [0, 1, 0]\ndamping = 0.0002\n" + more +
         "[mechanism.joint.1]\nangle = \"90 deg\"\n";
}

// The lowest point of the bodies that can touch the floor, above it (m).
double clearance(const Scenario& scenario, const World& world) {
  const Model& model = scenario.model;
  const auto plane = std::find_if(model.colliders().begin(), model.colliders().end(), [](const auto& c) { return c.plane; });
  double least = HUGE_VAL;
  for (const Collider& each : model.colliders()) {
    if (each.plane || each.body == ground || !world.alive(each.body) || model.contact_law(each.body, ground).off) continue;
    const Pose& pose = world.motions()[static_cast<std::size_t>(each.body.index)].pose;
    for (const Vec3& v : each.solid.vertices)
      least = std::min(least, dot(plane->normal, pose * v - plane->point) - each.solid.radius);
  }
  return least;
}

}  // namespace

TEST_CASE("floor of a page: it is below what a hanging chain can reach, and the chain lands there and rests with its weight") {
  Scenario scenario = read(chain(6));
  REQUIRE(put_on_floor(scenario));
  CHECK(floor_height(scenario) < -0.6);
  CHECK(floor_height(scenario) > -0.65);
  CHECK(scenario.model.colliders().size() == 7);
  CHECK(scenario.model.contact_law({2}, {4}).off);
  CHECK(!scenario.model.contact_law({0}, ground).off);
  Simulation sim(scenario.model, scenario.integration);
  REQUIRE(sim.run_until(0.3));
  REQUIRE(sim.try_apply({break_joint("chain/2")}) == Status::ok);
  for (int i = 1; i <= 60; ++i) {
    REQUIRE(sim.run_until(0.3 + 0.05 * i));
    CHECK(clearance(scenario, sim.world()) > -2e-3);
  }
  const EnergyBalance energy = sim.energy();
  CHECK(std::fabs(energy.error) < 1e-2 * 6 * 0.05 * 9.81 * 0.6);
  Vec3 force{};
  for (const ContactPoint& point : sim.world().contacts()) {
    CHECK(point.other == ground);
    force += point.force;
  }
  CHECK(force.z == doctest::Approx(5 * 0.05 * 9.81).epsilon(0.02));
}

TEST_CASE("floor of a page: a mechanism that stands keeps its joint to the ground above it") {
  const std::string pole =
      "format = 1\n[[mechanism]]\nname = \"pole\"\n[[mechanism.body]]\nname = \"pole\"\nmass = 1\ninertia = [0.1, 0.1, 0.01]\n"
      "com = [0, 0, 0.5]\nshape = { box = [0.1, 0.1, 1], at = { xyz = [0, 0, 0.5] } }\n"
      "joint = { kind = \"revolute\", axis = [0, 1, 0], q = 0.1 }\n";
  Scenario scenario = read(pole);
  REQUIRE(put_on_floor(scenario));
  CHECK(scenario.model.contact_law({0}, ground).off);
  CHECK(floor_height(scenario) < 0);
  CHECK(floor_height(scenario) > -0.1);
}

TEST_CASE("floor of a page: a floor of the scenario is kept; nothing changes if all bodies touch it") {
  const std::string ball =
      "[[mechanism]]\nname = \"a\"\nroot = \"free\"\npose = { xyz = [0, 0, 1] }\n[[mechanism.body]]\nname = \"a\"\nmass = 1\n"
      "inertia = 0.1\nshape = { sphere = 0.2 }\n";
  const std::string own = "format = 1\n[world]\nfloor = { height = -3, friction = 0.1 }\n";
  Scenario touching = read(own + ball + "collision = \"shape\"\n");
  CHECK(!put_on_floor(touching));
  Scenario through = read(own + ball);
  REQUIRE(put_on_floor(through));
  CHECK(floor_height(through) == -3);
  CHECK(through.model.contact_law({0}, ground).friction == 0.1);
  CHECK(through.model.colliders().size() == 2);
  // A body that is below that floor at the start passes through it.
  Scenario below = read("format = 1\n[world]\nfloor = { height = 1 }\n" + ball);
  REQUIRE(put_on_floor(below));
  CHECK(below.model.contact_law({0}, ground).off);
}

TEST_CASE("floor of a page: every scenario of the repository runs above it") {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(MOMENTREE_SOURCE_DIR "/scenarios")) {
    if (file.path().extension() != ".toml") continue;
    ReadResult result = read_scenario(file.path().string());
    REQUIRE(result.scenario);
    Scenario scenario = std::move(*result.scenario);
    const bool changed = put_on_floor(scenario);
    CAPTURE(file.path().filename().string());
    if (!changed) continue;
    ++count;
    CHECK(
        std::any_of(scenario.model.colliders().begin(), scenario.model.colliders().end(), [](const auto& c) { return c.plane; }));
    Simulation sim(scenario.model, scenario.integration);
    CHECK(clearance(scenario, sim.world()) > -1e-9);
    const RunResult run = sim.run_until(0.05);
    CAPTURE(run.reason);
    CHECK(run);
    CHECK(clearance(scenario, sim.world()) > -5e-3);
  }
  CHECK(count > 20);
}

TEST_CASE("strength of a page: a chain that hangs at rest breaks where its load exceeds the limit") {
  const double weight = 0.05 * 9.81;
  for (const double limit : {3.5, 4.5}) {
    Scenario scenario = read(chain(4, "strength = { force = 100 }\n"));
    Simulation sim(scenario.model, scenario.integration);
    REQUIRE(sim.try_apply(limited_strength(sim.world(), limit * weight)) == Status::ok);
    CHECK(sim.world().joint({sim.world().find_joint("chain/1")}).parameters->strength.force == doctest::Approx(limit * weight));
    REQUIRE(sim.run_until(0.01));
    // The topmost joint carries all four links; the others would do.
    CHECK(sim.world().mechanisms().size() == 1);
    CHECK(sim.world().mechanisms()[0].grounded == (limit > 4));
    REQUIRE(sim.try_apply(limited_strength(sim.world(), 1e6)) == Status::ok);
    CHECK(sim.world().joint({sim.world().find_joint("chain/2")}).parameters->strength.force == 100);
  }
}
