// Elements between joints: what a model accepts, and that they act in simulations of it.
#include <cmath>
#include <limits>
#include <string>

#include <doctest/doctest.h>

#include <momentree/batch/batch.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>

namespace momentree {
namespace {

using elements::SpringCoupling;

struct Wheels {
  Model model;
  BodyId a, b;
  Wheels() {
    a = add("a", Revolute{{0, 0, 1}});
    b = add("b", Revolute{{0, 0, 1}});
  }
  BodyId add(const std::string& name, const JointSpec& joint) {
    return model.add({.name = "m/" + name, .mass = 1, .inertia = diagonal(0.1, 0.1, 0.1), .joint = joint});
  }
  std::string error(SpringCoupling spring) {
    if (spring.stiffness == 0) spring.stiffness = 1;
    return error_of([&] { model.add_element(spring); });
  }
};

}  // namespace

TEST_CASE("a model accepts elements between different joints with one DoF, with numbers in their ranges") {
  Wheels w;
  const BodyId ball = w.add("c", Ball{});
  const BodyId moved = w.add("d", Revolute{.drive = motion_drive(Signal::sine(0.5, 2))});
  const JointId loop = w.model.add_loop({.name = "m/l", .body = w.b, .to = w.a, .joint = Ball{}});
  const auto joint = [&](BodyId body) { return w.model.inboard_joint(body); };
  const auto says = [](const std::string& error, const std::string& what) { return error.find(what) != std::string::npos; };
  CHECK(says(w.error({joint(w.a), {7}}), "follows: is not a joint of this model"));
  CHECK(says(w.error({{-1}, joint(w.a)}), "joint: is not a joint of this model"));
  CHECK(says(w.error({joint(w.a), joint(w.a)}), "follows: names a joint that the element has already"));
  CHECK(says(w.error({joint(ball), joint(w.a)}), "joint 'm/c' is ball, and does not have one degree of freedom"));
  CHECK(says(w.error({joint(w.a), joint(moved)}), "the motion of joint 'm/d' is prescribed"));
  CHECK(says(w.error({joint(w.a), loop}), "a joint that closes a loop can't be coupled"));
  CHECK(says(w.error({joint(w.a), joint(w.b), std::nan("")}), "multiplier: must be finite"));
  CHECK(says(w.error({joint(w.a), joint(w.b), 1, 0, -1}), "stiffness: must be positive"));
  CHECK(says(w.error({joint(w.a), joint(w.b), 1, 0, 1, -1}), "damping: must not be negative"));
  CHECK(says(error_of([&] { w.model.add_element({}); }), "has no joints"));
  CHECK(w.model.elements().empty());
  w.model.add_element(SpringCoupling{joint(w.a), joint(w.b), 1, 0, 1});
  CHECK(w.model.elements().size() == 1);
  CHECK_THROWS_AS(Batch(w.model, 2), const Error&);
  w.model.keep(1);
  CHECK(w.model.elements().empty());
}

TEST_CASE("an element acts in every simulation of the model, until one of its joints breaks") {
  Wheels w;
  const auto joint = [&](BodyId body) { return w.model.inboard_joint(body); };
  const double k = 40;
  w.model.add_element(SpringCoupling{joint(w.b), joint(w.a), -2, 0.3, k});
  w.model.add_element(SpringCoupling{joint(w.b), joint(w.a), -2, 0.3, k});  // both act
  Simulation sim(w.model, {.method = "rk4", .step = 1e-3});
  // e = b + 2 a − 0.3: ë = −2 k (1/I + 4/I) e
  const double frequency = std::sqrt(2 * k * 5 / 0.1);
  for (const double t : {0.05, 0.2, 1.0}) {
    REQUIRE(sim.run_until(t) == Status::ok);
    const double apart = sim.world().joint(joint(w.b)).q[0] + 2 * sim.world().joint(joint(w.a)).q[0] - 0.3;
    CHECK(std::fabs(apart + 0.3 * std::cos(frequency * t)) < 1e-6);
  }
  Simulation copy = sim.branch();
  copy.apply({break_joint("m/b")});
  const double left = copy.world().joint(joint(w.a)).v[0];
  REQUIRE(copy.run_until(1.5) == Status::ok);
  CHECK(copy.world().joint(joint(w.a)).v[0] == left);
  const SimulationSnapshot whole = sim.snapshot();
  REQUIRE(sim.run_until(1.5) == Status::ok);
  const double there = sim.world().joint(joint(w.a)).v[0];
  sim.apply({break_joint("m/b")});
  sim.restore(whole);
  REQUIRE(sim.run_until(1.5) == Status::ok);
  CHECK(sim.world().joint(joint(w.a)).v[0] == there);
}

TEST_CASE("another joint with the number of one that ended is none of the element's") {
  Wheels w;
  const auto joint = [&](BodyId body) { return w.model.inboard_joint(body); };
  w.model.add_element(SpringCoupling{joint(w.b), joint(w.a), 1, 0.3, 40});
  Simulation sim(w.model, {.method = "rk4", .step = 1e-3});
  sim.drive("m/a", [](const EvaluationContext&) { return 0.5; });
  sim.apply({break_joint("m/b")});
  sim.apply({attach("m/b", "ground", Revolute{{1, 0, 0}}, {}, "again")});
  sim.drive("again", [](const EvaluationContext&) { return 0.0; });
  const double before = sim.world().joint(joint(w.a)).v[0];
  REQUIRE(sim.run_until(0.1) == Status::ok);
  CHECK(sim.world().joint(joint(w.a)).v[0] - before == doctest::Approx(0.5 / 0.1 * 0.1).epsilon(1e-12));
}

TEST_CASE("with_joints gives an element other joints") {
  const JointElement moved = with_joints(SpringCoupling{{1}, {4}, 2}, [](JointId joint) { return JointId{joint.index + 10}; });
  CHECK(moved == JointElement(SpringCoupling{{11}, {14}, 2}));
  CHECK(joints_of(moved) == std::vector<JointId>{{11}, {14}});
}

}  // namespace momentree
