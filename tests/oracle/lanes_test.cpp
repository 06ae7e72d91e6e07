// Evaluations of many worlds in SIMD lanes against evaluations one at a time: random trees of all joint kinds in all variants,
// with every instruction set that this CPU supports.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <bench/models.hpp>
#include <momentree/batch/batch.hpp>
#include <momentree/batch/group.hpp>
#include <momentree/batch/stepper.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/random_model.hpp>
#include <tests/oracle/rearrange.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

struct Worst {
  double q = 0, p = 0;  // of q̇ and v, and of ṗ or u̇: error relative to the tolerance
};

double largest(const double* a, int n) {
  double most = 0;
  for (int i = 0; i < n; ++i) most = std::fmax(most, std::fabs(a[i]));
  return most;
}

// One tree at as many states as there are lanes.
Worst compare(const Tree& tree, const State& middle, Prng& random, batch::TreeStepper& stepper, double epsilon) {
  const int lanes = stepper.lanes(), nq = tree.nq(), nv = tree.nv();
  const auto numbers = [&](int n) { return std::vector<double>(static_cast<std::size_t>(n * lanes)); };
  auto q = numbers(nq), p = numbers(nv), qdot = numbers(nq), pdot = numbers(nv), v = numbers(nv);
  for (int lane = 0; lane < lanes; ++lane) {
    for (int i = 0; i < nq; ++i)
      q[static_cast<std::size_t>(i * lanes + lane)] = middle.q()[static_cast<std::size_t>(i)] + random.uniform(-0.1, 0.1);
    for (int i = 0; i < nv; ++i)
      p[static_cast<std::size_t>(i * lanes + lane)] = middle.p()[static_cast<std::size_t>(i)] * random.uniform(0.5, 1.5);
  }
  if (epsilon > 1e-10)  // the scalar evaluation gets the same rounded input
    for (auto* list : {&q, &p})
      for (double& x : *list) x = static_cast<float>(x);
  stepper.rates(tree, batch::TopologyPlan(tree, stepper.scalars()), q.data(), p.data(), qdot.data(), pdot.data(), v.data());
  Workspace<double> workspace(tree);
  std::vector<double> one_q(static_cast<std::size_t>(nq)), one_p(static_cast<std::size_t>(nv));
  Worst worst;
  for (int lane = 0; lane < lanes; ++lane) {
    for (int i = 0; i < nq; ++i) one_q[static_cast<std::size_t>(i)] = q[static_cast<std::size_t>(i * lanes + lane)];
    for (int i = 0; i < nv; ++i) one_p[static_cast<std::size_t>(i)] = p[static_cast<std::size_t>(i * lanes + lane)];
    // Velocities are accurate to the condition of the mass matrix times the precision; so are the quantities derived from them.
    const double known = epsilon * velocity_resolution(tree, one_q) / 1e-16;
    evaluate_rates<double>(tree, one_q.data(), one_p.data(), workspace);
    const double speed = largest(workspace.v.get(), nv) + largest(workspace.qdot.get(), nq) + 1e-3;
    const double rate = largest(workspace.pdot.get(), nv) + 1e-3;
    const double allowed = std::fmax(1e4 * epsilon, 30 * known);
    for (int i = 0; i < nv; ++i) {
      const auto at = static_cast<std::size_t>(i * lanes + lane), here = static_cast<std::size_t>(i);
      worst.q = std::fmax(worst.q, std::fabs(v[at] - workspace.v[here]) / (allowed * speed));
      worst.p = std::fmax(worst.p, std::fabs(pdot[at] - workspace.pdot[here]) / (allowed * rate));
      if (!std::isfinite(v[at] + pdot[at])) worst.q = HUGE_VAL;
    }
    for (int i = 0; i < nq; ++i) {
      const auto at = static_cast<std::size_t>(i * lanes + lane), here = static_cast<std::size_t>(i);
      worst.q = std::fmax(worst.q, std::fabs(qdot[at] - workspace.qdot[here]) / (allowed * speed));
    }
  }
  return worst;
}

