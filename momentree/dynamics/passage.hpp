#pragma once
#include <momentree/base/inline.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// How sums go from body to body along the order; `In`, `Out` are what is summed up on the way in and handed down on the way out.
template <class In, class Out>
struct Passage {
  UncheckedTree tree;
  In* inlets;
  Out* outlets;

  // Between stretches of the order what is at hand waits in memory.

  /// Behind a stretch, on the way in: for the parent of its first body, if that is a first child …
  MOMENTREE_INLINE void leave_in(const Segment& segment, const In& sum) const {
    if ((flow_at(segment.begin) & flow::first) != 0) inlets[body_at(segment.begin)] = sum;
  }
  /// … and before the next one, whose last body is that parent.
  MOMENTREE_INLINE void enter_in(const Segment& segment, In& sum) const {
    if ((flow_at(segment.end - 1) & flow::tip) == 0) sum = inlets[body_at(segment.end)];
  }
  /// The same on the way out.
  MOMENTREE_INLINE void leave_out(const Segment& segment, const Out& value) const {
    if ((flow_at(segment.end - 1) & flow::tip) == 0) outlets[body_at(segment.end - 1)] = value;
  }
  MOMENTREE_INLINE void enter_out(const Segment& segment, Out& value) const {
    if ((flow_at(segment.begin) & flow::first) != 0) value = outlets[body_at(segment.begin - 1)];
  }

  /// Before a body, on the way in: what its children asked of it. `sum` is that of its first child; of no use for a tip.
  MOMENTREE_INLINE void collect(int b, unsigned flow, In& sum) const {
    if ((flow & flow::fork) != 0) sum += inlets[b];
  }
  /// Behind it: for its parent, who is next if this is the first child.
  MOMENTREE_INLINE void deliver(int b, unsigned flow, const In& sum) const {
    if ((flow & (flow::first | flow::root)) != 0) return;
    In& inlet = inlets[tree.parent(b)];
    if ((flow & flow::last) != 0)
      inlet = sum;
    else
      inlet += sum;
  }
  /// The same for steps that collect for themselves and put what a last child asks where it belongs: behind the others.
  MOMENTREE_INLINE void add(int b, unsigned flow, const In& sum) const {
    if ((flow & (flow::first | flow::root | flow::last)) == 0) inlets[tree.parent(b)] += sum;
  }
  /// Before a body, on the way out: what its parent hands down, which is at hand if the parent came just before.
  MOMENTREE_INLINE void receive(int b, unsigned flow, const Out& base, Out& value) const {
    if ((flow & flow::first) != 0) return;
    value = (flow & flow::root) != 0 ? base : outlets[tree.parent(b)];
  }
  /// Behind it: for children that do not come next.
  MOMENTREE_INLINE void hand_down(int b, unsigned flow, const Out& value) const {
    if ((flow & flow::fork) != 0) outlets[b] = value;
  }

 private:
  MOMENTREE_INLINE int body_at(int place) const { return tree.order()[static_cast<std::size_t>(place)]; }
  MOMENTREE_INLINE unsigned flow_at(int place) const { return tree.flows()[static_cast<std::size_t>(place)]; }
};

}  // namespace momentree
