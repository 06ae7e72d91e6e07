// Accelerations and all joint wrenches of a state, after its evaluation and separately: the additional cost should stay below 0.8
// of an evaluation. Every coordinate is changed before each evaluation. To validate the timing, the wrenches at the ground are
// compared with those that the motion of all bodies requires.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>

#include "models.hpp"

namespace momentree::bench {
namespace {

// Σ m (a − g) of all bodies against the forces of the joints to the ground, relative to the largest term.
double force_error(const Model& model, const Tree& tree, const State& state, Workspace<double>& workspace) {
  locate_bodies(tree, state, workspace);
  accelerate(tree, state, workspace);
  Vec3 missing{};
  double largest = 0;
  for (int b = 0; b < tree.bodies(); ++b) {
    const Kinematics<double>& body = workspace.bodies[static_cast<std::size_t>(b)];
    const Pose pose = user_pose(tree, body, b);
    const BodyAcceleration a = body_acceleration(tree, state, workspace, BodyId{b});
    const Vec3 arm = rotation_matrix(pose.rotation) * model[{b}].com, w = body.R * body.velocity.w;
    const Vec3 force = model[{b}].mass * (a.linear + cross(a.angular, arm) + cross(w, cross(w, arm)) - model.gravity());
    missing += force;
    largest = std::max(largest, norm(force));
    if (tree.parent(b) < 0)
      missing -= rotation_matrix(pose.rotation) * reaction(tree, state, workspace, tree.inboard_joint({b})).force;
  }
  return norm(missing) / largest;
}

void accelerations(benchmark::State& run, Model (*make)(int), bool evaluated) {
  const int bodies = static_cast<int>(run.range(0));
  const Model model = make(bodies);
  const Tree tree = compile(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  double move = 1e-4;
  for (auto _ : run) {
    if (evaluated) {
      for (double& q : state.edit().q) q += move;
      move = -move;
      forward_dynamics(tree, state, workspace);
    }
    workspace.accelerated = {};
    accelerate(tree, state, workspace);
    benchmark::DoNotOptimize(workspace.reduced_bias_wrenches.get());
    benchmark::ClobberMemory();
  }
  if (!(force_error(model, tree, state, workspace) < 1e-9)) run.SkipWithError("the ground does not carry what moves");
  run.counters["per_body"] =
      benchmark::Counter(bodies, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
void accelerate_alone(benchmark::State& run, Model (*make)(int)) { accelerations(run, make, false); }
void evaluate_and_accelerate(benchmark::State& run, Model (*make)(int)) { accelerations(run, make, true); }
BENCHMARK_CAPTURE(accelerate_alone, planar_chain, planar_chain)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(accelerate_alone, spatial_chain, spatial_chain)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(accelerate_alone, bushy_tree, bushy_tree)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(evaluate_and_accelerate, planar_chain, planar_chain)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(evaluate_and_accelerate, spatial_chain, spatial_chain)->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(evaluate_and_accelerate, bushy_tree, bushy_tree)->Arg(10)->Arg(100)->Arg(1000);

}  // namespace
}  // namespace momentree::bench
