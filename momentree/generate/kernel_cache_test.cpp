// Generated code in a simulation with a changing topology: the same motion to round-off, code reused when a topology returns, and
// the kernels themselves if there is no code.
#include <momentree/generate/kernel_cache.hpp>

#include <doctest/doctest.h>

#include <cmath>

#include <momentree/generate/fingerprint.hpp>
#include <momentree/generate/test_support.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

namespace {

void check_same(const Simulation& one, const Simulation& other, double bound) {
  REQUIRE(one.time() == other.time());
  CHECK(test::apart(one, other) < bound);
}

const char* const arm_joints[] = {"shoulder", "upper", "elbow", "hand"};

// Four revolute joints about different axes: short enough that round-off does not grow.
Model arm(double damping = 0.05) {
  Model model;
  BodyId parent = ground;
  const Vec3 axes[] = {y_axis, x_axis, y_axis, {1, 1, 0}};
  for (int k = 0; k < 4; ++k)
    parent = model.add({.name = arm_joints[k],
                        .mass = 2.0 - 0.3 * k,
                        .com = {0.02, 0.01, -0.2},
                        .inertia = diagonal(0.03, 0.03, 0.01),
                        .parent = parent,
                        .at = {0, 0, k == 0 ? 0.0 : -0.4},
                        .joint = Revolute{.axis = axes[k], .damping = damping, .stiffness = k == 2 ? 4.0 : 0.0},
                        .q = 0.4 - 0.3 * k,
                        .v = 0.5});
  return model;
}

Simulation moving(const Model& model, Variables variables = Variables::momenta) {
  Simulation sim(model, {.method = "rk4", .variables = variables, .step = 1e-3});
  sim.at(0.1).then(lock("elbow"));
  sim.at(0.2).then(unlock("elbow"));
  sim.at(0.3).then(lock("elbow"));
  sim.at(0.4).then(unlock("elbow"));
  sim.at(0.5).then(break_joint("hand"));
  return sim;
}

long calls = 0;  // of the code below

}  // namespace

TEST_CASE("locks, unlocks, a break: the same motion, three topologies compiled, two reused") {
  for (const Variables variables : {Variables::momenta, Variables::velocities}) {
    Simulation plain = moving(arm(), variables), generated = moving(arm(), variables);
    const KernelCache kernels;
    generated.use_generated(kernels.provider());
    for (const double until : {0.05, 0.15, 0.25, 0.45, 0.6}) {
      REQUIRE(plain.run_until(until) == Status::ok);
      REQUIRE(generated.run_until(until) == Status::ok);
      // 600 steps with rounding in another order; the motion is not chaotic, and speeds are a few m/s.
      check_same(plain, generated, 1e-12);
    }
    const KernelCacheStatistics s = kernels.statistics();
    CHECK(s.compiled == 3);  // free, locked, broken
    CHECK(s.found_again == 3);
    CHECK(s.left == 0);
    CHECK(s.seconds > 0);
    CHECK(kernels.message() == "");
    CHECK(std::fabs(generated.energy().error - plain.energy().error) < 1e-12);
    CHECK(generated.statistics().evaluations[0] == plain.statistics().evaluations[0]);
  }
}

TEST_CASE("one cache serves runs in momenta and in velocities, adaptive ones too") {
  const KernelCache kernels;
  for (const Variables variables : {Variables::momenta, Variables::velocities}) {
    const Integration how{.method = "dop853", .variables = variables};
    Simulation plain(arm(), how), generated(arm(), how);
    generated.use_generated(kernels.provider());
    for (Simulation* sim : {&plain, &generated}) REQUIRE(sim->run_until(0.5) == Status::ok);
    check_same(plain, generated, 1e-9);
  }
  CHECK(kernels.statistics().compiled == 2);
  CHECK((kernels.find(Tree(arm())) != nullptr));
  CHECK((kernels.find_velocities(Tree(arm())) != nullptr));
  CHECK(kernels.statistics().compiled == 2);
}

