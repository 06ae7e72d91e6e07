// Stages and states of mechanisms with closed loops; `stage` keeps its rows, `generated` is the same by generated code, `state`
// chooses them and has all reactions, `close` corrects a state as after each step; `change` makes, breaks and locks in a loop,
// without the evaluations before and after.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <vector>

#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/simulate/simulation.hpp>
#ifdef MOMENTREE_HAS_GENERATE
#include <momentree/generate/kernel_cache.hpp>
#include <momentree/generate/loop_kernel.hpp>
#endif
#include <momentree/topology/change.hpp>

#include "loop_models.hpp"

namespace momentree::bench {
namespace {

// A state at which the loops are closed.
struct Closed {
  Simulation simulation;
  Tree tree;
  State state;
  Workspace<double> workspace;
  explicit Closed(const Model& model)
      : simulation(model, {.method = "rk4"}),
        tree(simulation.world().tree()),
        state(simulation.world().state()),
        workspace(tree) {
    load_turns(tree, state, workspace);
    evaluate_velocity_state(tree, state, workspace);
  }
  // By how much J u̇ + J̇ u differs from zero, relative to u̇.
  bool wrong() {
    std::vector<double> a(workspace.a.get(), workspace.a.get() + tree.nv()), q(state.q().begin(), state.q().end()), u, later(q);
    const double h = 1e-5;
    double largest = 0, open = 0;
    for (const double x : a) largest = std::max(largest, std::abs(x));
    for (int i = 0; i < tree.nv(); ++i) u.push_back(state.u()[static_cast<std::size_t>(i)] + h * a[static_cast<std::size_t>(i)]);
    for (int i = 0; i < tree.nq(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      later[k] = q[k] + h * workspace.qdot[k];
    }
    std::vector<double> residuals(tree.loops().size());
    loop_residuals(tree, 0, later.data(), u.data(), workspace, residuals.data());
    open = loop_velocities_open(tree, workspace);
    return !(open < 1e-8 * (1 + largest));
  }
};

void report(benchmark::State& run, const Closed& world) {
  run.counters["per_body"] =
      benchmark::Counter(world.tree.bodies(), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  run.counters["rank"] = world.workspace.loops->rank;
}

void stage(benchmark::State& run, Model (*make)(int)) {
  Closed world(make(static_cast<int>(run.range(0))));
  std::vector<double> q(world.state.q().begin(), world.state.q().end()), u(world.state.u().begin(), world.state.u().end());
  for (auto _ : run) {
    evaluate_velocity_stage(world.tree, 0, q.data(), u.data(), world.workspace);
    benchmark::DoNotOptimize(world.workspace.a.get());
    benchmark::ClobberMemory();
  }
  report(run, world);
  if (world.wrong()) run.SkipWithError("the accelerations open the loops");
}
#ifdef MOMENTREE_HAS_GENERATE
void generated(benchmark::State& run, Model (*make)(int)) {
  Closed world(make(static_cast<int>(run.range(0))));
  const KernelCache kernels;
  const std::span<const int> rows = chosen_rows(world.tree, world.workspace);
  GeneratedRates code;
  code.rows = rows, code.loops = kernels.find_loops(world.tree, rows);
  if (code.loops == nullptr) return run.SkipWithError(kernels.message().c_str());
  run.counters["operations"] = static_cast<double>(loop_expressions(world.tree, rows).operations().total());
  std::vector<double> q(world.state.q().begin(), world.state.q().end()), u(world.state.u().begin(), world.state.u().end());
  for (auto _ : run) {
    benchmark::DoNotOptimize(evaluate_loop_stage(world.tree, 0, q.data(), u.data(), world.workspace, code));
    benchmark::DoNotOptimize(world.workspace.a.get());
    benchmark::ClobberMemory();
  }
  report(run, world);
  if (world.wrong()) run.SkipWithError("the accelerations open the loops");
}
#else
void generated(benchmark::State& run, Model (*)(int)) { run.SkipWithError("built without MOMENTREE_GENERATE"); }
#endif
void state(benchmark::State& run, Model (*make)(int)) {
  Closed world(make(static_cast<int>(run.range(0))));
  for (auto _ : run) {
    static_cast<void>(world.state.edit());
    evaluate_velocity_state(world.tree, world.state, world.workspace);
    benchmark::ClobberMemory();
  }
  report(run, world);
  if (world.wrong()) run.SkipWithError("the accelerations open the loops");
}
void close(benchmark::State& run, Model (*make)(int)) {
  Closed world(make(static_cast<int>(run.range(0))));
  const std::vector<double> q(world.state.q().begin(), world.state.q().end()), u(world.state.u().begin(), world.state.u().end());
  std::vector<double> to_q(q), to_u(u);
  double energy = 0;
  bool closed = true;
  for (auto _ : run) {
    to_q = q, to_u = u;
    closed = close_loops(world.tree, 0, to_q.data(), to_u.data(), world.workspace, energy) && closed;
    benchmark::ClobberMemory();
  }
  report(run, world);
  if (!closed) run.SkipWithError("the loops are not closed");
}

double seconds_of_thread() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A change at an evaluated state, without what follows it: the next evaluation.
template <class Change>
void change(benchmark::State& run, Model (*make)(int), Change (*change_of)(const Closed&)) {
  const Closed world(make(static_cast<int>(run.range(0))));
  const Change action = change_of(world);
  for (auto _ : run) {
    Tree tree = world.tree;
    State state = world.state;
    Workspace<double> workspace(tree);
    forward_dynamics(tree, state, workspace);
    const double start = seconds_of_thread();
    apply(action, tree, state, workspace);
    run.SetIterationTime(seconds_of_thread() - start);
  }
}
Lock lock_of(const Closed& world) { return {world.tree.joint_of(world.tree.bodies() / 2)}; }
BreakLoop break_of(const Closed& world) { return {world.tree.loops()[0].id()}; }
MakeLoop make_of(const Closed& world) {
  MakeLoop made{world.tree.loops()[0], 0};
  made.loop.number = 1, made.loop.body = world.tree.bodies() / 2;
  Workspace<double> workspace(world.tree);
  locate_bodies(world.tree, world.state, workspace);
  const Kinematics<double>& at = workspace.bodies[static_cast<std::size_t>(made.loop.body)];
  made.loop.joint.at.position = at.r, made.loop.joint.child_at = {};
  return made;
}

#define MOMENTREE_LOOP_BENCHMARK(model, bodies)            \
  BENCHMARK_CAPTURE(stage, model, model)->Arg(bodies);     \
  BENCHMARK_CAPTURE(generated, model, model)->Arg(bodies); \
  BENCHMARK_CAPTURE(state, model, model)->Arg(bodies);     \
  BENCHMARK_CAPTURE(close, model, model)->Arg(bodies)
MOMENTREE_LOOP_BENCHMARK(four_bar, 3);
MOMENTREE_LOOP_BENCHMARK(four_bars, 40);
MOMENTREE_LOOP_BENCHMARK(suspended_chain, 100);
MOMENTREE_LOOP_BENCHMARK(ring, 10);
MOMENTREE_LOOP_BENCHMARK(two_arms, 15);
MOMENTREE_LOOP_BENCHMARK(standing_humanoid, 31);
BENCHMARK_CAPTURE(change, lock_in_chain, suspended_chain, lock_of)->Arg(100)->Iterations(3000)->UseManualTime();
BENCHMARK_CAPTURE(change, break_of_chain, suspended_chain, break_of)->Arg(100)->Iterations(3000)->UseManualTime();
BENCHMARK_CAPTURE(change, second_loop_of_chain, suspended_chain, make_of)->Arg(100)->Iterations(3000)->UseManualTime();

}  // namespace
}  // namespace momentree::bench
