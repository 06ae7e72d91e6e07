#pragma once
#include <momentree/base/inline.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// Transfer of sums between bodies along the order: `In` are the sums of the inward pass, `Out` the values that the outward pass
/// hands to children. Without `Moments`, the first moments of sums are neither stored nor added.
template <class In, class Out, bool Moments = true>
struct SweepBuffers {
  UncheckedTree tree;
  In* child_sums;
  Out* parent_states;

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
  /// The same for steps that collect for themselves and write a last child's contribution directly: only middle children are
  /// left.
  MOMENTREE_INLINE void add_sibling(int b, unsigned flags, const In& sum) const {
    if ((flags & (node::first_child | node::root | node::last_child)) != 0) return;
    if constexpr (Moments)
      child_sums[tree.parent(b)] += sum;
    else
      add_without_moments(sum, child_sums[tree.parent(b)]);
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

 private:
  MOMENTREE_INLINE int body_at(int place) const { return tree.order()[static_cast<std::size_t>(place)]; }
  MOMENTREE_INLINE unsigned flags_at(int place) const { return tree.node_flags()[static_cast<std::size_t>(place)]; }
};

}  // namespace momentree
