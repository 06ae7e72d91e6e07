#pragma once
#include <momentree/dynamics/revolute_dispatch.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// (45): a wrench on a body, to its parent's frame. `flags`: of the node.
template <class K, class T>
MOMENTREE_INLINE void wrench_inboard(const LinkConstants& link, const JointState<T>& joint, const auto& record, unsigned flags,
                                     Force<T>& W) {
  if constexpr (requires { typename K::Steps; })
    dispatch_link<K::Steps::has_armature>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
      K::Steps::template cross_inboard<shape()>(link, joint.c[0], joint.s[0], W);
    });
  else if (K::rotates_about_z && (flags & node::aligned) != 0)
    K::template cached_transform<true, T>(link, joint, record).inboard(W);
  else
    K::template cached_transform<false, T>(link, joint, record).inboard(W);
}

}  // namespace momentree
