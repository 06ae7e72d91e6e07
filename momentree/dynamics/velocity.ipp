#pragma once
// Velocities as the state: (q, u) → u̇ by three passes, outward, inward, outward (body_passes.hpp). Included only by
// instantiate/*.cpp. Stages call the steps of a StepTable; where others read what the passes find of each body, they go over
// kernel runs.
#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/generic_steps.ipp>
#include <momentree/dynamics/step_stage.ipp>
#include <momentree/dynamics/velocity_in_plane.ipp>

namespace momentree {

template <class T>
MOMENTREE_INLINE SweepBuffers<Inboard<T>, Motion<T>, false> velocity_buffers(const Tree& tree, Workspace<T>& workspace) {
  return {tree, workspace.child_sums.get(), workspace.parent_accelerations.get()};
}
/// Calls f for the kernel runs of plane mechanisms.
template <class F>
MOMENTREE_INLINE void each_in_plane(const Tree& tree, F&& f) {
  for (const KernelRun& run : tree.kernel_runs())
    if (run.planar) f(run);
}

template <class T>
MOMENTREE_INLINE StepArrays velocity_arrays(const Tree& tree, const T* q, Workspace<T>& workspace) {
  StepArrays arrays = step_arrays(tree, q, workspace);
  arrays.a = workspace.a.get();
  arrays.motions = workspace.parent_accelerations.get(), arrays.biases = workspace.biases.get();
  return arrays;
}

template <class T, bool Keep>
void sweep_velocities(const Tree& tree, const T* q, const T* u, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  const bool by_steps = !Keep && takes_steps(tree, workspace.velocity_steps.get(), workspace);
  if constexpr (!Keep && std::is_same_v<T, double>)
    if (!by_steps) return sweep_velocities<T, true>(tree, q, u, workspace);
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto in_plane = [](const KernelRun& run) { return !Keep && run.planar; };
  bool any_plane = false;
  for (const KernelRun& run : tree.kernel_runs()) any_plane = any_plane || in_plane(run);
  find_sines(tree, q, workspace, any_plane, in_plane);
  for (int i = 0; i < tree.nv(); ++i) workspace.v[i] = u[i];
  if constexpr (Keep) {
    const Sweep<T> sweep{tree, q, workspace, workspace.a.get()};
    sweep.outward(tree.kernel_runs(), velocity_buffers(tree, workspace), {},
                  [](const auto& body, int, Motion<T>& a) MOMENTREE_INLINE_LAMBDA { velocity_outboard(body, a); });
  } else {
    workspace.steps->velocities(velocity_arrays(tree, q, workspace));
    const InPlaneVelocitySweep<T> planar{tree, workspace};
    each_in_plane(tree, [&](const KernelRun& run) { planar.velocities(run); });
  }
}

template <class T, bool Keep>
void reduce_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept {
  const bool by_steps = !Keep && takes_steps(tree, workspace.velocity_steps.get(), workspace);
  if constexpr (!Keep && std::is_same_v<T, double>)
    if (!by_steps) return reduce_accelerations<T, true>(tree, q, workspace);
  if constexpr (Keep) {
    const Sweep<T> sweep{tree, q, workspace, workspace.a.get()};
    sweep.inward(tree.kernel_runs(), velocity_buffers(tree, workspace),
                 [&](const auto& body, int b, Inboard<T>& a)
                     MOMENTREE_INLINE_LAMBDA { force_inboard(body, sweep.tree.armature() + sweep.tree.first_p(b), a); });
  } else {
    workspace.steps->inboard(velocity_arrays(tree, q, workspace));
    const InPlaneVelocitySweep<T> planar{tree, workspace};
    each_in_plane(tree, [&](const KernelRun& run) { planar.inboard(run); });
  }
}

template <class T, bool Keep>
void resolve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept {
  const bool by_steps = !Keep && takes_steps(tree, workspace.velocity_steps.get(), workspace);
  if constexpr (!Keep && std::is_same_v<T, double>)
    if (!by_steps) return resolve_accelerations<T, true>(tree, q, workspace, base);
  if constexpr (Keep) {
    const Sweep<T> sweep{tree, q, workspace, workspace.a.get()};
    sweep.outward(tree.kernel_runs(), velocity_buffers(tree, workspace), base,
                  [](const auto& body, int, Motion<T>& a) MOMENTREE_INLINE_LAMBDA { acceleration_outboard(body, a); });
  } else {
    workspace.steps->outboard(velocity_arrays(tree, q, workspace), &base.v);
    const InPlaneVelocitySweep<T> planar{tree, workspace};
    each_in_plane(tree, [&](const KernelRun& run) { planar.outboard(run); });
  }
}

template <class T, bool Keep>
void solve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept {
  reduce_accelerations<T, Keep>(tree, q, workspace);
  resolve_accelerations<T, Keep>(tree, q, workspace, base);
}

}  // namespace momentree
