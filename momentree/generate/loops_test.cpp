// Generated code for closed loops in simulations: the same motion through changes of topology and of the chosen rows, and the
// kernels where there is no code.
#include <doctest/doctest.h>

#include <cmath>

#include <momentree/generate/kernel_cache.hpp>
#include <momentree/generate/loop_kernel.hpp>
#include <momentree/generate/source.hpp>
#include <momentree/generate/test_support.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/misuse.hpp>

using namespace momentree;

namespace {

void check_same(const Simulation& one, const Simulation& other, double bound) {
  REQUIRE(one.time() == other.time());
  CHECK(test::apart(one, other) < bound);
}

const Vec3 tilted{0.5, 0.7, 0.6};

// A crank, a coupler and a rocker with axes along `axis`; a ball joint closes the loop at the ground if `open_chain` is false.
Model four_bar(const Vec3& axis, JointSpec pin = Ball{}) {
  Model model;
  const Vec3 n = normalized(axis), e1 = normalized(cross(n, Vec3{1, 0, 0}));
  const double lengths[] = {0.12, 0.38, 0.25};
  const char* const names[] = {"crank", "coupler", "rocker"};
  const double angles[] = {1.0, -0.9, -1.3};
  BodyId link = ground;
  for (int k = 0; k < 3; ++k)
    link = model.add({.name = names[k],
                      .mass = 2.0 - 0.5 * k,
                      .com = (0.5 * lengths[k]) * e1,
                      .inertia = diagonal(0.01, 0.012, 0.011),
                      .parent = link,
                      .at = k == 0 ? Pose{} : Pose{lengths[k - 1] * e1},
                      .joint = Revolute{.axis = axis, .damping = k == 0 ? 0.02 : 0.0},
                      .q = angles[k],
                      .v = k == 0 ? 6.0 : 0.0});
  LoopSpec closure;
  closure.name = "pin", closure.body = link, closure.joint = pin;
  closure.at = Pose{0.4 * e1}, closure.child_at = Pose{lengths[2] * e1};
  if (pin.kind != Kind::ball) closure.joint.axis = n;
  model.add_loop(closure);
  return model;
}

KernelCache cache(long most_choices = 8) { return KernelCache({.most_choices = most_choices}); }

long calls = 0;                       // of the code below
LoopRatesFunction counted = nullptr;  // that it calls

// The provider of a cache, whose code for loops counts its calls.
RatesProvider counting(const KernelCache& kernels) {
  return [inner = kernels.provider()](const Tree& tree, Variables variables, std::span<const int> rows) {
    GeneratedRates code = inner(tree, variables, rows);
    counted = code.loops;
    if (counted != nullptr)
      code.loops = [](const double* q, const double* u, const double* tau, const LoopCalls* to, double* qdot,
                      double* udot) noexcept {
        ++calls;
        counted(q, u, tau, to, qdot, udot);
      };
    return code;
  };
}

bool differ(const Simulation& one, const Simulation& other) {
  const auto a = one.world().state().q(), b = other.world().state().q();
  return !std::equal(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

TEST_CASE("loops: the same motion through a weld, a lock, an unlock, a break and another kind of joint") {
  const auto moving = [](const char* method) {
    Simulation sim(four_bar(y_axis), {.method = method, .step = 1e-3});
    sim.at(0.05).then(lock("pin", {1}));
    sim.at(0.10).then(unlock("pin"));
    sim.at(0.15).then(break_joint("pin"));
    sim.at(0.20).then(weld("coupler", "ground"));
    sim.at(0.25).then(break_joint("crank"));
    return sim;
  };
  for (const char* const method : {"rk4", "dop853"}) {
    CAPTURE(method);
    Simulation plain = moving(method), generated = moving(method);
    const KernelCache kernels = cache();
    calls = 0;
    generated.use_generated(counting(kernels));
    for (const double until : {0.05, 0.1, 0.15, 0.2, 0.25, 0.3}) {
      CAPTURE(until);
      const RunResult one = plain.run_until(until), other = generated.run_until(until);
      CHECK_MESSAGE(one.status == Status::ok, one.reason);
      CHECK_MESSAGE(other.status == Status::ok, other.reason);
      check_same(plain, generated, method[0] == 'r' ? 1e-10 : 1e-8);
    }
    CHECK(calls > 100);
    if (std::string(method) == "rk4") CHECK(calls == 3 * 200);  // three stages of each step with loops
    CHECK(kernels.statistics().compiled >= 4);
    CHECK(kernels.statistics().left == 0);
    CHECK(kernels.message() == "");
    CHECK(std::fabs(generated.energy().error - plain.energy().error) < 1e-8);
  }
}

TEST_CASE("loops: code for one choice of rows is not used with another") {
  // Three equations of rank 2 about a tilted axis: which two are taken changes while the crank turns.
  const Integration how{.method = "rk4", .step = 1e-3};
  Simulation plain(four_bar(tilted), how), generated(four_bar(tilted), how), limited(four_bar(tilted), how);
  const KernelCache kernels = cache(), one_choice = cache(1);
  std::vector<std::vector<int>> asked;
  generated.use_generated([&, inner = kernels.provider()](const Tree& tree, Variables variables, std::span<const int> rows) {
    asked.emplace_back(rows.begin(), rows.end());
    const GeneratedRates code = inner(tree, variables, rows);
    CHECK(std::vector<int>(code.rows.begin(), code.rows.end()) == asked.back());
    return code;
  });
  limited.use_generated(one_choice.provider());
  for (Simulation* sim : {&plain, &generated, &limited}) REQUIRE(sim->run_until(1.5) == Status::ok);
  check_same(plain, generated, 1e-9);
  check_same(plain, limited, 1e-9);
  CHECK(asked.size() > 2);
  CHECK(kernels.statistics().compiled >= 2);
  CHECK(kernels.statistics().compiled <= 3);
  CHECK(kernels.statistics().compiled + kernels.statistics().found_again == static_cast<long>(asked.size()));
  CHECK(one_choice.statistics().compiled == 1);
  CHECK(one_choice.statistics().left > 0);
  CHECK(one_choice.message().find("more than 1 choice") != std::string::npos);

  // A provider that is wrong about the rows: the kernels run, to the bit.
  Simulation again(four_bar(tilted), how);
  const std::vector<int> wrong{0};
  again.use_generated([&, inner = kernels.provider()](const Tree& tree, Variables variables, std::span<const int> rows) {
    GeneratedRates code = inner(tree, variables, rows);
    code.rows = wrong;
    return code;
  });
  REQUIRE(again.run_until(1.5) == Status::ok);
  CHECK_FALSE(differ(plain, again));
}

TEST_CASE("loops: forces, armatures and prescribed motions of loop joints, and couplings") {
  const auto run = [](const Model& model, double bound) {
    const Integration how{.method = "rk4", .step = 1e-3};
    Simulation plain(model, how), generated(model, how);
    const KernelCache kernels = cache();
    calls = 0;
    generated.use_generated(counting(kernels));
    for (Simulation* sim : {&plain, &generated}) {
      const RunResult result = sim->run_until(0.3);
      CHECK_MESSAGE(result.status == Status::ok, result.reason);
    }
    check_same(plain, generated, bound);
    CHECK(kernels.statistics().compiled >= 1);
    CHECK(calls == 3 * 300);
    const EnergyBalance one = plain.energy(), other = generated.energy();
    CHECK(std::fabs(one.dissipated - other.dissipated) < 1e-9 * (1 + std::fabs(one.dissipated)));
    CHECK(std::fabs(one.work - other.work) < 1e-9 * (1 + std::fabs(one.work)));
    return generated.energy();
  };
  SUBCASE("a spring, a damper and dry friction") {
    Revolute pin{.axis = y_axis, .damping = 0.3, .stiffness = 5};
    pin.friction = {.coulomb = 0.2, .speed = 0.05};
    CHECK(run(four_bar(y_axis, pin), 1e-9).dissipated > 0.01);
  }
  SUBCASE("an armature") { run(four_bar(y_axis, Revolute{.axis = y_axis, .armature = 0.05}), 1e-9); }
  SUBCASE("a prescribed motion") {
    Revolute pin{.axis = y_axis, .damping = 0.1};
    const Simulation start(four_bar(y_axis, pin), {.method = "rk4"});
    const double angle = start.world().joint(start.world().loops()[0]).q[0];
    pin.drive = motion_drive(Signal::sine(0.1, 2, 0, angle));
    CHECK(std::fabs(run(four_bar(y_axis, pin), 1e-9).work) > 1e-3);
  }
  SUBCASE("a coupling, driven by a prescribed motion of the tree") {
    Model model;
    Revolute driven{.axis = y_axis};
    driven.drive = motion_drive(Signal::sine(0.5, 2));
    const BodyId pinion =
        model.add({.name = "pinion", .mass = 1, .com = {0.05, 0, 0}, .inertia = diagonal(0.02), .joint = driven});
    const BodyId rack = model.add({.name = "rack", .mass = 3, .joint = Prismatic{.axis = z_axis}});
    const BodyId bob = model.add({.name = "bob",
                                  .mass = 1,
                                  .com = {0.1, 0, -0.2},
                                  .inertia = diagonal(0.01),
                                  .parent = rack,
                                  .joint = Revolute{.axis = x_axis},
                                  .q = 0.5});
    static_cast<void>(bob);
    Coupling coupling{.joint = model.inboard_joint(rack), .follows = model.inboard_joint(pinion), .multiplier = 0.3};
    coupling.higher[0] = 0.2;
    model.add_coupling(coupling);
    CHECK(std::fabs(run(model, 1e-10).work) > 1e-3);
  }
}

TEST_CASE("loops: momenta and springs between points run the kernels, and the cache says so") {
  Simulation sim(four_bar(y_axis), {.method = "rk4", .variables = Variables::momenta, .step = 1e-3});
  const KernelCache kernels = cache();
  sim.use_generated(kernels.provider());
  REQUIRE(sim.run_until(0.01) == Status::ok);
  CHECK(kernels.statistics().compiled == 0);
  CHECK(kernels.message().find("closed loops or couplings run the kernels themselves in momenta") != std::string::npos);
}

TEST_CASE("loops: what a file cannot contain is named") {
  const auto obstacles = [](const JointSpec& pin, bool without = false) {
    Simulation sim(four_bar(y_axis, pin), {.method = "rk4"});
    return loop_obstacles(sim.world().tree(), without);
  };
  CHECK(obstacles(Ball{}).empty());
  CHECK(obstacles(Revolute{.axis = y_axis, .armature = 0.1}).empty());
  const auto damped = obstacles(Revolute{.axis = y_axis, .damping = 0.1});
  REQUIRE(damped.size() == 1);
  CHECK((damped[0].loop == 0 && damped[0].forces && damped[0].what == "a force along its DoFs"));
  CHECK(obstacles(Revolute{.axis = y_axis, .damping = 0.1}, true).empty());
  const auto planar = obstacles(Planar{.armature = {1, 1, 1}});
  REQUIRE(planar.size() == 1);
  CHECK_FALSE(planar[0].forces);
}

TEST_CASE("misuse: expressions of loops without loops") {
  test::check_stopped({"expressions of loops of a tree", "a tree with closed loops or couplings", [] {
                         Model model;
                         model.add({.name = "bob", .mass = 1, .inertia = diagonal(0.1), .joint = Revolute{}});
                         static_cast<void>(loop_expressions(Tree(model), {}));
                       }});
}
