#pragma once
// What the passes over kinds with derived steps need to know of a body's place in its mechanism.
#include <momentree/joint/derived_steps.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::detail {

MOMENTREE_INLINE BodyPlace place_of(unsigned flags) {
  const bool root = (flags & node::grounded) != 0;
  return (flags & node::leaf) != 0 ? root ? BodyPlace::single : BodyPlace::leaf : root ? BodyPlace::root : BodyPlace::inner;
}
/// Where the contribution of a body goes: that of a last child starts the sum of its parent in memory, a leaf between it and the
/// first child adds to this sum directly, and other bodies in between by way of the accumulator.
struct Destinations {
  bool parent_sum, adds, sibling;
  MOMENTREE_INLINE explicit Destinations(unsigned flags) {
    const unsigned kind = flags & (node::first_child | node::grounded | node::last_child);
    const bool last = kind == node::last_child, middle = kind == 0, leaf = (flags & node::leaf) != 0;
    adds = middle && leaf, sibling = middle && !leaf, parent_sum = last || adds;
  }
};
/// The record of derived steps, in the memory of the kind's own.
template <class T, class Steps, class Own>
MOMENTREE_INLINE auto& derived_record(Own& own) {
  using Record = typename Steps::template Record<T>;
  static_assert(sizeof(Record) <= sizeof(Own) && alignof(Record) <= alignof(T) && std::is_trivially_copyable_v<Record>);
  return reinterpret_cast<Record&>(own);
}

}  // namespace momentree::detail