// The same for velocities: the scalar evaluation without joint forces.
Worst compare_velocities(const Tree& tree, const State& middle, Prng& random, batch::TreeStepper& stepper, double epsilon) {
  const int lanes = stepper.lanes(), nq = tree.nq(), nv = tree.nv();
  const auto numbers = [&](int n) { return std::vector<double>(static_cast<std::size_t>(n * lanes)); };
  auto q = numbers(nq), u = numbers(nv), qdot = numbers(nq), udot = numbers(nv), v = numbers(nv);
  Workspace<double> workspace(tree);
  std::vector<double> one_q(static_cast<std::size_t>(nq)), one_u(static_cast<std::size_t>(nv));
  const auto take = [&](int lane) {
    for (int i = 0; i < nq; ++i) one_q[static_cast<std::size_t>(i)] = q[static_cast<std::size_t>(i * lanes + lane)];
    for (int i = 0; i < nv; ++i) one_u[static_cast<std::size_t>(i)] = u[static_cast<std::size_t>(i * lanes + lane)];
  };
  for (int lane = 0; lane < lanes; ++lane) {
    for (int i = 0; i < nq; ++i)
      q[static_cast<std::size_t>(i * lanes + lane)] = middle.q()[static_cast<std::size_t>(i)] + random.uniform(-0.1, 0.1);
    for (int i = 0; i < nv; ++i) u[static_cast<std::size_t>(i * lanes + lane)] = random.uniform(-1, 1);
  }
  for (const int b : tree.order())
    for (int i = 0; i < batch::dofs_of(tree, b); ++i)
      for (int lane = 0; lane < lanes; ++lane)
        if (((tree.link(b).locked & ~tree.link(b).driven) >> i & 1u) != 0)
          u[static_cast<std::size_t>((tree.first_p(b) + i) * lanes + lane)] = 0;
  if (epsilon > 1e-10)
    for (auto* list : {&q, &u})
      for (double& x : *list) x = static_cast<float>(x);
  stepper.rates(tree, batch::TopologyPlan(tree, stepper.scalars()), q.data(), u.data(), qdot.data(), udot.data(), v.data());
  Worst worst;
  for (int lane = 0; lane < lanes; ++lane) {
    take(lane);
    const double allowed = std::fmax(1e4 * epsilon, 30 * epsilon * velocity_resolution(tree, one_q) / 1e-16);
    sweep_velocities<double, false>(tree, one_q.data(), one_u.data(), workspace);
    std::fill_n(workspace.a.get(), nv, 0.0);
    solve_accelerations<double, false>(tree, one_q.data(), workspace, {-tree.gravity(), {}});
    const double speed = largest(workspace.qdot.get(), nq) + 1e-3, rate = largest(workspace.a.get(), nv) + 1e-3;
    for (int i = 0; i < nv; ++i) {
      const auto at = static_cast<std::size_t>(i * lanes + lane), here = static_cast<std::size_t>(i);
      if (v[at] != u[at] || !std::isfinite(udot[at])) worst.q = HUGE_VAL;
      worst.p = std::fmax(worst.p, std::fabs(udot[at] - workspace.a[here]) / (allowed * rate));
    }
    for (int i = 0; i < nq; ++i) {
      const auto at = static_cast<std::size_t>(i * lanes + lane), here = static_cast<std::size_t>(i);
      worst.q = std::fmax(worst.q, std::fabs(qdot[at] - workspace.qdot[here]) / (allowed * speed));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("a lane gives the scalar's rates, on trees of all kinds and variants") {
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512}) {
    if (!batch::available(isa)) {
      MESSAGE("this CPU does not have instruction set number " << static_cast<int>(isa));
      continue;
    }
    for (const Variables variables : {Variables::momenta, Variables::velocities})
      for (const Precision precision : {Precision::float64, Precision::float32}) {
        const bool wide = precision == Precision::float64;
        // The tolerance is 1e-12 in double precision. In single precision, trees of light and heavy bodies are inaccurate: only
        // short trees.
        const double epsilon = wide ? 1e-16 : 6e-8;
        bool seen[9][5] = {};
        Worst all;
        for (std::uint64_t seed = 0; seed < 600; ++seed) {
          const RandomTree random = random_tree(seed, {.max_bodies = wide ? 40 : 6, .drives = true});
          Tree tree(random.model);
          Prng draw(seed + 500);
          Workspace<double> workspace(tree);
          State state = start_state(random.model, tree);
          if (seed % 2 == 1) rearrange(draw, tree, state, workspace);
          for (const KernelRun& s : tree.tables().runs) seen[static_cast<int>(s.kind)][static_cast<int>(s.variant)] = true;
          const auto stepper = batch::make_stepper(isa, precision, tree, variables);
          const Worst worst = variables == Variables::momenta ? compare(tree, state, draw, *stepper, epsilon)
                                                              : compare_velocities(tree, state, draw, *stepper, epsilon);
          CAPTURE(seed);
          CHECK(worst.q <= 1);
          CHECK(worst.p <= 1);
          all = {std::fmax(all.q, worst.q), std::fmax(all.p, worst.p)};
        }
        MESSAGE("instruction set " << static_cast<int>(isa)
                                   << std::string(wide ? ", double" : ", float") +
                                          (variables == Variables::momenta ? ", momenta" : ", velocities")
                                   << ": worst of velocities " << all.q << " of what is allowed, of the variables' rates "
                                   << all.p);
        int combinations = 0;
        for (const auto& kind : seen)
          for (const bool variant : kind) combinations += variant ? 1 : 0;
        CHECK(combinations >= (wide ? 25 : 18));
      }
  }
}

namespace {

// Worlds in velocities and in momenta that begin alike, after a time in so many steps.
struct Both {
  Both(const Model& model, const std::vector<double>& v, double time, int steps)
      : u(model, worlds, {.variables = Variables::velocities}), p(model, worlds) {
    for (Batch* batch : {&u, &p}) {
      batch->write(all, nullptr, nullptr, v.data(), Variables::velocities);
      for (int k = 0; k < steps; ++k) batch->step(time / steps);
    }
  }
  // Coordinates and velocities of all worlds.
  std::vector<double> numbers(Batch& batch) const {
    const auto nq = static_cast<std::size_t>(worlds * batch.nq(0)), nv = static_cast<std::size_t>(worlds * batch.nv(0));
    std::vector<double> both(nq + nv);
    batch.read(all, nullptr, both.data(), nullptr, both.data() + nq);
    return both;
  }
  static constexpr int worlds = 5;
  static inline const std::vector<int> all = {0, 1, 2, 3, 4};
  Batch u, p;
};

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::fmax(most, std::fabs(a[i] - b[i]));
  return most;
}

}  // namespace

