#pragma once
#include <momentree/base/inline.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// How sums go from body to body along the order; `In`, `Out` are what is summed up on the way in and handed down on the way out.
template <class In, class Out>
struct Passage {
  const Tree& tree;
  In* inlets;
  Out* outlets;

  /// Whether the last body of a stretch of the order has a first child, which then comes behind it …
  MOMENTREE_INLINE bool comes_in(const Segment& segment) const {
    return (tree.flows()[static_cast<std::size_t>(segment.end - 1)] & flow::tip) == 0;
  }
  /// … and whether its first body is one.
  MOMENTREE_INLINE bool goes_on(const Segment& segment) const {
    return (tree.flows()[static_cast<std::size_t>(segment.begin)] & flow::first) != 0;
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
};

}  // namespace momentree
