#pragma once
// Further right-hand sides for the factors of the first recursion: M u = r, by one inward and one outward pass in O(n). Included
// only by instantiate/*.cpp. Of both recursions only the parts that are linear in p or τ are left: (26), (27) and (17), or (51),
// (47) and (39), without velocities, bodies' own momenta and gravity.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/sweep_buffers.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

template <class T>
struct SolveSweep {
  UncheckedTree tree;
  const T* q;
  Workspace<T>& workspace;
  T* u;  ///< r on entry
  SweepBuffers<Force<T>, Motion<T>> buffers{tree, workspace.child_wrenches.get(), workspace.parent_accelerations.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
  }
  /// Leaves Mj⁻¹ (r − Eᵀ W) in `u`, where W is what r demands of the bodies outboard.
  template <class K>
  void inboard(const KernelRun& run) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    Force<T> W;
    buffers.resume_inward(run, W);
    for (int i = run.end - 1; i >= run.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      if ((flags & node::leaf) != 0) W = {};
      buffers.gather_children(b, flags, W);
      if constexpr (!K::rigid) {
        const LinkConstants& link = tree.link(b);
        const JointState<T> joint = joint_state(b);
        const auto& record = workspace.template record<K>(tree, b);
        T* const own = u + tree.first_p(b);
        for (int k = 0; k < info(tree.kind(b)).nv; ++k)
          if ((link.locked >> k & 1u) != 0) own[k] = T(0);
        K::template reduce_wrench<T>(link, joint, record, own, W, own);  // (51)
        wrench_inboard<K>(link, joint, record, flags, W);                // (45)
      }
      buffers.add_to_parent(b, flags, W);
    }
    buffers.suspend_inward(run, W);
  }

  template <class K>
  void outboard(const KernelRun& run) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      buffers.load_parent(b, flags, {}, a);
      if constexpr (!K::rigid) {
        const LinkConstants& link = tree.link(b);
        const JointState<T> joint = joint_state(b);
        const auto& record = workspace.template record<K>(tree, b);
        T* const own = u + tree.first_p(b);
        if (K::rotates_about_z && (flags & node::aligned) != 0)
          K::template cached_transform<true, T>(link, joint, record).outboard(a);
        else
          K::template cached_transform<false, T>(link, joint, record).outboard(a);
        K::joint_acceleration(record, a, own);                     // (47)
        a = K::template spatial_velocity<T>(link, joint, a, own);  // (39)
      }
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }
};

template <class T>
void solve_with_factors(const Tree& tree, const T* q, Workspace<T>& workspace, T* u) noexcept {
  const SolveSweep<T> sweep{tree, q, workspace, u};
  const auto kernel_runs = tree.kernel_runs();
  for (std::size_t i = kernel_runs.size(); i-- > 0;)
    dispatch_kernels(kernel_runs[i].kind, kernel_runs[i].variant,
                     [&](auto tag) { sweep.template inboard<typename decltype(tag)::type>(kernel_runs[i]); });
  for (const KernelRun& run : kernel_runs)
    dispatch_kernels(run.kind, run.variant, [&](auto tag) { sweep.template outboard<typename decltype(tag)::type>(run); });
}

}  // namespace momentree
