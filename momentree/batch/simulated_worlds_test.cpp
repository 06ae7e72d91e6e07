// Worlds without contact that have what lanes do not: forces on bodies, springs between points, hard stops and strengths. They
// are stepped one by one, with the bits of simulations.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/batch/batch.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

constexpr double h = 1e-3;

// Two links that hang from the ground; the axis is horizontal.
Model two_links(const JointParameters& upper = {}, const JointParameters& lower = {}, double angle = 1) {
  Model model;
  const auto link = [&](const char* name, BodyId parent, const JointParameters& parameters) {
    BodySpec body{.name = name,
                  .mass = 1,
                  .com = {0, 0, -0.25},
                  .inertia = diagonal(0.02),
                  .parent = parent,
                  .at = {0, 0, parent == ground ? 0 : -0.5},
                  .joint = Revolute{.axis = y_axis}};
    body.joint.parameters = parameters;
    if (parent == ground) body.q = {angle};
    return model.add(body);
  };
  link("lower", link("upper", ground, upper), lower);
  return model;
}

std::vector<Model> models() {
  std::vector<Model> all;
  all.push_back(two_links({.limits = {.lower = -0.2, .restitution = 0.3}}));
  all.push_back(two_links({}, {.strength = {.force = 12}}));
  all.push_back(two_links());
  all.back().add_force({.body = {1}, .force = {3.0, 0.0, 0.0}});
  all.push_back(two_links());
  all.back().add_spring({.name = "coil", .from = {ground, {1, 0, 0}}, .to = {{1}, {}}, .stiffness = 20, .rest = 0.5});
  return all;
}

bool same_bits(const State& one, const State& other) {
  return one.time() == other.time() && one.variables() == other.variables() && std::ranges::equal(one.q(), other.q()) &&
         std::ranges::equal(one.y(), other.y());
}

bool has_event(std::span<const Event> events, const std::string& name) {
  return std::any_of(events.begin(), events.end(), [&](const Event& e) { return e.name == name; });
}

}  // namespace

TEST_CASE("worlds with what lanes do not have are stepped one by one, with the bits of simulations") {
  for (const Model& model : models())
    for (const Variables variables : {Variables::momenta, Variables::velocities}) {
      Simulation sim(model, {.method = "rk4", .variables = variables, .step = h});
      Batch batch(model, 3, {.variables = variables, .threads = 2, .step = h});
      CHECK(batch.lanes() == 1);
      CHECK(batch.variables(0) == variables);
      const std::vector<int> worlds{0, 1, 2};
      for (int k = 0; k < 100; ++k) {
        batch.step(0.01);
        REQUIRE(sim.run_until(sim.time() + 0.01));
      }
      CHECK(batch.groups() == 1);
      const auto nv = static_cast<std::size_t>(batch.nv(0));
      std::vector<double> v(3 * nv), p(3 * nv);
      batch.read(worlds, nullptr, nullptr, p.data(), v.data());
      for (int world = 0; world < 3; ++world) {
        REQUIRE_FALSE(batch.diverged(world));
        CHECK(same_bits(batch.state(world), sim.world().state()));
      }
      for (std::size_t i = 0; i < nv; ++i) {
        CHECK(v[2 * nv + i] == doctest::Approx(sim.world().v()[i]).epsilon(1e-12));
        CHECK(p[nv + i] == doctest::Approx(sim.world().p()[i]).epsilon(1e-12));
      }
    }
}

TEST_CASE("worlds that rest on a stop share the group of others, and an effort lifts them off it") {
  // At rest the upper link is held at an angle by its stop.
  const Model model = two_links({.limits = {.lower = 0.5}}, {.damping = 5.0}, 0.5);
  Batch batch(model, 3, {.step = h});
  for (int k = 0; k < 400; ++k) batch.step(0.01);
  CHECK(batch.state(0).q()[0] == 0.5);
  const std::vector<int> worlds{0, 1, 2}, one{1};
  std::vector<double> q(6), y(2);
  batch.set_effort(2, {0}, 0, 20);
  batch.step(0.05);
  CHECK(batch.state(2).q()[0] > 0.501);
  CHECK(batch.groups() == 1);
  batch.read(worlds, nullptr, q.data(), nullptr, nullptr);
  CHECK(q[0] == 0.5);
  CHECK(q[4] > 0.501);
  // A state that is set there rests again; one beyond the stop is an error.
  batch.write(one, nullptr, q.data(), y.data());
  batch.step(0.01);
  CHECK(batch.state(1).q()[0] == 0.5);
  q[0] = 0.4;
  CHECK(error_of([&] { batch.write(one, nullptr, q.data(), y.data()); }).find("beyond") != std::string::npos);
  State beyond = batch.state(1);
  beyond.edit().q[0] = 0.4;
  CHECK(error_of([&] { batch.set_state(1, beyond); }).find("beyond") != std::string::npos);
}

TEST_CASE("a joint whose strength is exceeded breaks in a step, and the world has its names and group") {
  const Model model = two_links({}, {.strength = {.force = 30}}, 0);
  Batch batch(model, 3, {.threads = 2, .step = h});
  Simulation sim(model, {.method = "rk4", .step = h});
  batch.set_effort(1, {0}, 0, 0.5);
  batch.set_effort(1, {1}, 0, 0.5);
  const std::vector<double> q(2), v{8, 0};
  const std::vector<int> one{1};
  batch.write(one, nullptr, q.data(), v.data(), Variables::velocities);
  sim.set_state(0, q, v, Variables::velocities);
  for (const char* joint : {"upper", "lower"}) sim.drive(joint, [](const EvaluationContext&) { return 0.5; });
  batch.step(0.02);
  REQUIRE(sim.run_until(0.02));
  CHECK(has_event(batch.events(1), "strength of lower"));
  CHECK(batch.groups() == 2);
  CHECK(same_bits(batch.state(1), sim.world().state()));
  CHECK(batch.joint_name(1, {1}) == sim.world().joint_name({1}));
  CHECK(batch.joint_name(0, {1}) == "lower");
  for (int k = 0; k < 10; ++k) {  // the effort on the joint that broke has ended, the other one acts on
    batch.step(0.01);
    REQUIRE(sim.run_until(sim.time() + 0.01));
  }
  CHECK(same_bits(batch.state(1), sim.world().state()));
  const std::string name = batch.joint_name(1, {1});
  const Event welded = batch.apply(1, weld("lower", "upper"), "welded"), other = sim.apply(weld("lower", "upper"), "welded");
  CHECK(welded.lost == other.lost);
  CHECK(batch.find_joint(1, name).has_value() == (sim.world().find_joint(name) >= 0));
  CHECK(batch.joint_name(1, {1}) == "welded");
}

TEST_CASE("functions are refused in worlds that are stepped one by one, too") {
  Batch batch(models()[0], 2);
  const auto function = std::make_shared<const JointFunction>([](const EvaluationContext&, std::span<double>) {});
  const auto edit = [&](Tree& tree, State& state, Workspace<double>&) {
    tree.edit().set_function(1, function);
    state = State(tree, batch.variables(1));
  };
  CHECK(error_of([&] { batch.edit(1, edit); }).find("functions") != std::string::npos);
  batch.step(0.01);
  CHECK(batch.groups() == 1);
}
