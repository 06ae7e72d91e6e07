// Topology changes without the evaluations before and after them, at two fifths of the chain. Every repetition starts from a copy
// of the same world, made and evaluated outside the measured time.
#include <benchmark/benchmark.h>

#include <chrono>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/topology/change.hpp>

#include "models.hpp"

namespace momentree::bench {
namespace {

struct Worlds {
  Tree tree;
  State state;
  Workspace<double> workspace;
  int middle;
  Worlds(const Model& model)
      : tree(compile(model)), state(start_state(model, tree)), workspace(tree), middle(model.size() * 2 / 5) {}
  template <class Change>
  void before(const Change& change) {
    forward_dynamics(tree, state, workspace);
    apply(change, tree, state, workspace);
  }
};

template <class Change>
void measure(benchmark::State& run, const Worlds& start, const Change& change) {
  Tree tree = start.tree;
  State state = start.state;
  Workspace<double> workspace(tree);
  for (auto _ : run) {
    tree = start.tree;
    state = start.state;
    forward_dynamics(tree, state, workspace);
    const auto begin = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(apply(change, tree, state, workspace));
    run.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  if (tree.revision() == start.tree.revision()) run.SkipWithError("nothing changed");
}

using Make = Model (*)(int);

void break_joint(benchmark::State& run, Make make) {
  const Worlds w(make(static_cast<int>(run.range(0))));
  measure(run, w, Break{{w.middle}});
}
void lock(benchmark::State& run, Make make) {
  const Worlds w(make(static_cast<int>(run.range(0))));
  measure(run, w, Lock{{w.middle}});
}
void unlock(benchmark::State& run, Make make) {
  Worlds w(make(static_cast<int>(run.range(0))));
  w.before(Lock{{w.middle}});
  measure(run, w, Unlock{{w.middle}});
}
/// The outer part, cut off before, is welded on again at its root.
void weld(benchmark::State& run, Make make) {
  Worlds w(make(static_cast<int>(run.range(0))));
  const int outer = w.tree.parent(w.middle);
  w.before(Break{{w.middle}});
  Attach weld;
  weld.body = {w.middle}, weld.to = {outer};
  weld.joint.at = {{0.1, 0, 0}, {}};
  measure(run, w, weld);
}
/// The joint in the middle becomes a weld.
void stiffen(benchmark::State& run, Make make) {
  const Worlds w(make(static_cast<int>(run.range(0))));
  ChangeJoint weld;
  weld.joint = w.tree.inboard_joint({w.middle});
  measure(run, w, weld);
}
/// Re-roots a floating chain from its first body to its last.
void reroot(benchmark::State& run, Make make) {
  Worlds w(make(static_cast<int>(run.range(0))));
  w.before(Break{{0}});
  measure(run, w, Reroot{{w.tree.bodies() - 1}});
}

/// A complete event as a user schedules it, by name: including order, refusals, evaluations and certificate; alternately a lock
/// and an unlock.
void event(benchmark::State& run, Make make) {
  const Model model = make(static_cast<int>(run.range(0)));
  Simulation simulation(model);
  const std::string joint = model[BodyId{model.size() * 2 / 5}].joint_name;
  const Action actions[] = {momentree::lock(joint), momentree::unlock(joint)};
  double inside = 0;
  std::size_t turn = 0;
  for (auto _ : run) {
    const auto begin = std::chrono::steady_clock::now();
    const Event& done = simulation.apply(actions[turn++ % 2]);
    run.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    inside += done.duration_ns;
    if (turn % 1000 == 0) simulation = Simulation(model);  // keeps the list of events short
  }
  run.counters["change_ns"] = inside / static_cast<double>(turn);
}

#define MEASURE(change)                                                                                   \
  BENCHMARK_CAPTURE(change, planar_chain, planar_chain)->Arg(10)->Arg(100)->Arg(1000)->UseManualTime();   \
  BENCHMARK_CAPTURE(change, spatial_chain, spatial_chain)->Arg(10)->Arg(100)->Arg(1000)->UseManualTime(); \
  BENCHMARK_CAPTURE(change, bushy_tree, bushy_tree)->Arg(10)->Arg(100)->Arg(1000)->UseManualTime()
MEASURE(break_joint);
MEASURE(lock);
MEASURE(unlock);
MEASURE(weld);
MEASURE(stiffen);
MEASURE(reroot);
MEASURE(event);

}  // namespace
}  // namespace momentree::bench
