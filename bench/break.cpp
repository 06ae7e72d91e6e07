// The topology change alone, without the evaluations before and after it: two fifths of the way along, the outer part falls off.
// Every repetition starts from a fresh world, made outside the time that counts.
#include <benchmark/benchmark.h>

#include <chrono>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>

#include "models.hpp"

namespace momentree::bench {
namespace {

void break_joint(benchmark::State& run, Model (*make)(int)) {
  const int bodies = static_cast<int>(run.range(0));
  const Model model = make(bodies);
  const Tree whole = compile(model);
  const State start = start_state(model, whole);
  const Break change{Body{bodies * 2 / 5}};

  for (auto _ : run) {
    Tree tree = compile(model);
    State state = start;
    Work<double> work(tree);
    forward_dynamics(tree, state, work);
    const auto begin = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(apply(change, tree, state, work));
    run.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (tree.parent(change.body.index) >= 0) run.SkipWithError("the body did not come off");
  }
}
BENCHMARK_CAPTURE(break_joint, planar_chain, planar_chain)->Arg(10)->Arg(100)->Arg(1000)->UseManualTime();
BENCHMARK_CAPTURE(break_joint, spatial_chain, spatial_chain)->Arg(10)->Arg(100)->Arg(1000)->UseManualTime();
BENCHMARK_CAPTURE(break_joint, bushy_tree, bushy_tree)->Arg(10)->Arg(100)->Arg(1000)->UseManualTime();

}  // namespace
}  // namespace momentree::bench
