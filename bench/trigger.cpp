// The cost of a trigger that does not fire: a step without triggers, with a trigger on a position, and with one on a reaction,
// which needs the second recursion after each step; the cost of that recursion is measured separately. Beyond it, a trigger
// should cost at most a twentieth of the step.
#include <benchmark/benchmark.h>

#include <momentree/simulate/simulation.hpp>
#include <string>

#include "models.hpp"

namespace momentree::bench {
namespace {

enum class Trigger { none, position, reaction, look };

void step(benchmark::State& run, Model (*make)(int), Trigger trigger) {
  const int bodies = static_cast<int>(run.range(0));
  Simulation sim(make(bodies), {.step = 1e-5});
  const std::string joint = "b/" + std::to_string((bodies + 1) / 2);
  if (trigger == Trigger::position) sim.when(position_of(joint).exceeds(1e9)).then(break_joint(joint));
  if (trigger == Trigger::reaction) sim.when(reaction_force(joint).exceeds(1e12)).then(break_joint(joint));
  double least = HUGE_VAL;
  for (auto _ : run) {
    if (sim.step(1e-5) != Status::ok) return run.SkipWithError(sim.result().reason.c_str());
    if (trigger == Trigger::look)  // the second recursion, called directly
      least = std::min(least, norm(sim.world().joint_forces({0}).reaction.force));
  }
  benchmark::DoNotOptimize(least);
  if (!sim.events().empty()) run.SkipWithError("the trigger fired");
}
void step_alone(benchmark::State& run, Model (*make)(int)) { step(run, make, Trigger::none); }
void step_and_position(benchmark::State& run, Model (*make)(int)) { step(run, make, Trigger::position); }
void step_and_reaction(benchmark::State& run, Model (*make)(int)) { step(run, make, Trigger::reaction); }
void step_and_recursion(benchmark::State& run, Model (*make)(int)) { step(run, make, Trigger::look); }
BENCHMARK_CAPTURE(step_alone, spatial_chain, spatial_chain)->Arg(10)->Arg(100);
BENCHMARK_CAPTURE(step_and_position, spatial_chain, spatial_chain)->Arg(10)->Arg(100);
BENCHMARK_CAPTURE(step_and_recursion, spatial_chain, spatial_chain)->Arg(10)->Arg(100);
BENCHMARK_CAPTURE(step_and_reaction, spatial_chain, spatial_chain)->Arg(10)->Arg(100);

}  // namespace
}  // namespace momentree::bench
