#pragma once
// Whole steps of both passes for kinds of joint, derived from the functions of the kind by tools/derive: the files in derived/.
// They serve the stages of integrators; everything else uses the generic functions.
#include <type_traits>

#include <momentree/joint/kernels.hpp>

namespace momentree {

/// The place of a body in its mechanism, by what its steps can omit: the children of a leaf, the parent of a root.
enum class Place : unsigned char { inner, leaf, root, single };

/// The steps of kernels K for a link with such a rotation and a body in such a place; specialised in derived/.
template <class K, LinkRotation Rotation, Place At>
struct DerivedSteps;

/// The rotations for which kernels have derived steps, as bits 1 << LinkRotation; a link's own rotation may be a special case of
/// one of them. The steps require a joint as declared, without armature.
template <class K>
inline constexpr unsigned derived_rotations = 0;
template <class K>
inline constexpr bool has_derived_steps = derived_rotations<K> != 0;

/// Calls f(std::type_identity<DerivedSteps<…>>{}) with the steps for a link and a place.
template <class K, class F>
MOMENTREE_INLINE void with_derived_steps(LinkRotation rotation, Place place, F&& f) {
  const auto with = [&](auto r) MOMENTREE_INLINE_LAMBDA {
    if (place == Place::inner)
      f(std::type_identity<DerivedSteps<K, r(), Place::inner>>{});
    else
      f(std::type_identity<DerivedSteps<K, r(), Place::leaf>>{});
  };
  constexpr auto has = [](LinkRotation r) { return (derived_rotations<K> >> static_cast<unsigned>(r) & 1u) != 0; };
  constexpr std::integral_constant<LinkRotation, LinkRotation::any> any{};
  constexpr std::integral_constant<LinkRotation, LinkRotation::tilted> tilted{};
  constexpr std::integral_constant<LinkRotation, LinkRotation::about_z> about_z{};
  constexpr std::integral_constant<LinkRotation, LinkRotation::none> none{};
  if (place == Place::root) return f(std::type_identity<DerivedSteps<K, any(), Place::root>>{});
  if (place == Place::single) return f(std::type_identity<DerivedSteps<K, any(), Place::single>>{});
  if constexpr (has(none()))
    if (rotation == none()) return with(none);
  if constexpr (has(about_z()))
    if (rotation >= about_z()) return with(about_z);
  if constexpr (has(tilted()))
    if (rotation >= tilted()) return with(tilted);
  with(any);
}

/// Numbers that an inward step stores for the outward step, in the memory of the kind's own record.
template <class T, int N>
struct DerivedRecord {
  Vector3<T> mc;  ///< first moment of the subtree (kg m)
  T x[N];
};

/// A number of a contribution to the parent: the first one, or added to those before.
template <bool Add, class T>
MOMENTREE_INLINE void contribute(T& sum, const T& x) {
  if constexpr (Add)
    sum = sum + x;
  else
    sum = x;
}

}  // namespace momentree
