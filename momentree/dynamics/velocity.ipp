#pragma once
// Velocities as the state: (q, u) → u̇ by three passes, outward, inward, outward (body_passes.hpp). Included only by
// instantiate/*.cpp.
#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/dynamics/steps/step_stage.ipp>
#include <momentree/dynamics/steps/velocity_in_plane.ipp>

namespace momentree {

/// Calls f for the kernel runs of plane mechanisms.
template <class F>
MOMENTREE_INLINE void each_in_plane(const Tree& tree, F&& f) {
  for (const KernelRun& run : tree.tables().runs)
    if (run.planar) f(run);
}

template <class T, bool Keep>
void sweep_velocities(const Tree& tree, const T* q, const T* u, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  if constexpr (!Keep)
    if (!takes_steps(tree, Passes::stage_velocities, workspace)) {
      if constexpr (std::is_same_v<T, double>) return sweep_velocities<T, true>(tree, q, u, workspace);
    }
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto in_plane = [](const KernelRun& run) { return !Keep && run.planar; };
  bool any_plane = false;
  for (const KernelRun& run : tree.tables().runs) any_plane = any_plane || in_plane(run);
  find_sines(tree, q, workspace, any_plane, in_plane);
  for (int i = 0; i < tree.nv(); ++i) workspace.v[i] = u[i];
  if constexpr (Keep) {
    keeping_steps(tree, Passes::velocities, workspace).velocities(step_arrays(tree, Passes::velocities, q, workspace));
  } else {
    workspace.steps->velocities(step_arrays(tree, Passes::stage_velocities, q, workspace));
    const InPlaneVelocitySweep<T> planar{tree, workspace};
    each_in_plane(tree, [&](const KernelRun& run) { planar.velocities(run); });
  }
}

template <class T, bool Keep>
void reduce_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept {
  if constexpr (!Keep)
    if (!takes_steps(tree, Passes::stage_velocities, workspace)) {
      if constexpr (std::is_same_v<T, double>) return reduce_accelerations<T, true>(tree, q, workspace);
    }
  if constexpr (Keep) {
    keeping_steps(tree, Passes::velocities, workspace).inboard(step_arrays(tree, Passes::velocities, q, workspace));
  } else {
    workspace.steps->inboard(step_arrays(tree, Passes::stage_velocities, q, workspace));
    const InPlaneVelocitySweep<T> planar{tree, workspace};
    each_in_plane(tree, [&](const KernelRun& run) { planar.inboard(run); });
  }
}

template <class T, bool Keep>
void resolve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept {
  if constexpr (!Keep)
    if (!takes_steps(tree, Passes::stage_velocities, workspace)) {
      if constexpr (std::is_same_v<T, double>) return resolve_accelerations<T, true>(tree, q, workspace, base);
    }
  if constexpr (Keep) {
    keeping_steps(tree, Passes::velocities, workspace).outboard(step_arrays(tree, Passes::velocities, q, workspace), &base.v);
  } else {
    workspace.steps->outboard(step_arrays(tree, Passes::stage_velocities, q, workspace), &base.v);
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
