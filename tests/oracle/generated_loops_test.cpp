// Generated code for closed loops against the kernels: the expressions and their machine code on random mechanisms of all kinds,
// with couplings, prescribed motions, armatures and forces in loop joints; and compiled source on a few of them.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <bench/loop_models.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/generate/loop_kernel.hpp>
#include <momentree/generate/machine_code.hpp>
#include <momentree/generate/source.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/math/sincos.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/compiled_source.hpp>
#include <tests/oracle/loop_rows.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A λ = b by the definition: rows one after the other, without those whose pivots are too small.
std::vector<double> solved(const KernelExpressions& kernel, const std::vector<double>& numbers, const double* least) {
  const auto n = static_cast<int>(kernel.begin.size());
  Matrix A = Matrix::Zero(n, n);
  std::size_t next = 0;
  for (int i = 0; i < n; ++i)
    for (int j = kernel.begin[at(i)]; j <= i; ++j) A(i, j) = A(j, i) = numbers[next++];
  Vector b(n);
  for (int i = 0; i < n; ++i) b(i) = numbers[next++];
  std::vector<int> kept;
  for (int i = 0; i < n; ++i) {
    kept.push_back(i);
    const Matrix own = A(kept, kept);
    const Eigen::LDLT<Matrix> before(own);
    const double pivot =
        kept.size() == 1 ? A(i, i) : own.determinant() / Matrix(own.topLeftCorner(own.rows() - 1, own.rows() - 1)).determinant();
    if (!(pivot > least[i])) kept.pop_back();
  }
  const Vector x = Matrix(A(kept, kept)).llt().solve(Vector(b(kept)));
  std::vector<double> all(at(n), 0.0);
  for (std::size_t k = 0; k < kept.size(); ++k) all[at(kept[k])] = x(static_cast<int>(k));
  return all;
}

const KernelExpressions* interpreted_kernel = nullptr;
int interpreted_calls = 0;

// A LoopRatesFunction that evaluates these expressions without a compiler.
void interpreted(const double* q, const double* u, const double* tau, const LoopCalls* calls, double* qdot,
                 double* udot) noexcept {
  const KernelExpressions& kernel = *interpreted_kernel;
  ++interpreted_calls;
  std::vector<double> x, answers;
  const auto value = [&](int i) { return x[at(i)]; };
  std::size_t called = 0;
  for (const Expressions::Node& node : kernel.expressions.nodes()) {
    double s = 0, c = 0;
    if (node.operation == Operation::sine || node.operation == Operation::cosine) sincos(value(node.a), s, c);
    if (node.operation == Operation::answer && at(node.a) == answers.size()) {
      const Expressions::Call& call = kernel.expressions.calls()[called++];
      std::vector<double> arguments;
      for (const int i : call.arguments) arguments.push_back(value(i));
      answers.resize(answers.size() + at(call.answers));
      double* const answer = answers.data() + call.first_answer;
      if (call.loop >= 0)
        calls->joint(calls, call.loop, arguments.data(), call.answers, answer);
      else
        std::ranges::copy(solved(kernel, arguments, calls->least_pivots), answer);
    }
    switch (node.operation) {
      case Operation::constant: x.push_back(node.value); break;
      case Operation::q: x.push_back(q[node.a]); break;
      case Operation::p: x.push_back(u[node.a]); break;
      case Operation::tau: x.push_back(tau[node.a]); break;
      case Operation::answer: x.push_back(answers[at(node.a)]); break;
      case Operation::sine: x.push_back(s); break;
      case Operation::cosine: x.push_back(c); break;
      case Operation::negative: x.push_back(-value(node.a)); break;
      case Operation::inverse_pivot: x.push_back(value(node.a) > calls->least_pivots[node.b] ? 1 / value(node.a) : 0.0); break;
      case Operation::sum: x.push_back(value(node.a) + value(node.b)); break;
      case Operation::difference: x.push_back(value(node.a) - value(node.b)); break;
      case Operation::product: x.push_back(value(node.a) * value(node.b)); break;
      case Operation::quotient: x.push_back(value(node.a) / value(node.b)); break;
    }
  }
  for (std::size_t i = 0; i < kernel.qdot.size(); ++i) qdot[i] = value(kernel.qdot[i]);
  for (std::size_t i = 0; i < kernel.udot.size(); ++i) udot[i] = value(kernel.udot[i]);
  for (std::size_t i = 0; i < kernel.lambda.size(); ++i) calls->lambda[i] = value(kernel.lambda[i]);
  for (std::size_t i = 0; i < kernel.effort.size(); ++i) calls->effort[i] = value(kernel.effort[i]);
}

