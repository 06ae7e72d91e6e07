// Accelerations with all their derivatives by the state, beside the accelerations alone (`accelerate`, in the same run).
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/tangent/acceleration_tangent.hpp>

#include "models.hpp"

namespace momentree::bench {
namespace {

void jacobian(benchmark::State& run, Model (*make)(int)) {
  const int bodies = static_cast<int>(run.range(0));
  const Model model = make(bodies);
  const Tree tree = compile(model);
  State state = start_state(model, tree, Variables::velocities);
  Workspace<double> workspace(tree);
  AccelerationTangent tangent(tree);
  const auto n = static_cast<std::size_t>(tree.nv());
  std::vector<double> dq(2 * n * n), dv(2 * n * n), da(2 * n * n);
  for (std::size_t j = 0; j < n; ++j) dq[j * n + j] = dv[(n + j) * n + j] = 1;
  for (auto _ : run) {
    state.edit().u[0] += 1e-9;
    tangent.prepare(tree, state, workspace);
    tangent.along(2 * tree.nv(), dq.data(), dv.data(), da.data());
    benchmark::DoNotOptimize(da.data());
    benchmark::ClobberMemory();
  }
  for (const double each : da)
    if (!std::isfinite(each)) return run.SkipWithError("a derivative is not finite");
  run.counters["per_direction"] =
      benchmark::Counter(2 * tree.nv(), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(jacobian, spatial_chain, spatial_chain)->Arg(7)->Arg(30)->Arg(100);
BENCHMARK_CAPTURE(jacobian, humanoid, humanoid)->Arg(31);

void accelerations(benchmark::State& run, Model (*make)(int)) {
  const Model model = make(static_cast<int>(run.range(0)));
  const Tree tree = compile(model);
  State state = start_state(model, tree, Variables::velocities);
  Workspace<double> workspace(tree);
  for (auto _ : run) {
    state.edit().u[0] += 1e-9;
    accelerate(tree, state, workspace);
    benchmark::DoNotOptimize(workspace.a.get());
    benchmark::ClobberMemory();
  }
}
BENCHMARK_CAPTURE(accelerations, spatial_chain, spatial_chain)->Arg(7)->Arg(30)->Arg(100);
BENCHMARK_CAPTURE(accelerations, humanoid, humanoid)->Arg(31);

}  // namespace
}  // namespace momentree::bench
