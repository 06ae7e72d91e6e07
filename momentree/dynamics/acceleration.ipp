#pragma once
// Definitions of the second recursion; included only by instantiate/*.cpp, each for one scalar. Kernel runs are processed as in
// the first recursion, with the accumulators in local variables.
//
// The paper propagates Ṗb outward and computes Tr = Ṗb + Ω × Pb − Tb from it (32), a difference that nearly cancels if the
// outboard bodies are heavy and fast. Tr itself obeys the same recursion: Tr = Mb Ω̇ + W, with the bias wrench W = Ω × P of the
// body plus the contributions of its children, and Ω̇ less gravity. No digits are lost that way.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/sweep_buffers.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

template <class T>
struct RateSweep {
  UncheckedTree tree;
  const T* q;
  Workspace<T>& workspace;
  SweepBuffers<Force<T>, Motion<T>> buffers{tree, workspace.child_wrenches.get(), workspace.parent_accelerations.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
  }

  /// Inward pass. Stores for the outward pass the bias in `inboard_accelerations` and Mj⁻¹ (τ − Eᵀ W) in `a`. Of Tr = M̂ a′ + Ŵ
  /// it stores Ŵ in `reduced_bias_wrenches`; Tr itself is computed on request only.
  template <class K>
  void inboard(const KernelRun& run) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    const Force<T>* const loads = tree.loaded_bodies().empty() ? nullptr : workspace.loads.get();
    Force<T> W;  // the children's contributions, then also the body's own
    buffers.resume_inward(run, W);
    for (int i = run.end - 1; i >= run.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      const auto body = static_cast<std::size_t>(b);
      const LinkConstants& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = workspace.template record<K>(tree, b);
      const int at = tree.first_p(b);
      T* udot = workspace.a.get() + at;  // τ on entry
      const Motion<T>& velocity = workspace.motions[body].velocity;
      if ((flags & node::leaf) != 0) W = {};
      buffers.gather_children(b, flags, W);
      W += gyroscopic_wrench(link.body, velocity);
      if (loads != nullptr) W = W - loads[body];
      if constexpr (K::rigid) {
        put(W, workspace.reduced_bias_wrenches[body]);
        put({}, workspace.inboard_accelerations[body]);
        buffers.add_to_parent(b, flags, W);
        continue;
      }
      K::template reduce_wrench<T>(link, joint, record, udot, W, udot);  // (51)
      put(W, workspace.reduced_bias_wrenches[body]);
      const Motion<T> bias = K::template acceleration_bias<T>(link, joint, velocity, workspace.v.get() + at);
      K::add_reduced_bias(record, bias, W);
      if constexpr (requires { typename K::Steps; })
        K::joint_acceleration(record, bias, udot);  // the part of (47) that does not depend on the outward pass
      else
        put(bias, workspace.inboard_accelerations[body]);
      wrench_inboard<K>(link, joint, record, flags, W);  // (45)
      buffers.add_to_parent(b, flags, W);
    }
    buffers.suspend_inward(run, W);
  }

  /// Outward pass. The ground accelerates against gravity; this gives every body its weight, so that gravity is not needed in
  /// body axes.
  template <class K>
  void outboard(const KernelRun& run, const Motion<T>& base) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      const auto body = static_cast<std::size_t>(b);
      const LinkConstants& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = workspace.template record<K>(tree, b);
      T* udot = workspace.a.get() + tree.first_p(b);
      buffers.load_parent(b, flags, base, a);
      if constexpr (K::rigid) {
        put(a, workspace.inboard_accelerations[body]);
        buffers.store_for_children(b, flags, a);
        continue;
      }
      if constexpr (requires { typename K::Steps; }) {
        dispatch_link<K::Steps::has_armature>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template rate_outboard<shape()>(link, joint.c[0], joint.s[0], record, workspace.motions[body].velocity,
                                                    workspace.v[tree.first_p(b)], udot[0], a,
                                                    workspace.inboard_accelerations[body]);
        });
      } else {
        if (K::rotates_about_z && (flags & node::aligned) != 0)
          K::template cached_transform<true, T>(link, joint, record).outboard(a);
        else
          K::template cached_transform<false, T>(link, joint, record).outboard(a);
        a = a + workspace.inboard_accelerations[body];  // a′ = X Ω̇_parent + bias
        put(a, workspace.inboard_accelerations[body]);
        K::joint_acceleration(record, a, udot);                     // (47)
        a = K::template spatial_velocity<T>(link, joint, a, udot);  // (39)
      }
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }
};

template <class T>
void evaluate_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept {
  const RateSweep<T> sweep{tree, q, workspace};
  const auto kernel_runs = tree.kernel_runs();
  for (std::size_t i = kernel_runs.size(); i-- > 0;) {
    const KernelRun& s = kernel_runs[i];
    dispatch_kernels(s.kind, s.variant, [&](auto tag) { sweep.template inboard<typename decltype(tag)::type>(s); });
  }
  const Vec3& g = tree.gravity();
  const Motion<T> base{{T(-g.x), T(-g.y), T(-g.z)}, {}};
  for (const KernelRun& s : kernel_runs)
    dispatch_kernels(s.kind, s.variant, [&](auto tag) { sweep.template outboard<typename decltype(tag)::type>(s, base); });
}

}  // namespace momentree