// A random mechanism with loops: by the seed with couplings, with a prescribed motion of a joint of the tree or of a loop, and
// with armatures and forces in loop joints.
Model any_mechanism(std::uint64_t seed) {
  RandomTreeOptions options;
  options.drives = seed % 2 == 1;
  if (seed % 4 == 2) options.kinds = {Kind::revolute, Kind::prismatic, Kind::helical};
  const Model plain = with_loops(seed, options, seed % 5 == 3);
  Model model({.gravity = plain.gravity()});
  for (const BodySpec& body : plain.bodies()) model.add(body);
  Prng random(seed + 31);
  bool moves = seed % 5 == 3;
  for (LoopSpec loop : plain.loops()) {
    const KindInfo& kind = info(loop.joint.kind);
    JointParameters& p = loop.joint.parameters;
    if (seed % 3 == 0)
      for (int i = 0; i < kind.nv; ++i) p.armature.push_back(random.uniform(0.1, 2));
    if (!moves && seed % 2 == 0 && kind.nv == 1) {
      p.drive = motion_drive(Signal::sine(0.4, 1.5));
      moves = true;
    }
    model.add_loop(loop);
  }
  std::vector<int> single;
  for (int b = 0; b < model.size(); ++b)
    if (const JointSpec& joint = model[BodyId{b}].joint; info(joint.kind).nv == 1 && joint.parameters.drive == nullptr)
      single.push_back(b);
  if (seed % 3 == 1 && single.size() > 1) {
    Coupling coupling{.joint = {single.front()}, .follows = {single.back()}, .multiplier = random.uniform(-2, 2)};
    coupling.higher = {random.uniform(-1, 1), random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3)};
    coupling.offset = model[BodyId{single.front()}].q[0] - coupling.value(model[BodyId{single.back()}].q[0]);
    model.add_coupling(coupling);
  }
  return model;
}

double largest(const double* a, int n) {
  double most = 0;
  for (int i = 0; i < n; ++i) most = std::fmax(most, std::fabs(a[i]));
  return most;
}
double distance(const double* a, const double* b, int n) {
  double most = 0;
  for (int i = 0; i < n; ++i) {
    const double off = std::fabs(a[i] - b[i]);
    most = off <= most ? most : off;  // NaN is kept
  }
  return most;
}

// Near a state; quaternions need not have unit length.
std::vector<double> moved(Prng& random, std::span<const double> from, double by) {
  std::vector<double> to(from.begin(), from.end());
  for (double& x : to) x += random.uniform(-by, by);
  return to;
}
// With zeros for DoFs at rest.
std::vector<double> moved_velocities(Prng& random, const Tree& tree, std::span<const double> from, double by) {
  std::vector<double> u = moved(random, from, by);
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if (((tree.link(b).locked & ~tree.link(b).driven) >> i & 1u) != 0) u[at(tree.first_p(b) + i)] = 0;
  return u;
}

// The largest acceleration that there would be without the loops, of which those with loops are differences.
double free_acceleration(const Tree& tree, double t, const std::vector<double>& q, const std::vector<double>& u,
                         Workspace<double>& workspace) {
  sweep_velocities<double, true>(tree, q.data(), u.data(), workspace);
  joint_forces(tree, t, q.data(), workspace, workspace.a.get());
  solve_accelerations<double, true>(tree, q.data(), workspace, {-tree.gravity(), {}});
  return largest(workspace.a.get(), tree.nv());
}

