#pragma once
// Definitions of the two recursions in momenta; included only by instantiate/*.cpp, each for one scalar.
//
// Passes call the steps of a StepTable; those of plane mechanisms in stages are apart.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/dynamics/steps/in_plane.ipp>
#include <momentree/dynamics/steps/step_stage.ipp>
#include <momentree/math/pack.hpp>

namespace momentree {

/// Sines and cosines of angle(0), angle(1) …, in small blocks.
template <class T, class Angle>
MOMENTREE_INLINE void sincos_in_blocks(int n, const Angle& angle, T* s, T* c) {
  if constexpr (std::is_same_v<T, double>) {
    sincos_by_fours(n, angle, s, c);
  } else {
    constexpr int block = 64;
    T some[block];
    for (int first = 0; first < n; first += block) {
      const int count = n - first < block ? n - first : block;
      for (int i = 0; i < count; ++i) some[i] = angle(first + i);
      sincos(count, some, s + first, c + first);
    }
  }
}

/// Sines and cosines of the joint angles including θ0; for mechanisms that are evaluated in a plane, of the bodies' absolute
/// angles instead.
template <class T, class InPlane>
MOMENTREE_INLINE void find_sines(const Tree& tree, const T* q, Workspace<T>& workspace, bool any_plane, const InPlane& in_plane) {
  const int* const coordinates = tree.tables().angle_q.data();
  const double* const offsets = tree.tables().angle_offset.data();
  const int n = static_cast<int>(tree.tables().angle_q.size());
  T *const s = workspace.sin.get(), *const c = workspace.cos.get();
  const auto angle = [&](int i) MOMENTREE_INLINE_LAMBDA { return q[coordinates[i]] + offsets[i]; };
  if (!any_plane) return sincos_in_blocks(n, angle, s, c);
  for (int i = 0; i < n; ++i) s[i] = angle(i);
  for (const KernelRun& run : tree.tables().runs)
    if (in_plane(run)) add_up_angles(tree, run, s);
  sincos_in_blocks(
      n, [s](int i) MOMENTREE_INLINE_LAMBDA { return s[i]; }, s, c);
}

template <class T>
void reduce_momenta(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  find_sines(tree, q, workspace, false, [](const KernelRun&) { return false; });
  StepArrays arrays = step_arrays(tree, Passes::momenta, q, workspace);
  arrays.p = p;
  keeping_steps(tree, Passes::momenta, workspace).inboard(arrays);
}
template <class T>
void resolve_momenta(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  StepArrays arrays = step_arrays(tree, Passes::momenta, q, workspace);
  arrays.p = p;
  const Vec3& g = tree.gravity();
  const Vector3<T> gravity{T(g.x), T(g.y), T(g.z)};
  keeping_steps(tree, Passes::momenta, workspace).outboard(arrays, &gravity);
}
template <class T>
void evaluate_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  reduce_momenta(tree, q, p, workspace);
  resolve_momenta(tree, q, p, workspace);
}

template <class T>
void evaluate_rates(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  const bool by_steps = takes_steps(tree, Passes::stage_momenta, workspace);
  if constexpr (std::is_same_v<T, double>)
    if (!by_steps) return evaluate_motions<T>(tree, q, p, workspace);
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto in_plane = [](const KernelRun& run) { return run.planar; };
  bool any_plane = false;
  for (const KernelRun& run : tree.tables().runs) any_plane = any_plane || run.planar;
  find_sines(tree, q, workspace, any_plane, in_plane);
  const Vec3& g = tree.gravity();
  const bool has_gravity = g.x != 0 || g.y != 0 || g.z != 0;
  const InPlaneSweep<T> planar{tree, p, workspace};
  StepArrays arrays = step_arrays(tree, Passes::stage_momenta, q, workspace);
  arrays.p = p;
  workspace.steps->inboard(arrays);
  for (const KernelRun& run : tree.tables().runs)
    if (run.planar) has_gravity ? planar.template inboard<true>(run) : planar.template inboard<false>(run);
  const Vector3<T> gravity{T(g.x), T(g.y), T(g.z)};
  workspace.steps->outboard(arrays, &gravity);
  for (const KernelRun& run : tree.tables().runs)
    if (run.planar) has_gravity ? planar.template outboard<true>(run) : planar.template outboard<false>(run);
}

}  // namespace momentree
