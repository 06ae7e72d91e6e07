#pragma once
// Definitions of the two recursions in momenta; included only by instantiate/*.cpp, each for one scalar.
//
// Stages call the steps of a StepTable. Where others read what the passes find of each body, they go over kernel runs.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/generic_steps.ipp>
#include <momentree/dynamics/in_plane.ipp>
#include <momentree/dynamics/step_stage.ipp>
#include <momentree/dynamics/sweep.hpp>
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
  const int* const coordinates = tree.angle_coordinates().data();
  const double* const offsets = tree.angle_offsets().data();
  const int n = static_cast<int>(tree.angle_coordinates().size());
  T *const s = workspace.sin.get(), *const c = workspace.cos.get();
  const auto angle = [&](int i) MOMENTREE_INLINE_LAMBDA { return q[coordinates[i]] + offsets[i]; };
  if (!any_plane) return sincos_in_blocks(n, angle, s, c);
  for (int i = 0; i < n; ++i) s[i] = angle(i);
  for (const KernelRun& run : tree.kernel_runs())
    if (in_plane(run)) add_up_angles(tree, run, s);
  sincos_in_blocks(
      n, [s](int i) MOMENTREE_INLINE_LAMBDA { return s[i]; }, s, c);
}

/// Between the passes of a tree nothing happens.
struct NothingBetween {
  template <class T>
  MOMENTREE_INLINE static void act(const Tree&, const T*, Workspace<T>&) {}
};

/// Between::act, called after the inward pass, may change u0 of the records. (As a type, not an argument: this leaves the code
/// without it as it is.)
template <class T, class Between = NothingBetween>
void sweep_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const Vec3& g = tree.gravity();
  const bool has_gravity = g.x != 0 || g.y != 0 || g.z != 0;  // if not, first moments are not summed
  find_sines(tree, q, workspace, false, [](const KernelRun&) { return false; });
  const Sweep<T> sweep{tree, q, workspace, workspace.a.get(), p};
  const SweepBuffers<Inboard<T>, Outboard<T>> buffers{tree, workspace.child_sums.get(), workspace.parent_states.get()};
  sweep.inward(tree.kernel_runs(), buffers, [&](const auto& body, int b, Inboard<T>& a) MOMENTREE_INLINE_LAMBDA {
    momentum_inboard(body, sweep.tree.armature() + sweep.tree.first_p(b), sweep.tree.subtree_mass(b), has_gravity, a);
  });
  Between::act(tree, q, workspace);
  T o(0);  // not constexpr, and written out: clearing structs has a cost that shows for small mechanisms
  const Outboard<T> base{{{o, o, o}, {o, o, o}}, {T(g.x), T(g.y), T(g.z)}};
  sweep.outward(tree.kernel_runs(), buffers, base, [&](const auto& body, int b, Outboard<T>& a) MOMENTREE_INLINE_LAMBDA {
    momentum_outboard(body, sweep.tree.subtree_mass(b), a);
  });
}

template <class T>
void evaluate_rates(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  const bool by_steps = takes_steps(tree, workspace.momentum_steps.get(), workspace);
  if constexpr (std::is_same_v<T, double>)
    if (!by_steps) return evaluate_motions<T>(tree, q, p, workspace);
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto in_plane = [](const KernelRun& run) { return run.planar; };
  bool any_plane = false;
  for (const KernelRun& run : tree.kernel_runs()) any_plane = any_plane || run.planar;
  find_sines(tree, q, workspace, any_plane, in_plane);
  const Vec3& g = tree.gravity();
  const bool has_gravity = g.x != 0 || g.y != 0 || g.z != 0;
  const InPlaneSweep<T> planar{tree, p, workspace};
  StepArrays arrays = step_arrays(tree, q, workspace);
  arrays.p = p, arrays.pdot = workspace.pdot.get(), arrays.motions = workspace.parent_states.get();
  workspace.steps->inboard(arrays);
  for (const KernelRun& run : tree.kernel_runs())
    if (run.planar) has_gravity ? planar.template inboard<true>(run) : planar.template inboard<false>(run);
  const Vector3<T> gravity{T(g.x), T(g.y), T(g.z)};
  workspace.steps->outboard(arrays, &gravity);
  for (const KernelRun& run : tree.kernel_runs())
    if (run.planar) has_gravity ? planar.template outboard<true>(run) : planar.template outboard<false>(run);
}
template <class T>
void evaluate_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  sweep_motions<T>(tree, q, p, workspace);
}

}  // namespace momentree