// Closed loops at a state of a world, and the chosen rows.
struct Closed {
  World world;
  const Tree& tree = world.tree();
  Workspace<double> workspace{tree};
  explicit Closed(const Model& model) : world(model, Variables::velocities) {
    load_turns(tree, world.state(), workspace);
    evaluate_velocity_state(tree, world.state(), workspace);
  }
  // Of the chosen rows, relative to their scales: round-off grows by its inverse.
  double weakest_pivot() const {
    const LoopWorkspace& loops = *workspace.loops;
    double least = 1;
    for (std::size_t i = 0; i < loops.kept.rows.size(); ++i) {
      const double L = loops.factor[static_cast<std::size_t>(loops.kept.position[i] + static_cast<std::ptrdiff_t>(i))];
      least = std::fmin(least, L * L / loops.rows[at(loops.kept.rows[i])].scale);
    }
    return least;
  }
  std::span<const int> rows() const { return chosen_rows(tree, workspace); }
};

}  // namespace

TEST_CASE("loops: expressions are what the kernels compute, on random mechanisms") {
  int tried = 0, couplings = 0, motions = 0, driven = 0, armatures = 0, forces = 0, redundant = 0, called = 0;
  int typical = 0;
  double worst = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    CAPTURE(seed);
    std::optional<Closed> made;
    try {
      made.emplace(any_mechanism(seed));
    } catch (const Error&) {  // the motion contradicts the loops, or these cannot be closed
      continue;
    }
    Closed& closed = *made;
    const Tree& tree = closed.tree;
    if (!tree.has_loops() || tree.nv() == 0 || !stages_take_loop_rates(tree, Variables::velocities)) continue;
    if (const Matrix J = rows_of(closed.world); J.rows() > 0 && nearly_singular(J)) continue;
    ++tried;
    couplings += tree.loops().links.size() > tree.loops().size() ? 1 : 0;
    motions += tree.loops().motions > 0 ? 1 : 0;
    driven += tree.joints_with().motions.empty() ? 0 : 1;
    armatures += tree.loops().armatures > 0 ? 1 : 0;
    redundant += std::ssize(closed.rows()) < tree.loops().rows ? 1 : 0;
    const double weakest = closed.weakest_pivot();
    const std::vector<int> rows(closed.rows().begin(), closed.rows().end());
    const KernelExpressions kernel = loop_expressions(tree, rows, LoopCode::stages);
    forces += kernel.expressions.calls().empty() ? 0 : 1;
    interpreted_kernel = &kernel;
    const auto code = MachineKernel::make(kernel);
    GeneratedRates by_expressions, by_code;
    by_expressions.loops = interpreted, by_expressions.rows = by_code.rows = rows;
    if (code != nullptr) by_code.loops = code->loops();
    Prng draw(seed + 900);
    Workspace<double> other(tree), open(tree);
    copy_chosen_rows(tree, closed.workspace, other);
    for (int i = 0; i < 3; ++i) {
      const double by = i * 1e-3, t = 0.1 * i;
      const std::vector<double> q = moved(draw, closed.world.state().q(), by),
                                u = moved_velocities(draw, tree, closed.world.state().u(), i * 0.3);
      evaluate_velocity_stage(tree, t, q.data(), u.data(), closed.workspace);
      interpreted_calls = 0;
      REQUIRE(evaluate_loop_stage(tree, t, q.data(), u.data(), other, by_expressions));
      called += interpreted_calls;
      const std::vector<double> expected(other.a.get(), other.a.get() + tree.nv());
      if (code != nullptr) REQUIRE(evaluate_loop_stage(tree, t, q.data(), u.data(), other, by_code));
      const double fast = 1 + largest(u.data(), tree.nv());
      const double size = largest(closed.workspace.a.get(), tree.nv()) + free_acceleration(tree, t, q, u, open) + fast * fast;
      const double of_a = distance(closed.workspace.a.get(), other.a.get(), tree.nv()) / size;
      const double of_q = distance(closed.workspace.qdot.get(), other.qdot.get(), tree.nq()) / fast;
      const Power &one = closed.workspace.power, &two = other.power;
      const double power = std::fabs(one.dissipated) + std::fabs(one.work) + fast * fast;
      const double of_power = (std::fabs(one.dissipated - two.dissipated) + std::fabs(one.work - two.work)) / power;
      CHECK(of_a < 1e-12 / weakest);
      CHECK(distance(closed.workspace.a.get(), expected.data(), tree.nv()) / size < 1e-12 / weakest);
      CHECK(of_q < 1e-13);
      CHECK(of_power < 1e-12 / weakest);
      worst = std::fmax(worst, weakest * std::fmax(of_a, of_power));
      typical += of_a < 1e-12 ? 1 : 0;
    }
  }
  MESSAGE(tried << " mechanisms: " << couplings << " with couplings, " << driven << " and " << motions
                << " with motions of the tree and of loops, " << armatures << " with armatures, " << forces << " with calls, "
                << redundant << " redundant; " << typical << " of " << 3 * tried
                << " evaluations agree to 1e-12; worst relative to the weakest pivot " << worst);
  CHECK(typical > 2.9 * tried);
  CHECK(tried > 300);
  CHECK(called == 3 * tried);
  CHECK(couplings > 30);
  CHECK(motions > 10);
  CHECK(driven > 20);
  CHECK(armatures > 60);
  CHECK(forces > 100);
  CHECK(redundant > 5);
}

