// M⁻¹ r for one more right-hand side, with the factors of an evaluation. Compare with `evaluate` and `accelerate` in the same
// run.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>

#include "models.hpp"

namespace momentree::bench {
namespace {

void solve(benchmark::State& run, Model (*make)(int)) {
  const int bodies = static_cast<int>(run.range(0));
  const Model model = make(bodies);
  const Tree tree = compile(model);
  const State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  std::vector<double> r(state.p().begin(), state.p().end()), u(r.size());
  for (double& each : r) each += 1e-3;
  for (auto _ : run) {
    r[0] += 1e-6;
    solve_mass(tree, state, workspace, r.data(), u.data());
    benchmark::DoNotOptimize(u.data());
    benchmark::ClobberMemory();
  }
  // To validate the timing, the momenta of the last velocities must be r.
  std::vector<double> again(r.size());
  project_momentum(tree, state.q().data(), u.data(), again.data());
  double error = 0, largest = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    error = std::max(error, std::abs(again[i] - r[i]));
    largest = std::max(largest, std::abs(r[i]));
  }
  if (!(error < 1e-9 * largest)) run.SkipWithError("the velocities do not belong to the momenta");
  run.counters["per_body"] =
      benchmark::Counter(bodies, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(solve, planar_chain, planar_chain)->Arg(10)->Arg(100);
BENCHMARK_CAPTURE(solve, spatial_chain, spatial_chain)->Arg(10)->Arg(100);
BENCHMARK_CAPTURE(solve, bushy_tree, bushy_tree)->Arg(100);
BENCHMARK_CAPTURE(solve, humanoid, humanoid)->Arg(31);

}  // namespace
}  // namespace momentree::bench