TEST_CASE("the same run gives the same bits, and so do a branch and an undone world") {
  const KernelCache kernels;
  Simulation one = moving(arm()), other = moving(arm());
  one.use_generated(kernels.provider());
  other.use_generated(kernels.provider());
  REQUIRE(one.run_until(0.15) == Status::ok);
  REQUIRE(one.run_until(0.6) == Status::ok);
  REQUIRE(other.run_until(0.15) == Status::ok);
  const SimulationSnapshot past = other.snapshot();
  Simulation branch = other.branch();
  REQUIRE(other.run_until(0.6) == Status::ok);
  check_same(one, other, 1e-300);
  REQUIRE(branch.run_until(0.6) == Status::ok);
  check_same(one, branch, 1e-300);
  other.restore(past);
  REQUIRE(other.run_until(0.6) == Status::ok);
  check_same(one, other, 1e-300);
  CHECK(kernels.statistics().compiled == 3);
}

TEST_CASE("stages use the provider's function until the tree changes") {
  Simulation sim(arm(), {.method = "rk4", .step = 1e-3});
  long asked = 0;
  const KernelCache kernels;
  static RatesFunction inner = nullptr;
  sim.use_generated([&](const Tree& tree, Variables, std::span<const int>) -> RatesFunction {
    ++asked;
    inner = kernels.find(tree);
    return [](const double* q, const double* p, double* v, double* qdot, double* pdot) noexcept {
      ++calls;
      inner(q, p, v, qdot, pdot);
    };
  });
  calls = 0;
  REQUIRE(sim.run_until(0.01) == Status::ok);
  CHECK(asked == 1);
  CHECK(calls == 30);  // three stages of ten steps; the first evaluation of a step stores more than rates
  sim.apply(lock("elbow"));
  REQUIRE(sim.run_until(0.02) == Status::ok);
  CHECK(asked == 2);
  CHECK(calls == 60);
  sim.use_generated({});
  REQUIRE(sim.run_until(0.03) == Status::ok);
  CHECK(calls == 60);
}

TEST_CASE("forces on bodies and functions: the kernels are used, with the reason") {
  Model model = arm();
  Simulation plain(model), generated(model);
  const KernelCache kernels;
  generated.use_generated(kernels.provider());
  for (Simulation* sim : {&plain, &generated}) {
    sim->drive("elbow", [](const EvaluationContext&) { return 0.3; });
    REQUIRE(sim->run_until(0.02) == Status::ok);
  }
  check_same(plain, generated, 1e-300);
  CHECK(kernels.statistics().compiled == 0);
  CHECK(kernels.statistics().left == 1);
  CHECK(kernels.message().find("functions") != std::string::npos);
}

TEST_CASE("too large or too many topologies: the kernels are used") {
  const KernelCache small({.most_operations = 100});
  CHECK((small.find(Tree(arm())) == nullptr));
  CHECK(small.statistics().left == 1);
  CHECK(small.message().find("100 operations") != std::string::npos);
  const KernelCache tiny({.most_operations = 30});  // not even written as expressions
  CHECK((tiny.find(Tree(arm())) == nullptr));
  CHECK(tiny.message().find("30 operations") != std::string::npos);
  const KernelCache few({.most_topologies = 1});
  Simulation sim = moving(arm());
  sim.use_generated(few.provider());
  REQUIRE(sim.run_until(0.6) == Status::ok);
  CHECK(few.statistics().compiled == 1);
  CHECK(few.statistics().left == 2);
  CHECK(few.statistics().found_again == 2);
}

TEST_CASE("topologies are distinguished by exactly what the recursion reads") {
  const std::string one = fingerprint(Tree(arm()));
  CHECK(fingerprint(Tree(arm())) == one);
  CHECK(fingerprint(Tree(arm(0.7))) == one);  // dampers are not part of it
  Model heavy, light = arm();
  for (BodySpec body : light.bodies()) {
    if (heavy.size() == 3) body.mass = std::nextafter(body.mass, 10);
    heavy.add(body);
  }
  CHECK(fingerprint(Tree(heavy)) != one);
  light.set_gravity({0, 0, -1.6});
  CHECK(fingerprint(Tree(light)) != one);
  CHECK(fingerprint(Tree(arm()), Variables::velocities) != one);
  CHECK(fingerprint(Tree(arm(0.7)), Variables::velocities) == fingerprint(Tree(arm()), Variables::velocities));
}

}  // namespace momentree
