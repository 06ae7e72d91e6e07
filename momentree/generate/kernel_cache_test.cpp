// Generated code in a simulation with a changing topology: the same motion to round-off, code reused when a topology returns, and
// the kernels themselves if there is no code.
#include <momentree/generate/kernel_cache.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <momentree/generate/compiler.hpp>
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

KernelCache cache() { return KernelCache({.compiler = MOMENTREE_COMPILER}); }

long calls = 0;  // of the code below

}  // namespace

TEST_CASE("locks, unlocks, a break: the same motion, three topologies compiled, two reused") {
  for (const Variables variables : {Variables::momenta, Variables::velocities}) {
    Simulation plain = moving(arm(), variables), generated = moving(arm(), variables);
    const KernelCache kernels = cache();
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
    CHECK(s.failed == 0);
    CHECK(s.left == 0);
    CHECK(s.seconds > 0);
    CHECK(kernels.message() == "");
    CHECK(std::fabs(generated.energy().error - plain.energy().error) < 1e-12);
    CHECK(generated.statistics().evaluations[0] == plain.statistics().evaluations[0]);
  }
}

TEST_CASE("one cache serves runs in momenta and in velocities, adaptive ones too") {
  const KernelCache kernels = cache();
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
  const KernelCache kernels = cache();
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
  const KernelCache kernels = cache();
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
  const KernelCache kernels = cache();
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

TEST_CASE("no compiler, one that fails, one that makes no library: the kernels are used, with one reason") {
  const auto run = [](const std::string& compiler) {
    const KernelCache kernels({.compiler = compiler});
    Simulation plain = moving(arm()), generated = moving(arm());
    generated.use_generated(kernels.provider());
    REQUIRE(plain.run_until(0.6) == Status::ok);
    REQUIRE(generated.run_until(0.6) == Status::ok);
    check_same(plain, generated, 1e-300);
    CHECK(kernels.statistics().compiled == 0);
    return kernels;
  };
  CHECK(run("no-such-compiler").message() == "the compiler 'no-such-compiler' was not found");
  CHECK(run("no-such-compiler").statistics().failed == 0);
  const KernelCache failing = run("/bin/false");
  CHECK(failing.message().find("/bin/false failed") != std::string::npos);
  CHECK(failing.statistics().failed == 3);
  CHECK(run("/bin/true").message().find("could not be loaded") != std::string::npos);
  const KernelCache wrong = run(std::string(MOMENTREE_COMPILER) + " -include no_such_header.h");
  CHECK(wrong.message().find("error") != std::string::npos);
  CHECK(wrong.message().find("no_such_header.h") != std::string::npos);
}

TEST_CASE("too large or too many topologies: the kernels are used") {
  const KernelCache small({.compiler = MOMENTREE_COMPILER, .most_operations = 100});
  CHECK((small.find(Tree(arm())) == nullptr));
  CHECK(small.statistics().left == 1);
  CHECK(small.message().find("100 operations") != std::string::npos);
  const KernelCache tiny({.compiler = MOMENTREE_COMPILER, .most_operations = 30});  // not even written as expressions
  CHECK((tiny.find(Tree(arm())) == nullptr));
  CHECK(tiny.message().find("30 operations") != std::string::npos);
  const KernelCache few({.compiler = MOMENTREE_COMPILER, .most_topologies = 1});
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

TEST_CASE("the compiler: as requested, else from the environment, else from PATH") {
  const char* const names[] = {"MOMENTREE_CXX", "CXX"};
  std::string before[2];
  for (int i = 0; i < 2; ++i) before[i] = std::getenv(names[i]) != nullptr ? std::getenv(names[i]) : "";
  setenv("MOMENTREE_CXX", "/bin/true -x", 1);
  setenv("CXX", "/bin/false", 1);
  CHECK(find_compiler("") == std::vector<std::string>{"/bin/true", "-x"});
  CHECK(find_compiler("/bin/sh") == std::vector<std::string>{"/bin/sh"});
  CHECK(find_compiler("sh").at(0).ends_with("/sh"));
  setenv("MOMENTREE_CXX", "", 1);
  CHECK(find_compiler("") == std::vector<std::string>{"/bin/false"});
  setenv("CXX", "no-such-compiler", 1);
  CHECK(find_compiler("").empty());  // if the named compiler is missing, no other one is used
  CHECK(find_compiler("/bin").empty());
  // No shell interprets it.
  CHECK(find_compiler("/bin/true $(id) 'a b' ;x") == std::vector<std::string>{"/bin/true", "$(id)", "'a", "b'", ";x"});
  for (int i = 0; i < 2; ++i) before[i].empty() ? unsetenv(names[i]) : setenv(names[i], before[i].c_str(), 1);
}

TEST_CASE("a compiler and a temporary folder whose paths have spaces, quotes and shell commands") {
  namespace fs = std::filesystem;
  const fs::path odd = fs::temp_directory_path() / ("momentree 'test' $(id) \"-" + std::to_string(std::rand()));
  fs::create_directory(odd);
  const fs::path compiler = odd / "my c++";
  std::ofstream(compiler) << "#!/bin/sh\nexec '" MOMENTREE_COMPILER "' \"$@\"\n";
  fs::permissions(compiler, fs::perms::owner_all);
  CHECK(find_compiler(compiler.string()) == std::vector<std::string>{compiler.string()});
  const char* const given = std::getenv("TMPDIR");
  const std::string before = given != nullptr ? given : "";
  setenv("TMPDIR", odd.c_str(), 1);
  const KernelCache kernels({.compiler = compiler.string()});
  CHECK((kernels.find(Tree(arm())) != nullptr));
  CHECK(kernels.message() == "");
  before.empty() ? unsetenv("TMPDIR") : setenv("TMPDIR", before.c_str(), 1);
  fs::remove_all(odd);
}

TEST_CASE("nothing is left in the temporary folder, whatever happens") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("momentree-cache-test-" + std::to_string(std::rand()));
  fs::create_directory(folder);
  const char* const given = std::getenv("TMPDIR");
  const std::string before = given != nullptr ? given : "";
  setenv("TMPDIR", folder.c_str(), 1);
  CHECK((cache().find(Tree(arm())) != nullptr));
  CHECK((KernelCache({.compiler = "/bin/false"}).find(Tree(arm())) == nullptr));
  CHECK(fs::is_empty(folder));
  setenv("TMPDIR", "/nowhere/at/all", 1);
  const KernelCache kernels = cache();
  CHECK((kernels.find(Tree(arm())) == nullptr));
  CHECK(kernels.message().find("TMPDIR") != std::string::npos);
  before.empty() ? unsetenv("TMPDIR") : setenv("TMPDIR", before.c_str(), 1);
  fs::remove_all(folder);
}

}  // namespace momentree
