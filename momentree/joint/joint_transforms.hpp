#pragma once
// Transforms across a link in both directions: (16), (17).
#include <momentree/base/inline.hpp>
#include <momentree/joint/link_constants.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// Across the placement, after the child's joint: rotation about x by α, about z by β unless the frames are aligned, shift by r.
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_inboard(const auto& k, Force<T>& P) {
  rotate_x(P.l, k.cos_a, k.sin_a);
  rotate_x(P.h, k.cos_a, k.sin_a);
  if constexpr (!Aligned) {
    rotate_z(P.l, k.cos_b, k.sin_b);
    rotate_z(P.h, k.cos_b, k.sin_b);
  }
  shift(P, k.r);
}
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_inboard(const auto& k, Vector3<T>& mc, const auto& mass) {
  rotate_x(mc, k.cos_a, k.sin_a);
  if constexpr (!Aligned) rotate_z(mc, k.cos_b, k.sin_b);
  mc += Vector3<T>{T(mass * k.r.x), T(mass * k.r.y), T(mass * k.r.z)};
}
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_inboard(const auto& k, SpatialMass<T>& M) {
  rotate_x(M, k.cos_a, k.sin_a);
  if constexpr (!Aligned) rotate_z(M, k.cos_b, k.sin_b);
  shift(M, k.r);
}
/// The inverse for a direction: components in the parent's axes to components before the joint's own motion.
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_outboard(const auto& k, Vector3<T>& a) {
  if constexpr (!Aligned) rotate_z(a, k.cos_b, -k.sin_b);
  rotate_x(a, k.cos_a, -k.sin_a);
}
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_outboard(const auto& k, Motion<T>& a) {
  shift_outboard(a, k.r);
  placement_outboard<Aligned>(k, a.v);
  placement_outboard<Aligned>(k, a.w);
}

/// R ← Rz R and R ← Rx R.
template <class T, class C>
MOMENTREE_INLINE void rotate_z(Matrix3<T>& R, const C& c, const C& s) {
  rotate(R.xx, R.yx, c, s);
  rotate(R.xy, R.yy, c, s);
  rotate(R.xz, R.yz, c, s);
}
template <class T, class C>
MOMENTREE_INLINE void rotate_x(Matrix3<T>& R, const C& c, const C& s) {
  rotate(R.yx, R.zx, c, s);
  rotate(R.yy, R.zy, c, s);
  rotate(R.yz, R.zz, c, s);
}

/// Transform of a joint that rotates about z and translates along z (revolute, prismatic, helical, cylindrical): c, s of the
/// angle including θ0, d the displacement (m). (16), (17).
template <class T, bool Aligned, class Link = LinkConstants>
struct ScrewTransform {
  const Link& link;
  T c, s, d;

  MOMENTREE_INLINE void inboard(Force<T>& P) const {
    rotate_z(P.l, c, s);
    rotate_z(P.h, c, s);
    P.h.x = P.h.x - d * P.l.y;
    P.h.y = P.h.y + d * P.l.x;
    placement_inboard<Aligned>(link, P);
  }
  /// A first moment of a subtree with that mass.
  MOMENTREE_INLINE void inboard(Vector3<T>& mc, const auto& mass) const {
    rotate_z(mc, c, s);
    mc.z = mc.z + d * T(mass);
    placement_inboard<Aligned>(link, mc, mass);
  }
  MOMENTREE_INLINE void inboard(SpatialMass<T>& M) const {
    rotate_z(M, c, s);
    shift(M, Vector3<T>{T(0), T(0), d});
    placement_inboard<Aligned>(link, M);
  }
  /// A frame with the pose (R, r) in the child's frame: its pose in the parent's.
  MOMENTREE_INLINE void place(Matrix3<T>& R, Vector3<T>& r) const {
    rotate_z(R, c, s);
    rotate_z(r, c, s);
    r.z = r.z + d;
    rotate_x(R, link.cos_a, link.sin_a);
    rotate_x(r, link.cos_a, link.sin_a);
    if constexpr (!Aligned) {
      rotate_z(R, link.cos_b, link.sin_b);
      rotate_z(r, link.cos_b, link.sin_b);
    }
    r += Vector3<T>{T(link.r.x), T(link.r.y), T(link.r.z)};
  }
  MOMENTREE_INLINE void outboard(Vector3<T>& a) const {
    placement_outboard<Aligned>(link, a);
    rotate_z(a, c, -s);
  }
  MOMENTREE_INLINE void outboard(Motion<T>& a) const {
    placement_outboard<Aligned>(link, a);
    a.v.x = a.v.x + d * a.w.y;
    a.v.y = a.v.y - d * a.w.x;
    rotate_z(a.v, c, -s);
    rotate_z(a.w, c, -s);
  }
};

/// Transform of any joint from its pose: R child axes to parent axes, r the child's origin, both including the placement.
template <class T>
struct DenseTransform {
  Matrix3<T> R;
  Vector3<T> r;

  MOMENTREE_INLINE void inboard(Force<T>& P) const {
    P = {R * P.l, R * P.h};
    shift(P, r);
  }
  MOMENTREE_INLINE void inboard(Vector3<T>& mc, const auto& mass) const { mc = R * mc + T(mass) * r; }
  MOMENTREE_INLINE void inboard(SpatialMass<T>& M) const {
    rotate(M, R);
    shift(M, r);
  }
  MOMENTREE_INLINE void place(Matrix3<T>& axes, Vector3<T>& origin) const {
    axes = R * axes;
    origin = r + R * origin;
  }
  MOMENTREE_INLINE void outboard(Vector3<T>& a) const { a = transpose_times(R, a); }
  MOMENTREE_INLINE void outboard(Motion<T>& a) const {
    shift_outboard(a, r);
    a = {transpose_times(R, a.v), transpose_times(R, a.w)};
  }
};

}  // namespace momentree
