// Generated kernels against the engine's own and against the oracle: the expressions and their machine code on random trees of
// all joint kinds in all variants, and their source code on a few models.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <bench/models.hpp>
#include <momentree/dynamics/count.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/generate/machine_code.hpp>
#include <momentree/generate/source.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/math/sincos.hpp>
#include <tests/compiled_source.hpp>
#include <tests/oracle/oracle.hpp>
#include <tests/oracle/random_model.hpp>
#include <tests/oracle/rearrange.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

struct Rates {
  explicit Rates(const Tree& tree)
      : v(static_cast<std::size_t>(tree.nv())), qdot(static_cast<std::size_t>(tree.nq())), pdot(v.size()), udot(v.size()) {}
  std::vector<double> v, qdot, pdot, udot;
};

// Evaluates the expressions without a compiler. p: or u.
void interpret(const KernelExpressions& kernel, const std::vector<double>& q, const std::vector<double>& p, Rates& rates,
               const std::vector<double>& tau = {}) {
  std::vector<double> x;
  const auto at = [&](int i) { return x[static_cast<std::size_t>(i)]; };
  for (const Expressions::Node& node : kernel.expressions.nodes()) {
    double s = 0, c = 0;
    if (node.operation == Operation::sine || node.operation == Operation::cosine) sincos(at(node.a), s, c);
    switch (node.operation) {
      case Operation::constant: x.push_back(node.value); break;
      case Operation::q: x.push_back(q[static_cast<std::size_t>(node.a)]); break;
      case Operation::p: x.push_back(p[static_cast<std::size_t>(node.a)]); break;
      case Operation::tau: x.push_back(tau[static_cast<std::size_t>(node.a)]); break;
      case Operation::sine: x.push_back(s); break;
      case Operation::cosine: x.push_back(c); break;
      case Operation::negative: x.push_back(-at(node.a)); break;
      case Operation::sum: x.push_back(at(node.a) + at(node.b)); break;
      case Operation::difference: x.push_back(at(node.a) - at(node.b)); break;
      case Operation::product: x.push_back(at(node.a) * at(node.b)); break;
      case Operation::quotient: x.push_back(at(node.a) / at(node.b)); break;
      case Operation::answer:
      case Operation::inverse_pivot: FAIL("trees have no rows of loops"); break;
    }
  }
  for (std::size_t i = 0; i < kernel.v.size(); ++i) rates.v[i] = at(kernel.v[i]), rates.pdot[i] = at(kernel.pdot[i]);
  for (std::size_t i = 0; i < kernel.udot.size(); ++i) rates.udot[i] = at(kernel.udot[i]);
  for (std::size_t i = 0; i < rates.qdot.size(); ++i) rates.qdot[i] = at(kernel.qdot[i]);
}

double largest(const double* a, std::size_t n) {
  double most = 0;
  for (std::size_t i = 0; i < n; ++i) most = std::fmax(most, std::fabs(a[i]));
  return most;
}

double distance(const std::vector<double>& a, const double* b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double off = std::fabs(a[i] - b[i]);
    most = off <= most ? most : off;  // NaN is kept
  }
  return most;
}

// Error relative to the tolerance. Both compute the same in a different order, so that they differ by rounding errors of the
// mass: velocities are accurate to its condition times 1e-16 (velocity_resolution), and so are the quantities derived from them.
double error(const Tree& tree, const std::vector<double>& q, const Rates& found, const Workspace<double>& workspace) {
  const auto nv = found.v.size(), nq = found.qdot.size();
  const double allowed = std::fmax(1e-13, 30 * velocity_resolution(tree, q));
  const double speed = largest(workspace.v.get(), nv) + largest(workspace.qdot.get(), nq) + 1e-3,
               rate = largest(workspace.pdot.get(), nv) + 1e-3;
  const double of_v =
      std::fmax(distance(found.v, workspace.v.get()), distance(found.qdot, workspace.qdot.get())) / (allowed * speed);
  const double of_p = distance(found.pdot, workspace.pdot.get()) / (allowed * rate);
  return of_v >= of_p ? of_v : of_p;
}

// Near a state; quaternions need not have unit length.
std::vector<double> moved(Prng& random, std::span<const double> from, double by) {
  std::vector<double> to(from.begin(), from.end());
  for (double& x : to) x += random.uniform(-by, by);
  return to;
}

