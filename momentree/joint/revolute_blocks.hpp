#pragma once
// Transform of a reduced mass across a revolute joint (16), block by block in the order of a step: the blocks in the plane of the
// rotation about z (upper left of A, B and J), their coupling with z (two entries of A, two of B), A.zz; then the rotation about
// x and the shift along it. This keeps few values live at a time, and each is written once.
#include <type_traits>
#include <utility>

#include <momentree/joint/link_constants.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/joint/placement_shapes.hpp>

namespace momentree::detail {

/// Type of a link's constants: double, or a pack if its lanes are bodies.
template <class L>
using ConstantOf = std::remove_cvref_t<decltype(std::declval<const L&>().d)>;

/// Mb E, or G = Mb E / Mj: the third column of the right half, without the entry that is Mj.
template <class T>
struct RevoluteColumn {
  T lx, ly, lz, hx, hy;
};
template <class T>
struct PlaneSymmetric {
  T xx, xy, yy;
};
template <class T>
struct PlaneMatrix {
  T xx, xy, yx, yy;
};
template <class T>
struct PlaneVector {
  T x, y;
};
/// M̂ with M̂ E = 0, grouped by the blocks that a rotation about z mixes.
template <class T>
struct ReducedMass {
  PlaneSymmetric<T> A;
  PlaneMatrix<T> B;
  PlaneSymmetric<T> J;
  PlaneVector<T> Az;  ///< A.xz, A.yz
  PlaneVector<T> Bz;  ///< B.zx, B.zy
  T Azz;
};

// (16), the rotation about z by (c, s) and the shift along it by d: B ← B − A r̃, J ← J + r̃ B_new + (r̃ B_old)ᵀ with r = d e_z.

template <bool Shifts, class T, class C>
MOMENTREE_INLINE void cross_z(RevoluteColumn<T>& e, const T& c, const T& s, const C& d) {
  rotate(e.lx, e.ly, c, s);
  rotate(e.hx, e.hy, c, s);
  if constexpr (Shifts) e.hx = e.hx - d * e.ly, e.hy = e.hy + d * e.lx;
}
template <bool Shifts, class T, class C>
MOMENTREE_INLINE void cross_z(Force<T>& D, const T& c, const T& s, const C& d) {
  rotate_z(D.l, c, s);
  rotate_z(D.h, c, s);
  if constexpr (Shifts) D.h.x = D.h.x - d * D.l.y, D.h.y = D.h.y + d * D.l.x;
}
/// B with A before the shift; returns B before the shift.
template <bool Shifts, class T, class C>
MOMENTREE_INLINE PlaneMatrix<T> cross_z(PlaneMatrix<T>& B, const PlaneSymmetric<T>& A, const PlaneRotation<T>& by, const C& d) {
  if constexpr (!Shifts) {
    rotate_block(B.xx, B.xy, B.yx, B.yy, by);
    return {};
  } else {
    const T p = B.xx - B.yy, q = B.xy + B.yx;
    const T t = by.ss * p + by.cs * q, o = by.cs * p - by.ss * q;
    const PlaneMatrix<T> turned{T(0), B.xy + o, B.yx + o, B.yy + t};
    const T slid = t + d * A.xy;
    B.xx = B.xx - slid, B.yy = B.yy + slid;
    B.xy = turned.xy + d * A.xx, B.yx = turned.yx - d * A.yy;
    return turned;
  }
}
template <bool Shifts, class T, class C>
MOMENTREE_INLINE void cross_z(PlaneSymmetric<T>& J, const PlaneMatrix<T>& B, const PlaneMatrix<T>& turned,
                              const PlaneRotation<T>& by, const C& d) {
  rotate_block(J.xx, J.xy, J.yy, by);
  if constexpr (Shifts) {
    J.xx = J.xx - d * (B.yx + turned.yx), J.yy = J.yy + d * (B.xy + turned.xy);
    J.xy = J.xy + d * (B.xx - turned.yy);
  }
}

// (16), the rotation about x by α and the shift by a along x, of a reduced mass.

/// Rotation of A about x, by the twist of the shape.
enum class Twist { any, right, none };
template <Twist W, class L, class T>
MOMENTREE_INLINE Symmetric3<T> rotate_x(const L& k, const PlaneSymmetric<T>& A, const PlaneVector<T>& Az, const T& Azz) {
  Symmetric3<T> R{A.xx, A.yy, Azz, A.xy, Az.x, Az.y};
  if constexpr (W == Twist::right) {
    R = {A.xx, Azz, A.yy, -Az.x, A.xy, -Az.y};
  } else if constexpr (W == Twist::any) {
    rotate_block(R.yy, R.yz, R.zz, PlaneRotation<ConstantOf<L>>::of_products(k.cs_a, k.ss_a));
    rotate(R.xy, R.xz, k.cos_a, k.sin_a);
  }
  return R;
}
template <Twist W, class L, class T>
MOMENTREE_INLINE Matrix3<T> rotate_x(const L& k, const PlaneMatrix<T>& B, const PlaneVector<T>& Bz) {
  const ConstantOf<L> c = k.cos_a, s = k.sin_a;
  if constexpr (W == Twist::none) return {B.xx, B.xy, T(0), B.yx, B.yy, T(0), Bz.x, Bz.y, T(0)};
  if constexpr (W == Twist::right) return {B.xx, T(0), B.xy, -Bz.x, T(0), -Bz.y, B.yx, T(0), B.yy};
  const T a = c * B.yy - s * Bz.y, b = s * B.yy + c * Bz.y;  // rows y, z of the y column
  return {B.xx, c * B.xy, s * B.xy, c * B.yx - s * Bz.x, c * a, s * a, s * B.yx + c * Bz.x, c * b, s * b};
}
/// The same for a B without zeros.
template <Twist W, class L, class T>
MOMENTREE_INLINE Matrix3<T> rotate_x(const L& k, const PlaneMatrix<T>& B, const PlaneVector<T>& Bz, const Vector3<T>& z) {
  if constexpr (W == Twist::right) return {B.xx, -z.x, B.xy, -Bz.x, z.z, -Bz.y, B.yx, -z.y, B.yy};
  Matrix3<T> R{B.xx, B.xy, z.x, B.yx, B.yy, z.y, Bz.x, Bz.y, z.z};
  if constexpr (W == Twist::any) {
    rotate_block(R.yy, R.yz, R.zy, R.zz, PlaneRotation<ConstantOf<L>>::of_products(k.cs_a, k.ss_a));
    rotate(R.xy, R.xz, k.cos_a, k.sin_a);
    rotate(R.yx, R.zx, k.cos_a, k.sin_a);
  }
  return R;
}
template <Twist W, class L, class T>
MOMENTREE_INLINE Symmetric3<T> rotate_x(const L& k, const PlaneSymmetric<T>& J) {
  if constexpr (W == Twist::none) return {J.xx, J.yy, T(0), J.xy, T(0), T(0)};
  if constexpr (W == Twist::right) return {J.xx, T(0), J.yy, T(0), J.xy, T(0)};
  return {J.xx, (1 - k.ss_a) * J.yy, k.ss_a * J.yy, k.cos_a * J.xy, k.sin_a * J.xy, k.cs_a * J.yy};
}

/// (16), the shift by a along x; M.A is already rotated.
template <Twist W, class T, class C>
MOMENTREE_INLINE void shift_x(SpatialMass<T>& M, const C& a) {
  const Symmetric3<T>& A = M.A;
  if constexpr (W == Twist::right) {  // the y column of B and the y row of J are zero
    M.B.xy = -(a * A.xz), M.B.yy = -(a * A.yz), M.B.zy = -(a * A.zz);
    const T yz = M.B.yz;
    M.B.xz = M.B.xz + a * A.xy, M.B.yz = M.B.yz + a * A.yy, M.B.zz = M.B.zz + a * A.yz;
    M.J.yy = -(a * M.B.zy), M.J.zz = M.J.zz + a * (yz + M.B.yz);
    M.J.xy = -(a * M.B.zx), M.J.xz = M.J.xz + a * M.B.yx, M.J.yz = -(a * M.B.zz);
  } else {
    const T zy = M.B.zy, yy = M.B.yy;
    M.B.xy = M.B.xy - a * A.xz, M.B.yy = M.B.yy - a * A.yz, M.B.zy = M.B.zy - a * A.zz;
    M.J.yy = M.J.yy - a * (zy + M.B.zy);
    M.J.xy = M.J.xy - a * M.B.zx;
    if constexpr (W == Twist::none) {  // those of z are zero
      M.B.xz = a * A.xy, M.B.yz = a * A.yy, M.B.zz = a * A.yz;
      M.J.zz = a * M.B.yz, M.J.xz = a * M.B.yx, M.J.yz = a * (yy - M.B.zz);
    } else {
      const T yz = M.B.yz;
      M.B.xz = M.B.xz + a * A.xy, M.B.yz = M.B.yz + a * A.yy, M.B.zz = M.B.zz + a * A.yz;
      M.J.zz = M.J.zz + a * (yz + M.B.yz);
      M.J.xz = M.J.xz + a * M.B.yx;
      M.J.yz = M.J.yz + a * (yy - M.B.zz);
    }
  }
}

// (17), from the parent's frame to the axes before the joint's own rotation.
template <PlacementShape S, class L, class T>
MOMENTREE_INLINE void rotate_placement(const L& k, Vector3<T>& x) {
  if constexpr (PlacementTerms<S>::beta) rotate_z(x, k.cos_b, -k.sin_b);
  if constexpr (PlacementTerms<S>::right)
    x = {x.x, x.z, -x.y};
  else if constexpr (!PlacementTerms<S>::parallel)
    rotate_x(x, k.cos_a, -k.sin_a);
}
template <PlacementShape S, class L, class T>
MOMENTREE_INLINE void cross_placement(const L& k, Motion<T>& a) {
  if constexpr (PlacementTerms<S>::any_offset) shift_outboard(a, k.r);
  if constexpr (PlacementTerms<S>::a) a.v.y = a.v.y + k.r.x * a.w.z, a.v.z = a.v.z - k.r.x * a.w.y;
  rotate_placement<S>(k, a.v), rotate_placement<S>(k, a.w);
}
// (17), the shift along z and the rotation about it.
template <PlacementShape S, class L, class T>
MOMENTREE_INLINE void cross_joint_outboard(const L& k, const T& c, const T& s, Motion<T>& a) {
  if constexpr (PlacementTerms<S>::d) a.v.x = a.v.x + k.d * a.w.y, a.v.y = a.v.y - k.d * a.w.x;
  rotate_z(a.v, c, -s);
  rotate_z(a.w, c, -s);
}

}  // namespace momentree::detail
