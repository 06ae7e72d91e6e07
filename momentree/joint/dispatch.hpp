#pragma once
// Maps a kind known at run time to its type, by one switch generated from the list of files in kinds/.
#include <type_traits>

#include <momentree/joint/kinds.hpp>  // generated: includes every file of kinds/
#include <momentree/joint/variants.hpp>

namespace momentree {

/// Calls f(std::type_identity<Revolute>{}) for Kind::revolute, and so on; returns its result.
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
struct GenericKernelsOf {
  using type = typename K::Kernels;
};
template <class K>
requires requires { typename K::Generic; }
struct GenericKernelsOf<K> {
  using type = typename K::Generic;
};
}  // namespace detail

/// The kernels of a kind in a variant. An armature leaves fewer zeros in the reduced mass; locks leave none that are known in
/// advance, so these variants use the generic functions if the kind's specialised ones do not apply. Kinds that rotate about z
/// need no reversed variant.
template <class K, Variant V>
struct KernelsFor {
  using Generic = typename detail::GenericKernelsOf<K>::type;
  using Reversed = std::conditional_t<Generic::rotates_about_z, Generic, ReversedKernels<Generic, K::info.nq, K::info.nv>>;
  using type = std::conditional_t<
      V == Variant::plain, typename K::Kernels,
      std::conditional_t<
          V == Variant::armature, Generic,
          std::conditional_t<V == Variant::locked, LockedKernels<Generic, K::info.nv>,
                             std::conditional_t<V == Variant::reversed, Reversed, LockedKernels<Reversed, K::info.nv>>>>>;
};
template <class K, Variant V>
using KernelsOf = typename KernelsFor<K, V>::type;

/// Calls f(std::type_identity<Kernels>{}) for the kernels of a joint's kind in a variant; returns its result.
template <class F>
MOMENTREE_INLINE decltype(auto) dispatch_kernels(Kind kind, Variant variant, F&& f) {
  return dispatch(kind, [&](auto tag) -> decltype(auto) {
    using K = typename decltype(tag)::type;
    using Generic = typename KernelsFor<K, Variant::plain>::Generic;
    if constexpr (!std::is_same_v<KernelsOf<K, Variant::armature>, typename K::Kernels>) {
      if (variant == Variant::armature) return f(std::type_identity<KernelsOf<K, Variant::armature>>{});
    }
    if constexpr (K::info.nv > 0) {
      if (variant == Variant::locked) return f(std::type_identity<KernelsOf<K, Variant::locked>>{});
      if constexpr (!Generic::rotates_about_z) {
        if (variant == Variant::reversed) return f(std::type_identity<KernelsOf<K, Variant::reversed>>{});
        if (variant == Variant::reversed_locked) return f(std::type_identity<KernelsOf<K, Variant::reversed_locked>>{});
      }
    }
    return f(std::type_identity<typename K::Kernels>{});
  });
}

/// Properties of a kind that relinking needs, in a table instead of a switch.
struct KindShape {
  int nq = 0, nv = 0, angles = 0;
  int angle[2] = {0, 0};
  bool rotates_about_z = false;
  std::size_t record[5] = {};  ///< size of the record in scalars, by variant
};
const KindShape& shape(Kind kind);

}  // namespace momentree
