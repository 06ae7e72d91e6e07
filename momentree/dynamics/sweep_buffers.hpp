#pragma once
#include <momentree/base/inline.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// How sums go from body to body along the order; `In`, `Out` are what is summed up on the way in and handed down on the way out.
template <class In, class Out>
struct SweepBuffers {
  UncheckedTree tree;
  In* child_sums;
  Out* parent_states;

  // Between stretches of the order what is at hand waits in memory.

  /// Behind a stretch, on the way in: for the parent of its first body, if that is a first child …
  MOMENTREE_INLINE void suspend_inward(const KernelRun& run, const In& sum) const {
    if ((flags_at(run.begin) & node::first_child) != 0) child_sums[body_at(run.begin)] = sum;
  }
  /// … and before the next one, whose last body is that parent.
  MOMENTREE_INLINE void resume_inward(const KernelRun& run, In& sum) const {
    if ((flags_at(run.end - 1) & node::leaf) == 0) sum = child_sums[body_at(run.end)];
  }
  /// The same on the way out.
  MOMENTREE_INLINE void suspend_outward(const KernelRun& run, const Out& value) const {
    if ((flags_at(run.end - 1) & node::leaf) == 0) parent_states[body_at(run.end - 1)] = value;
  }
  MOMENTREE_INLINE void resume_outward(const KernelRun& run, Out& value) const {
    if ((flags_at(run.begin) & node::first_child) != 0) value = parent_states[body_at(run.begin - 1)];
  }

  /// Before a body, on the way in: what its children asked of it. `sum` is that of its first child; of no use for a tip.
  MOMENTREE_INLINE void gather_children(int b, unsigned flags, In& sum) const {
    if ((flags & node::branching) != 0) sum += child_sums[b];
  }
  /// Behind it: for its parent, who is next if this is the first child.
  MOMENTREE_INLINE void add_to_parent(int b, unsigned flags, const In& sum) const {
    if ((flags & (node::first_child | node::root)) != 0) return;
    In& inlet = child_sums[tree.parent(b)];
    if ((flags & node::last_child) != 0)
      inlet = sum;
    else
      inlet += sum;
  }
  /// The same for steps that collect for themselves and put what a last child asks where it belongs: behind the others.
  MOMENTREE_INLINE void add_sibling(int b, unsigned flags, const In& sum) const {
    if ((flags & (node::first_child | node::root | node::last_child)) == 0) child_sums[tree.parent(b)] += sum;
  }
  /// Before a body, on the way out: what its parent hands down, which is at hand if the parent came just before.
  MOMENTREE_INLINE void load_parent(int b, unsigned flags, const Out& base, Out& value) const {
    if ((flags & node::first_child) != 0) return;
    value = (flags & node::root) != 0 ? base : parent_states[tree.parent(b)];
  }
  /// Behind it: for children that do not come next.
  MOMENTREE_INLINE void store_for_children(int b, unsigned flags, const Out& value) const {
    if ((flags & node::branching) != 0) parent_states[b] = value;
  }

 private:
  MOMENTREE_INLINE int body_at(int place) const { return tree.order()[static_cast<std::size_t>(place)]; }
  MOMENTREE_INLINE unsigned flags_at(int place) const { return tree.node_flags()[static_cast<std::size_t>(place)]; }
};

}  // namespace momentree