// Velocities and joint forces at random, zero for DoFs at rest.
std::pair<std::vector<double>, std::vector<double>> any_motion(const Tree& tree, Prng& random) {
  std::vector<double> u(static_cast<std::size_t>(tree.nv())), tau(u.size());
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if (((tree.link(b).locked & ~tree.link(b).driven) >> i & 1u) == 0) {
        const auto k = static_cast<std::size_t>(tree.first_p(b) + i);
        u[k] = random.uniform(-1, 1), tau[k] = random.uniform(-3, 3);
      }
  return {u, tau};
}

// The kernels' accelerations, to workspace.a, by either of their passes.
template <bool Keep>
void accelerate_by_kernels(const Tree& tree, const std::vector<double>& q, const std::vector<double>& u,
                           const std::vector<double>& tau, Workspace<double>& workspace) {
  sweep_velocities<double, Keep>(tree, q.data(), u.data(), workspace);
  std::copy(tau.begin(), tau.end(), workspace.a.get());
  solve_accelerations<double, Keep>(tree, q.data(), workspace, {-tree.gravity(), {}});
}

double velocity_error(const Tree& tree, const std::vector<double>& q, const Rates& found, const Workspace<double>& workspace) {
  const double allowed = std::fmax(1e-13, 30 * velocity_resolution(tree, q));
  const double of_q =
      distance(found.qdot, workspace.qdot.get()) / (allowed * (largest(workspace.qdot.get(), found.qdot.size()) + 1e-3));
  const double of_u =
      distance(found.udot, workspace.a.get()) / (allowed * (largest(workspace.a.get(), found.udot.size()) + 1e-3));
  return of_q >= of_u ? of_q : of_u;
}

}  // namespace

TEST_CASE("expressions are what the kernels compute, on trees of all kinds and variants") {
  bool seen[9][5] = {};
  double worst = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const RandomTree random = random_tree(seed, {.max_bodies = 30});
    Tree tree(random.model);
    Prng draw(seed + 900);
    Workspace<double> workspace(tree);
    State state = start_state(random.model, tree);
    if (seed % 2 == 1) rearrange(draw, tree, state, workspace);
    for (const KernelRun& s : tree.tables().runs) seen[static_cast<int>(s.kind)][static_cast<int>(s.variant)] = true;
    const KernelExpressions expressions = kernel_expressions(tree);
    CHECK(expressions.operations().total() <= count_operations(tree).total());
    CHECK(expressions.operations().sincos <= count_operations(tree).sincos);
    const auto code = MachineKernel::make(expressions);
    Rates rates(tree);
    for (int i = 0; i < 3; ++i) {
      const std::vector<double> q = moved(draw, state.q(), 0.1), p = moved(draw, state.p(), 0.1);
      evaluate_rates(tree, q.data(), p.data(), workspace);
      for (const bool by_code : {false, true}) {
        if (by_code && code == nullptr) continue;
        if (by_code)
          code->momenta()(q.data(), p.data(), rates.v.data(), rates.qdot.data(), rates.pdot.data());
        else
          interpret(expressions, q, p, rates);
        const double off = error(tree, q, rates, workspace);
        CAPTURE(seed);
        CAPTURE(by_code);
        CHECK(off <= 1);
        worst = std::fmax(worst, off);
      }
    }
  }
  MESSAGE("worst: " << worst << " of what is allowed");
  int combinations = 0;
  for (const auto& kind : seen)
    for (const bool variant : kind) combinations += variant ? 1 : 0;
  CHECK(combinations >= 25);
}

TEST_CASE("velocities: expressions are what the kernels compute, on trees of all kinds and variants") {
  bool seen[9][5] = {};
  double worst = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const RandomTree random = random_tree(seed, {.max_bodies = 30, .drives = true});
    Tree tree(random.model);
    Prng draw(seed + 900);
    Workspace<double> workspace(tree);
    State state = start_state(random.model, tree);
    if (seed % 2 == 1) rearrange(draw, tree, state, workspace);
    for (const KernelRun& s : tree.tables().runs) seen[static_cast<int>(s.kind)][static_cast<int>(s.variant)] = true;
    const KernelExpressions expressions = velocity_expressions(tree);
    const auto code = MachineKernel::make(expressions);
    Rates rates(tree);
    for (int i = 0; i < 3; ++i) {
      const std::vector<double> q = moved(draw, state.q(), 0.1);
      const auto [u, tau] = any_motion(tree, draw);
      for (const bool keep : {false, true}) {
        keep ? accelerate_by_kernels<true>(tree, q, u, tau, workspace) : accelerate_by_kernels<false>(tree, q, u, tau, workspace);
        if (keep && code != nullptr)
          code->velocities()(q.data(), u.data(), tau.data(), rates.qdot.data(), rates.udot.data());
        else
          interpret(expressions, q, u, rates, tau);
        const double off = velocity_error(tree, q, rates, workspace);
        CAPTURE(seed);
        CHECK(off <= 1);
        worst = std::fmax(worst, off);
      }
    }
  }
  MESSAGE("worst: " << worst << " of what is allowed");
  int combinations = 0;
  for (const auto& kind : seen)
    for (const bool variant : kind) combinations += variant ? 1 : 0;
  CHECK(combinations >= 25);
}

