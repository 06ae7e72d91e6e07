// Many worlds in SIMD lanes: one evaluation of as many worlds as there are lanes, and whole steps of a batch. Compare with
// `evaluate` in the same run.
#include <benchmark/benchmark.h>

#include <cmath>
#include <momentree/batch/batch.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <vector>

#include <momentree/simulate/simulation.hpp>

#include "loop_models.hpp"
#include "models.hpp"

namespace momentree::bench {
namespace {

const char* name_of(Isa isa) { return isa == Isa::baseline ? "baseline" : isa == Isa::avx2 ? "avx2" : "avx512"; }

// per_body: seconds per body and world.
void count(benchmark::State& run, int bodies, int worlds, int evaluations, Isa isa) {
  run.counters["per_body"] = benchmark::Counter(1.0 * bodies * worlds * evaluations,
                                                benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  run.SetLabel(name_of(isa));
}

void lanes(benchmark::State& run, Model (*make)(int), Precision precision) {
  const int bodies = static_cast<int>(run.range(0));
  const Isa isa = static_cast<Isa>(run.range(1));
  if (!batch::available(isa)) return run.SkipWithError("not on this CPU");
  const Model model = make(bodies);
  const Tree tree = compile(model);
  const State start = start_state(model, tree);
  const auto stepper = batch::make_stepper(isa, precision, tree);
  const batch::TopologyPlan plan(tree, stepper->scalars());
  const int n = stepper->lanes();
  const auto numbers = [&](int count) { return std::vector<double>(static_cast<std::size_t>(count * n)); };
  auto q = numbers(tree.nq()), p = numbers(tree.nv()), qdot = q, pdot = p, v = p, move = q;
  for (std::size_t i = 0; i < q.size(); ++i)
    q[i] = start.q()[i / static_cast<std::size_t>(n)], move[i] = 1e-4 * static_cast<double>(i % 7 + 1);
  for (std::size_t i = 0; i < p.size(); ++i) p[i] = start.p()[i / static_cast<std::size_t>(n)];
  for (auto _ : run) {
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += move[i], move[i] = -move[i];
    stepper->rates(tree, plan, q.data(), p.data(), qdot.data(), pdot.data(), v.data());
    benchmark::DoNotOptimize(pdot.data());
    benchmark::ClobberMemory();
  }
  // To validate the timing, the velocities of the last world must match its momenta.
  std::vector<double> one_q(start.q().size()), one_v(start.p().size()), again(start.p().size());
  for (std::size_t i = 0; i < one_q.size(); ++i) one_q[i] = q[(i + 1) * static_cast<std::size_t>(n) - 1];
  for (std::size_t i = 0; i < one_v.size(); ++i) one_v[i] = v[(i + 1) * static_cast<std::size_t>(n) - 1];
  project_momentum(tree, one_q.data(), one_v.data(), again.data());
  double error = 0, largest = 0;
  for (std::size_t i = 0; i < again.size(); ++i) {
    error = std::fmax(error, std::fabs(again[i] - start.p()[i]));
    largest = std::fmax(largest, std::fabs(start.p()[i]));
  }
  if (!(error < (precision == Precision::float64 ? 1e-9 : 1e-2) * largest))
    run.SkipWithError("the velocities do not belong to the momenta");
  count(run, bodies, n, 1, isa);
}

void batch_step(benchmark::State& run, Model (*make)(int), Precision precision, Variables variables) {
  const Model model = make(static_cast<int>(run.range(0)));
  const int bodies = static_cast<int>(model.bodies().size());
  Batch batch(model, 64, {.precision = precision, .variables = variables});
  for (auto _ : run) {
    batch.step(1e-5);
    benchmark::ClobberMemory();
  }
  for (int world = 0; world < batch.worlds(); ++world)
    if (batch.diverged(world)) run.SkipWithError("a world ran away");
  count(run, bodies, batch.worlds(), 4, batch.isa());
}

#define MOMENTREE_STEPS(model, name, precision, ...)                                                                 \
  BENCHMARK_CAPTURE(batch_step, model##_##name, model, precision, Variables::momenta)->ArgsProduct({{__VA_ARGS__}}); \
  BENCHMARK_CAPTURE(batch_step, model##_velocities_##name, model, precision, Variables::velocities)->ArgsProduct({{__VA_ARGS__}})
#define MOMENTREE_LANES(model, ...)                                                                             \
  BENCHMARK_CAPTURE(lanes, model##_double, model, Precision::float64)->ArgsProduct({{__VA_ARGS__}, {0, 1, 2}}); \
  BENCHMARK_CAPTURE(lanes, model##_float, model, Precision::float32)->ArgsProduct({{__VA_ARGS__}, {0, 1, 2}});  \
  MOMENTREE_STEPS(model, double, Precision::float64, __VA_ARGS__);                                              \
  MOMENTREE_STEPS(model, float, Precision::float32, __VA_ARGS__)
MOMENTREE_LANES(planar_chain, 10, 100);
MOMENTREE_LANES(spatial_chain, 10, 100);
MOMENTREE_LANES(bushy_tree, 100);
MOMENTREE_LANES(humanoid, 31);

// With closed loops; compare with step_with_loops, of one simulation.
void step_with_loops(benchmark::State& run, Model (*make)(int)) {
  const Model model = make(static_cast<int>(run.range(0)));
  Simulation simulation(model, {.method = "rk4", .variables = Variables::velocities, .step = 1e-5});
  for (auto _ : run) {
    if (simulation.step(1e-5) != Status::ok) return run.SkipWithError("the simulation stopped");
    benchmark::ClobberMemory();
  }
  run.counters["per_body"] = benchmark::Counter(4.0 * static_cast<double>(model.bodies().size()),
                                                benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
#define MOMENTREE_LOOPS(model, ...)                                               \
  BENCHMARK_CAPTURE(step_with_loops, model, model)->ArgsProduct({{__VA_ARGS__}}); \
  BENCHMARK_CAPTURE(batch_step, model##_loops, model, Precision::float64, Variables::velocities)->ArgsProduct({{__VA_ARGS__}})
MOMENTREE_LOOPS(four_bar, 3);
MOMENTREE_LOOPS(four_bars, 10, 40);
MOMENTREE_LOOPS(two_arms, 15);
MOMENTREE_LOOPS(standing_humanoid, 31);

}  // namespace
}  // namespace momentree::bench
