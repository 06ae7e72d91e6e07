#pragma once
// Passes over the bodies of a tree in its order.
#include <algorithm>
#include <limits>
#include <span>

#include <momentree/base/inline.hpp>
#include <momentree/dynamics/body_passes.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// Transfer of sums between bodies along the order: `In` are the sums of the inward pass, `Out` the values that the outward pass
/// hands to children. The first child of a body follows it directly, so that sums pass through memory only for later children.
/// Without `Moments`, the first moments of sums are neither stored nor added.
template <class In, class Out, bool Moments = true>
struct SweepBuffers {
  UncheckedTree tree;
  In* child_sums;
  Out* parent_states;

  /// Calls step(place in the order, b, flags, a) for the bodies of a kernel run, inward. In: the sum of its children's
  /// contributions. Out: its own.
  template <class F>
  MOMENTREE_INLINE void inward(const KernelRun& run, F&& step) const {
    In a;
    resume_inward(run, a);
    for (int i = run.end - 1; i >= run.begin; --i) {
      const int b = body_at(i);
      const unsigned flags = flags_at(i);
      if ((flags & node::leaf) != 0) a = {};
      gather_children(b, flags, a);
      step(i, b, flags, a);
      add_to_parent(b, flags, a);
    }
    suspend_inward(run, a);
  }
  /// The same, outward. In: what its parent hands on, or `base` for roots. Out: what it hands on itself.
  template <class F>
  MOMENTREE_INLINE void outward(const KernelRun& run, const Out& base, F&& step) const {
    Out a;
    resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = body_at(i);
      const unsigned flags = flags_at(i);
      load_parent(b, flags, base, a);
      step(i, b, flags, a);
      store_for_children(b, flags, a);
    }
    suspend_outward(run, a);
  }

 private:
  // Between kernel runs the accumulator is stored in memory.

  /// Inward, after a kernel run: stores the sum for the parent of its first body, if that body is a first child …
  MOMENTREE_INLINE void suspend_inward(const KernelRun& run, const In& sum) const {
    if ((flags_at(run.begin) & node::first_child) == 0) return;
    if constexpr (Moments)
      put(sum, child_sums[body_at(run.begin)]);
    else
      put_without_moments(sum, child_sums[body_at(run.begin)]);
  }
  /// … and loads it before the next run, whose last body is that parent.
  MOMENTREE_INLINE void resume_inward(const KernelRun& run, In& sum) const {
    if ((flags_at(run.end - 1) & node::leaf) != 0) return;
    if constexpr (Moments)
      put(child_sums[body_at(run.end)], sum);
    else
      put_without_moments(child_sums[body_at(run.end)], sum);
  }
  /// The same for the outward pass.
  MOMENTREE_INLINE void suspend_outward(const KernelRun& run, const Out& value) const {
    if ((flags_at(run.end - 1) & node::leaf) == 0) put(value, parent_states[body_at(run.end - 1)]);
  }
  MOMENTREE_INLINE void resume_outward(const KernelRun& run, Out& value) const {
    if ((flags_at(run.begin) & node::first_child) != 0) put(parent_states[body_at(run.begin - 1)], value);
  }

  /// Inward, before a body: adds its other children to `sum`, which holds its first child's contribution (undefined for a leaf).
  MOMENTREE_INLINE void gather_children(int b, unsigned flags, In& sum) const {
    if ((flags & node::branching) == 0) return;
    if constexpr (Moments)
      sum += child_sums[b];
    else
      add_without_moments(child_sums[b], sum);
  }
  /// Inward, after a body: adds its contribution to its parent, unless it is a first child, whose parent comes next.
  MOMENTREE_INLINE void add_to_parent(int b, unsigned flags, const In& sum) const {
    if ((flags & (node::first_child | node::root)) != 0) return;
    In& parent_sum = child_sums[tree.parent(b)];
    if constexpr (Moments) {
      if ((flags & node::last_child) != 0)
        put(sum, parent_sum);
      else
        parent_sum += sum;
    } else {
      if ((flags & node::last_child) != 0)
        put_without_moments(sum, parent_sum);
      else
        add_without_moments(sum, parent_sum);
    }
  }
  /// Outward, before a body: loads its parent's output, unless the parent came directly before.
  MOMENTREE_INLINE void load_parent(int b, unsigned flags, const Out& base, Out& value) const {
    if ((flags & node::first_child) != 0) return;
    put((flags & node::root) != 0 ? base : parent_states[tree.parent(b)], value);
  }
  /// Outward, after a body: stores its output for children that do not come next.
  MOMENTREE_INLINE void store_for_children(int b, unsigned flags, const Out& value) const {
    if ((flags & node::branching) != 0) put(value, parent_states[b]);
  }

  MOMENTREE_INLINE int body_at(int place) const { return tree.order()[static_cast<std::size_t>(place)]; }
  MOMENTREE_INLINE unsigned flags_at(int place) const { return tree.node_flags()[static_cast<std::size_t>(place)]; }
};