namespace {

constexpr const char* strict = "-Wall -Wextra -Wpedantic -Wconversion -Wshadow";

// A platform on legs of a universal joint, a slide and a ball: the rows of all its loops are coupled.
Model platform(int legs) {
  Model model;
  BodyId plate = ground;
  for (int k = 0; k < legs; ++k) {
    const std::string name = "leg " + std::to_string(k);
    const Vec3 foot{std::cos(1.0 * k), std::sin(1.3 * k), 0}, hip{0.4 * std::cos(1.0 * k), 0.5 * std::sin(1.3 * k), 0};
    const BodyId lower = model.add({.name = name,
                                    .mass = 2,
                                    .com = {0, 0, 0.2},
                                    .inertia = diagonal(0.03, 0.03, 0.01),
                                    .at = foot,
                                    .joint = Universal{.axis = x_axis, .axis2 = y_axis},
                                    .q = {0.1, 0.2}});
    const BodyId upper = model.add({.name = name + " rod",
                                    .mass = 1,
                                    .com = {0, 0, -0.2},
                                    .inertia = diagonal(0.02, 0.02, 0.01),
                                    .parent = lower,
                                    .joint = Prismatic{.axis = z_axis, .damping = 5},
                                    .q = 0.9});
    if (k == 0)
      plate = model.add(
          {.name = "plate", .mass = 8, .inertia = diagonal(0.4, 0.4, 0.8), .parent = upper, .joint = Ball{}, .child_at = hip});
    else
      model.add_loop({.name = name + " ball", .body = upper, .to = plate, .joint = Ball{}, .at = hip});
  }
  return model;
}

// A mechanism with couplings and loops that have no forces in their joints.
Model coupled() {
  for (std::uint64_t seed = 1;; seed += 3) try {
      Model model = any_mechanism(seed);
      const World world(model, Variables::velocities);
      if (model.couplings().empty() || model.loops().empty() || !world.tree().joints_with().motions.empty()) continue;
      if (loop_obstacles(world.tree(), false).empty() && world.loop_status().rank < world.tree().nv()) return model;
    } catch (const Error&) {  // it cannot be closed
    }
}

}  // namespace

