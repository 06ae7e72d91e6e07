// One evaluation (q, p) → (q̇, ṗ). Every coordinate is changed before each one, so that no result can be cached; to validate the
// timing, the last velocities are converted back to momenta.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <vector>

#include "models.hpp"

namespace momentree::bench {
namespace {

// Largest error of the momenta that correspond to the velocities just found, relative to the largest momentum.
double momentum_error(const Tree& tree, const std::vector<double>& q, const std::vector<double>& p,
                      const Workspace<double>& workspace) {
  std::vector<double> again(p.size());
  project_momentum(tree, q.data(), workspace.v.get(), again.data());
  double error = 0, largest = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    error = std::max(error, std::abs(again[i] - p[i]));
    largest = std::max(largest, std::abs(p[i]));
  }
  return error / largest;
}

void evaluate(benchmark::State& run, Model (*make)(int)) {
  const int bodies = static_cast<int>(run.range(0));
  const Model model = make(bodies);
  const Tree tree = compile(model);
  const State start = start_state(model, tree);
  Workspace<double> workspace(tree);
  std::vector<double> q(start.q().begin(), start.q().end()), p(start.p().begin(), start.p().end()), move(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) move[i] = 1e-4 * static_cast<double>(i % 7 + 1);

  // A free root stays in its plane, if it is in one.
  for (const int b : tree.joints_with().quaternions) std::fill_n(move.begin() + tree.first_q(b), info(tree.kind(b)).nq, 0.0);

  for (auto _ : run) {
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += move[i], move[i] = -move[i];
    evaluate_rates(tree, q.data(), p.data(), workspace);
    benchmark::DoNotOptimize(workspace.pdot.get());
    benchmark::ClobberMemory();
  }
  const double error = momentum_error(tree, q, p, workspace);
  if (!(error < 1e-9)) run.SkipWithError("the velocities do not belong to the momenta");
  run.counters["per_body"] =
      benchmark::Counter(bodies, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(evaluate, planar_chain, planar_chain)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(evaluate, floating_chain, floating_chain)->Arg(10)->Arg(60)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(evaluate, spatial_chain, spatial_chain)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(evaluate, bushy_tree, bushy_tree)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(evaluate, humanoid, humanoid)->Arg(31);

}  // namespace
}  // namespace momentree::bench
