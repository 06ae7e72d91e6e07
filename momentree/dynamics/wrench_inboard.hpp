#pragma once
#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// Calls f(g), where g takes a wrench on a body to its parent's frame (45), in place. `flags`: of the node.
template <class K, class T, class F>
MOMENTREE_INLINE void wrenches_inboard(const LinkConstants& link, const JointState<T>& joint, const auto& record, unsigned flags,
                                       const F& f) {
  const auto over = [&](const auto& transform)
                        MOMENTREE_INLINE_LAMBDA { f([&](Force<T>& W) MOMENTREE_INLINE_LAMBDA { transform.inboard(W); }); };
  if (K::rotates_about_z && (flags & node::aligned) != 0)
    over(K::template cached_transform<true, T>(link, joint, record));
  else
    over(K::template cached_transform<false, T>(link, joint, record));
}

/// The same for one wrench.
template <class K, class T>
MOMENTREE_INLINE void wrench_inboard(const LinkConstants& link, const JointState<T>& joint, const auto& record, unsigned flags,
                                     Force<T>& W) {
  wrenches_inboard<K, T>(link, joint, record, flags, [&](const auto& inboard) MOMENTREE_INLINE_LAMBDA { inboard(W); });
}

}  // namespace momentree