TEST_CASE("loops: compiled source gives the accelerations of the kernels, in steps and as a file") {
  const struct {
    std::string name;
    Model model;
    bool by_call;
  } cases[] = {{"four-bar", bench::four_bar(), false},
               {"windows", bench::four_bars(5), false},
               {"two arms", bench::two_arms(), false},
               {"platform", platform(7), true},
               {"couplings", coupled(), false}};
  for (const auto& c : cases) {
    CAPTURE(c.name);
    Closed closed(c.model);
    const Tree& tree = closed.tree;
    const std::vector<int> rows(closed.rows().begin(), closed.rows().end());
    const test::CompiledSource stages(kernel_source(loop_expressions(tree, rows)), strict);
    GeneratedRates rates;
    rates.loops = stages.function<LoopRatesFunction>("kernel_accelerations"), rates.rows = rows;
    KernelExpressions file = loop_expressions(tree, rows, LoopCode::file);
    file.least_pivots = chosen_loop_rows(tree, closed.world.state()).least_pivots;
    CHECK(chosen_loop_rows(tree, closed.world.state()).rows == rows);
    bool by_call = false;
    for (const Expressions::Call& call : file.expressions.calls()) by_call = by_call || call.loop < 0;
    CHECK(by_call == c.by_call);
    const test::CompiledSource compiled(kernel_source(file), strict);
    const auto alone = compiled.function<VelocityRatesFunction>("kernel_accelerations");
    Workspace<double> other(tree);
    copy_chosen_rows(tree, closed.workspace, other);
    Prng draw(7);
    std::vector<double> tau(at(tree.nv())), qdot(at(tree.nq())), udot(tau.size());
    double worst = 0;
    for (int i = 0; i < 100; ++i) {
      const std::vector<double> q = moved(draw, closed.world.state().q(), 1e-3),
                                u = moved_velocities(draw, tree, closed.world.state().u(), 0.5);
      evaluate_velocity_stage(tree, 0, q.data(), u.data(), closed.workspace);
      REQUIRE(evaluate_loop_stage(tree, 0, q.data(), u.data(), other, rates));
      const double size = 1 + largest(closed.workspace.a.get(), tree.nv());
      worst = std::fmax(worst, distance(closed.workspace.a.get(), other.a.get(), tree.nv()) / size);
      joint_forces(tree, 0, q.data(), closed.workspace, tau.data());
      alone(q.data(), u.data(), tau.data(), qdot.data(), udot.data());
      worst = std::fmax(worst, distance(closed.workspace.a.get(), udot.data(), tree.nv()) / size);
      worst = std::fmax(worst, distance(closed.workspace.qdot.get(), qdot.data(), tree.nq()));
    }
    CHECK(worst < 1e-10);
    MESSAGE(c.name << ": worst " << worst);
  }
}

TEST_CASE("loops: a row whose pivot vanishes is left out, as in the kernels") {
  // A parallelogram with all bars in one line, where its two rows are dependent; they were chosen beside that position.
  Closed closed(bench::four_bars(2));
  const Tree& tree = closed.tree;
  const std::vector<int> rows(closed.rows().begin(), closed.rows().end());
  const KernelExpressions kernel = loop_expressions(tree, rows);
  interpreted_kernel = &kernel;
  GeneratedRates generated;
  generated.loops = interpreted, generated.rows = rows;
  Workspace<double> other(tree);
  copy_chosen_rows(tree, closed.workspace, other);
  std::vector<double> q(at(tree.nq())), u(at(tree.nv()));
  bool flat = false;
  for (const double angle : {0.0, 3.141592653589793}) {  // rods along the row of their feet, bars too
    for (const int b : tree.order()) q[at(tree.first_q(b))] = tree.parent(b) < 0 ? angle : -angle;
    for (const int b : tree.order()) u[at(tree.first_p(b))] = tree.parent(b) < 0 ? -1 : 1;
    evaluate_velocity_stage(tree, 0, q.data(), u.data(), closed.workspace);
    REQUIRE(evaluate_loop_stage(tree, 0, q.data(), u.data(), other, generated));
    CHECK(std::isfinite(largest(other.a.get(), tree.nv())));
    const double* const L = closed.workspace.loops->factor.data();
    for (std::size_t i = 0; i < closed.workspace.loops->kept.elements; ++i) flat = flat || L[i] == HUGE_VAL;
    CHECK(distance(closed.workspace.a.get(), other.a.get(), tree.nv()) <
          1e-9 * (1 + largest(closed.workspace.a.get(), tree.nv())));
  }
  CHECK(flat);
}