TEST_CASE("steps in velocities: as a world alone, and as steps in momenta, on mechanisms of all kinds") {
  constexpr double time = 5e-4;
  constexpr int steps = 5;
  double alone = 0, momenta = 0;
  int batches = 0, planes = 0, same = 0, converging = 0;
  for (std::uint64_t seed = 0; seed < 240; ++seed) {
    CAPTURE(seed);
    const bool drives = seed % 3 == 1;  // they change the forces suddenly, so that errors fall slowly
    const Model model = seed % 6 == 0 ? bench::planar_chain(2 + static_cast<int>(seed) % 20)
                                      : random_tree(seed, {.max_bodies = 20, .drives = drives}).model;
    const Tree tree(model);
    if (batch::unsupported(tree)) continue;
    ++batches;
    for (const KernelRun& run : tree.tables().runs) planes += run.planar ? 1 : 0;
    const auto nq = static_cast<std::size_t>(tree.nq()), nv = static_cast<std::size_t>(tree.nv());
    Prng random(seed + 77);
    std::vector<double> v(Both::worlds * nv);
    for (double& x : v) x = random.uniform(-1, 1);
    Both coarse(model, v, time, steps);
    const std::vector<double> found = coarse.numbers(coarse.u);
    const double size = largest(found.data(), static_cast<int>(found.size())) + 1;
    const double resolution = size * std::fmax(1e-13, 30 * velocity_resolution(tree, {found.data(), nq}));
    for (int i = 0; i < Both::worlds; ++i) {
      REQUIRE_FALSE(coarse.u.diverged(i));
      Simulation single(model, {.method = "rk4", .variables = Variables::velocities});
      const State start = Both(model, v, time, 0).u.state(i);
      single.set_state(0, start.q(), start.u(), Variables::velocities);
      for (int k = 0; k < steps; ++k) REQUIRE(single.step(time / steps).status == Status::ok);
      const State& own = single.world().state();
      const State lane = coarse.u.state(i);
      for (std::size_t k = 0; k < nv; ++k) alone = std::fmax(alone, std::fabs(own.u()[k] - lane.u()[k]) / resolution);
      for (std::size_t k = 0; k < nq; ++k) alone = std::fmax(alone, std::fabs(own.q()[k] - lane.q()[k]) / resolution);
    }
    CHECK(alone <= 1);
    // Both variables are integrated by a method of order 4: their difference is its error, and falls with shorter steps.
    const double off = difference(found, coarse.numbers(coarse.p));
    if (off <= resolution) {
      ++same;
      continue;
    }
    if (drives) continue;
    Both fine(model, v, time, 4 * steps);
    const double less = difference(fine.numbers(fine.u), fine.numbers(fine.p));
    const double part = less / std::fmax(off / 100, 4 * resolution);
    CAPTURE(off);
    CAPTURE(less);
    CHECK(part <= 1);
    momenta = std::fmax(momenta, part);
    ++converging;
  }
  MESSAGE("worst: " << alone << " of what is allowed to a world alone, " << momenta << " to momenta; " << batches << " batches, "
                    << same << " equal and " << converging << " convergent");
  CHECK(batches > 100);
  CHECK(planes > 30);
  CHECK(same + converging > batches / 2);
}
