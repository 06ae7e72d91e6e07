#pragma once
// Whole steps of the passes for kinds of joint, derived from the functions of the kind by tools/derive: the files in derived/ for
// momenta and in derived_velocity/ for velocities. They serve the stages of integrators; everything else uses the generic
// functions.
#include <type_traits>

#include <momentree/joint/kernels.hpp>
#include <momentree/joint/placement_shapes.hpp>

namespace momentree {

/// The place of a body in its mechanism, by what its steps can omit: the children of a leaf, the parent of a root.
enum class BodyPlace : unsigned char { inner, leaf, root, single };

/// The steps of kernels K for a link with such a LinkRotation or PlacementShape and a body in such a place; specialised in
/// derived/.
template <class K, auto Form, BodyPlace At>
struct DerivedSteps;
/// The same in velocities; specialised in derived_velocity/.
template <class K, auto Form, BodyPlace At>
struct DerivedVelocitySteps;

/// What kernels have steps for, as bits 1 << LinkRotation or 1 << PlacementShape; a link's own may be a special case of one of
/// them. The steps require a joint as declared.
struct DerivedForms {
  unsigned rotations = 0, shapes = 0;
  constexpr bool any() const { return rotations != 0 || shapes != 0; }
};
template <class K>
inline constexpr DerivedForms momentum_forms{};
template <class K>
inline constexpr DerivedForms velocity_forms{};

namespace detail {
/// The most special of these shapes of which `shape` is a case.
constexpr PlacementShape covering(unsigned shapes, PlacementShape shape) {
  using enum PlacementShape;
  while ((shapes >> static_cast<unsigned>(shape) & 1u) == 0) {
    if (shape == tilted)
      shape = general;
    else if (shape == right_a || shape == right_d || shape == right_meeting)
      shape = right;
    else
      shape = shape == parallel_a ? parallel : screw;
  }
  return shape;
}
}  // namespace detail

/// Calls f(std::type_identity<Steps<K, …>>{}) with the steps for a link and a place.
template <template <class, auto, BodyPlace> class Steps, class K, DerivedForms Forms, class F>
MOMENTREE_INLINE void with_derived_steps(const LinkConstants& link, BodyPlace place, F&& f) {
  const auto with = [&](auto form) MOMENTREE_INLINE_LAMBDA {
    if (place == BodyPlace::inner)
      f(std::type_identity<Steps<K, form(), BodyPlace::inner>>{});
    else
      f(std::type_identity<Steps<K, form(), BodyPlace::leaf>>{});
  };
  constexpr auto most_general = [] {
    if constexpr (Forms.shapes != 0)
      return PlacementShape::general;
    else
      return LinkRotation::any;
  }();
  if (place == BodyPlace::root) return f(std::type_identity<Steps<K, most_general, BodyPlace::root>>{});
  if (place == BodyPlace::single) return f(std::type_identity<Steps<K, most_general, BodyPlace::single>>{});
  if constexpr (Forms.shapes != 0) {
    dispatch_shape(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
      with(std::integral_constant<PlacementShape, detail::covering(Forms.shapes, shape())>{});
    });
  } else {
    constexpr auto has = [](LinkRotation r) { return (Forms.rotations >> static_cast<unsigned>(r) & 1u) != 0; };
    constexpr std::integral_constant<LinkRotation, LinkRotation::any> any{};
    constexpr std::integral_constant<LinkRotation, LinkRotation::tilted> tilted{};
    constexpr std::integral_constant<LinkRotation, LinkRotation::about_z> about_z{};
    constexpr std::integral_constant<LinkRotation, LinkRotation::none> none{};
    if constexpr (has(none()))
      if (link.rotation == none()) return with(none);
    if constexpr (has(about_z()))
      if (link.rotation >= about_z()) return with(about_z);
    if constexpr (has(tilted()))
      if (link.rotation >= tilted()) return with(tilted);
    with(any);
  }
}

/// Numbers that an inward step stores for the outward step, in the memory of the kind's own record.
template <class T, int N>
struct DerivedRecord {
  Vector3<T> mc;  ///< first moment of the subtree (kg m)
  T x[N];
};
/// Numbers that a step in velocities stores for later passes, in the same memory.
template <class T, int N>
struct DerivedVelocityRecord {
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