/// Passes over all bodies of a tree, for one scalar. Kernel runs, consecutive bodies with the same kernels, are one loop.
template <class T>
struct Sweep {
  UncheckedTree tree;
  const T* q;
  Workspace<T>& workspace;
  T* a;  ///< packed as p: see PassBody
  const T* p = nullptr;
  const Force<T>* loads = tree.loaded_bodies().empty() ? nullptr : workspace.loads.get();

  int first = 0, last = std::numeric_limits<int>::max();  ///< places in the order: only these bodies

  template <class K>
  MOMENTREE_INLINE PassBody<K, T> body(int b, unsigned flags) const {
    const auto i = static_cast<std::size_t>(b);
    const int at = tree.first_p(b), first_q = tree.first_q(b), angle = tree.first_angle(b);
    return {.link = tree.link(b),
            .joint = {q + first_q, workspace.cos.get() + angle, workspace.sin.get() + angle},
            .flags = flags,
            .record = workspace.template record<K>(tree, b),
            .u = workspace.v.get() + at,
            .qdot = workspace.qdot.get() + first_q,
            .a = a + at,
            .p = p + at,
            .pdot = workspace.pdot.get() + at,
            .motion = &workspace.motions[i],
            .bias = &workspace.biases[i],
            .inboard_acceleration = &workspace.inboard_accelerations[i],
            .reduced_bias_wrench = &workspace.reduced_bias_wrenches[i],
            .load = loads == nullptr ? nullptr : loads + i};
  }
  /// Calls pass(body, b, value) for the bodies of some kernel runs, inward or outward: see SweepBuffers.
  template <class In, class Out, bool Moments, class F>
  MOMENTREE_INLINE void inward(std::span<const KernelRun> runs, const SweepBuffers<In, Out, Moments>& buffers, F&& pass) const {
    for (std::size_t i = runs.size(); i-- > 0;)
      dispatch_kernels(runs[i].kind, runs[i].variant, [&](auto tag) {
        using K = typename decltype(tag)::type;
        buffers.inward(own(runs[i]), [&](int, int b, unsigned flags, In& value)
                                    MOMENTREE_INLINE_LAMBDA { pass(body<K>(b, flags), b, value); });
      });
  }
  template <class In, class Out, bool Moments, class F>
  MOMENTREE_INLINE void outward(std::span<const KernelRun> runs, const SweepBuffers<In, Out, Moments>& buffers, const Out& base,
                                F&& pass) const {
    for (const KernelRun& run : runs)
      dispatch_kernels(run.kind, run.variant, [&](auto tag) {
        using K = typename decltype(tag)::type;
        buffers.outward(own(run), base, [&](int, int b, unsigned flags, Out& value)
                                       MOMENTREE_INLINE_LAMBDA { pass(body<K>(b, flags), b, value); });
      });
  }

 private:
  MOMENTREE_INLINE KernelRun own(KernelRun run) const {
    run.begin = std::max(run.begin, first), run.end = std::min(run.end, last);
    return run;
  }
};

}  // namespace momentree