TEST_CASE("a prescribed motion has the rate that p holds, in expressions too") {
  Model model;
  const BodyId arm =
      model.add({.name = "arm", .mass = 2, .com = {0.3, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{.axis = y_axis}});
  Revolute driven{.axis = x_axis};
  driven.drive = motion_drive(Signal::sine(0.5, 2));
  model.add({.name = "hand",
             .mass = 1,
             .com = {0, 0, 0.2},
             .inertia = diagonal(0.02),
             .parent = arm,
             .at = {0.6, 0, 0},
             .joint = driven});
  const Tree tree(model);
  const KernelExpressions kernel = kernel_expressions(tree);
  Workspace<double> workspace(tree);
  Rates rates(tree);
  const std::vector<double> q{0.4, -0.3}, p{0.7, 1.9};
  evaluate_rates(tree, q.data(), p.data(), workspace);
  interpret(kernel, q, p, rates);
  CHECK(rates.v[1] == 1.9);
  CHECK(error(tree, q, rates, workspace) <= 1);
}

TEST_CASE("compiled source gives the engine's rates, at many states") {
  struct Case {
    std::string name;
    Model model;
    bool changed;  // by breaks, locks and re-rooting
  };
  const Case cases[] = {{"double pendulum in a plane", bench::planar_chain(2), false},
                        {"planar chain", bench::planar_chain(6), false},
                        {"arm", bench::arm(), false},
                        {"forked tree", random_tree(7, {.min_bodies = 8, .max_bodies = 14}).model, false},
                        {"floating tree", random_tree(9, {.min_bodies = 6, .max_bodies = 10, .all_free = true}).model, false},
                        {"a tree after changes", random_tree(11, {.min_bodies = 8, .max_bodies = 12}).model, true}};
  for (const Case& c : cases) {
    CAPTURE(c.name);
    Tree tree(c.model);
    Workspace<double> workspace(tree);
    State state = start_state(c.model, tree);
    Prng random(42);
    if (c.changed) rearrange(random, tree, state, workspace);
    const test::CompiledSource momenta(kernel_source(kernel_expressions(tree)));
    const auto rates = momenta.function<RatesFunction>("kernel_rates");
    CHECK(*momenta.function<const int*>("kernel_nq") == tree.nq());
    CHECK(*momenta.function<const int*>("kernel_nv") == tree.nv());
    Rates found(tree);
    double worst = 0;
    for (int i = 0; i < 300; ++i) {
      const double far = i % 10 == 0 ? 4e6 : 1;  // also beyond sincos_range
      const std::vector<double> q = moved(random, state.q(), tree.joints_with().quaternions.empty() ? far : 0.3);
      const std::vector<double> p = moved(random, state.p(), 0.5 * largest(state.p().data(), state.p().size()));
      evaluate_rates(tree, q.data(), p.data(), workspace);
      rates(q.data(), p.data(), found.v.data(), found.qdot.data(), found.pdot.data());
      const double off = error(tree, q, found, workspace);
      worst = off <= worst ? worst : off;
    }
    CHECK(worst <= 1);
    const test::CompiledSource velocities(kernel_source(velocity_expressions(tree)));
    const auto accelerations = velocities.function<VelocityRatesFunction>("kernel_accelerations");
    CHECK(*velocities.function<const int*>("kernel_nq") == tree.nq());
    CHECK(*velocities.function<const int*>("kernel_nv") == tree.nv());
    double worst_u = 0;
    for (int i = 0; i < 300; ++i) {
      const double far = i % 10 == 0 ? 4e6 : 1;
      const std::vector<double> q = moved(random, state.q(), tree.joints_with().quaternions.empty() ? far : 0.3);
      const auto [u, tau] = any_motion(tree, random);
      accelerate_by_kernels<false>(tree, q, u, tau, workspace);
      accelerations(q.data(), u.data(), tau.data(), found.qdot.data(), found.udot.data());
      const double off = velocity_error(tree, q, found, workspace);
      worst_u = off <= worst_u ? worst_u : off;
    }
    CHECK(worst_u <= 1);
    MESSAGE(c.name << ": worst " << worst << " of what is allowed, in velocities " << worst_u);
  }
}

TEST_CASE("compiled source with dampers, springs and efforts: the oracle's rates") {
  const Model plain = bench::arm();
  Model model;
  for (BodySpec body : plain.bodies()) {
    const int b = model.size();
    JointParameters& p = body.joint.parameters;
    if (b % 2 == 0) p.stiffness = 3.0 + b, p.rest = 0.1 * b, p.effort = 0.7 - b, p.armature = 0.02;
    model.add(body);
  }
  const Tree tree(model);
  CHECK(other_forces(tree).empty());
  KernelExpressions kernel = kernel_expressions(tree);
  add_plain_forces(tree, kernel);
  const test::CompiledSource momenta(kernel_source(kernel)), velocities(kernel_source(velocity_expressions(tree, true)));
  const auto rates = momenta.function<RatesFunction>("kernel_rates");
  const auto accelerations = velocities.function<VelocityRatesFunction>("kernel_accelerations");
  const System system = system_of(model);
  Prng random(3);
  Rates found(tree);
  for (int i = 0; i < 20; ++i) {
    const std::vector<double> q = moved(random, start_q(model), 1), p = moved(random, std::vector<double>(7), 2);
    rates(q.data(), p.data(), found.v.data(), found.qdot.data(), found.pdot.data());
    // The momenta that correspond to these velocities, and the rates at these velocities, so that no linear system is solved in
    // between.
    const std::vector<Real> v(found.v.begin(), found.v.end()), again = mass_matrix(system, q).times(v);
    const std::vector<Real> expected = oracle::evaluate(system, q, v).pdot;
    Real rate = 1;
    for (const Real x : expected) rate = std::fmax(rate, std::fabs(x));
    for (std::size_t k = 0; k < p.size(); ++k) {
      CHECK(std::fabs(again[k] - p[k]) < 1e-13);
      CHECK(std::fabs(expected[k] - found.pdot[k]) < 1e-13 * rate);
      CHECK(found.qdot[k] == found.v[k]);
    }
    // In velocities, with further joint forces.
    const auto [u, tau] = any_motion(tree, random);
    accelerations(q.data(), u.data(), tau.data(), found.qdot.data(), found.udot.data());
    const MassMatrix mass = mass_matrix(system, q);
    const Accelerations own = accelerate(system, q, {u.begin(), u.end()}, mass);
    const std::vector<Real> caused = solve(mass, {tau.begin(), tau.end()});
    Real most = 1;
    for (std::size_t k = 0; k < u.size(); ++k) most = std::fmax(most, std::fabs(own.v[k]) + std::fabs(caused[k]));
    for (std::size_t k = 0; k < u.size(); ++k) {
      CHECK(std::fabs(own.v[k] + caused[k] - found.udot[k]) < 1e-12 * most);
      CHECK(found.qdot[k] == u[k]);
    }
  }
}

TEST_CASE("models that are not plain expressions are refused by name") {
  Model model;
  Revolute hinge{.damping = 0.1, .stiffness = 2};
  hinge.friction = {.coulomb = 0.2, .speed = 0.01};
  Ball ball{.stiffness = 1};
  const BodyId a = model.add({.name = "a", .mass = 1, .inertia = diagonal(0.1), .joint = hinge});
  const BodyId b = model.add({.name = "b", .mass = 1, .inertia = diagonal(0.1), .parent = a, .at = {1, 0, 0}, .joint = ball});
  const std::vector<OtherForce> found = other_forces(Tree(model));
  REQUIRE(found.size() == 2);
  CHECK((found[0].body == a.index && found[0].what == "dry friction" && !found[0].on_body));
  CHECK((found[1].body == b.index && found[1].what == "a spring about a quaternion"));
}

TEST_CASE("source: identifiers, comments, constants") {
  CHECK(identifier("breaking chain-2") == "breaking_chain_2");
  CHECK(identifier("7dof") == "k7dof");
  CHECK(identifier("") == "k");
  const Tree tree(bench::arm());
  const std::string text = kernel_source(kernel_expressions(tree), {"arm", "An arm\\\nof seven pins\n"});
  CHECK(text.starts_with("// An arm<U+005C>\n// of seven pins\n"));
  for (const char* part : {"extern \"C\"", "void arm_rates(", "const int arm_nq = 7;", "const int arm_nv = 7;", "pdot[6] = "})
    CHECK_MESSAGE(text.find(part) != std::string::npos, part);
  // With strict warnings, as a user's build may have.
  const test::CompiledSource strict(text, "-Wall -Wextra -Wpedantic -Wconversion -Wshadow");
}
