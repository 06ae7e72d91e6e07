#pragma once
// From a kind known at run time to its type: one switch, made from the list of files in kinds/.
#include <type_traits>

#include <momentree/joint/kinds.hpp>  // generated: includes every file of kinds/

namespace momentree {

/// Calls f(std::type_identity<Revolute>{}) for Kind::revolute, and so on.
template <class F>
MOMENTREE_INLINE decltype(auto) dispatch(Kind kind, F&& f) {
  switch (kind) {
#define MOMENTREE_KIND(name, Type) \
  case Kind::name: return f(std::type_identity<Type>{});
    MOMENTREE_KINDS(MOMENTREE_KIND)
#undef MOMENTREE_KIND
  }
  __builtin_unreachable();
}

namespace detail {
template <class K>
struct ArmatureKernelsOf {
  using type = typename K::Kernels;
};
template <class K>
requires requires { typename K::ArmatureKernels; }
struct ArmatureKernelsOf<K> {
  using type = typename K::ArmatureKernels;
};
}  // namespace detail

/// The kernels of a kind: with a rotor on the joint, reduction leaves fewer zeros and the structured kernels do not hold.
template <class K, bool Armature>
using KernelsOf = std::conditional_t<Armature, typename detail::ArmatureKernelsOf<K>::type, typename K::Kernels>;

/// Calls f(std::type_identity<Kernels>{}) for a joint's kind with or without armature.
template <class F>
MOMENTREE_INLINE decltype(auto) dispatch_kernels(Kind kind, bool armature, F&& f) {
  return dispatch(kind, [&](auto tag) -> decltype(auto) {
    using K = typename decltype(tag)::type;
    if (armature) return f(std::type_identity<KernelsOf<K, true>>{});
    return f(std::type_identity<KernelsOf<K, false>>{});
  });
}

}  // namespace momentree
