#pragma once
// Spatial algebra of the paper, linear part first, everything about the origin O of the current frame, in its axes. A link's
// placement is split into rotations about one axis at a time, because each costs half of a general rotation.
#include <momentree/base/inline.hpp>
#include <momentree/math/vec.hpp>

namespace momentree {

/// Spatial velocity Ω = (v; ω): v (m/s) of the body-fixed point at O, ω (rad/s).
template <class T>
struct Motion {
  Vector3<T> v, w;
};
/// Spatial momentum P = (l; h) or wrench T = (f; t), about O.
template <class T>
struct Force {
  Vector3<T> l, h;
};

/// Stores `value` number by number: a copy of the whole uses wider loads, which stall on numbers that were just written.
template <class T>
MOMENTREE_INLINE constexpr void put(const Motion<T>& value, Motion<T>& to) {
  to.v.x = value.v.x, to.v.y = value.v.y, to.v.z = value.v.z;
  to.w.x = value.w.x, to.w.y = value.w.y, to.w.z = value.w.z;
}
template <class T>
MOMENTREE_INLINE constexpr void put(const Force<T>& value, Force<T>& to) {
  to.l.x = value.l.x, to.l.y = value.l.y, to.l.z = value.l.z;
  to.h.x = value.h.x, to.h.y = value.h.y, to.h.z = value.h.z;
}

template <class T>
MOMENTREE_INLINE constexpr Motion<T> operator+(const Motion<T>& a, const Motion<T>& b) {
  return {a.v + b.v, a.w + b.w};
}
template <class T>
MOMENTREE_INLINE constexpr Force<T> operator+(const Force<T>& a, const Force<T>& b) {
  return {a.l + b.l, a.h + b.h};
}
template <class T>
MOMENTREE_INLINE constexpr Force<T> operator-(const Force<T>& a, const Force<T>& b) {
  return {a.l - b.l, a.h - b.h};
}
template <class T, class S>
MOMENTREE_INLINE constexpr Force<T> operator*(const S& s, const Force<T>& a) {
  return {s * a.l, s * a.h};
}
template <class T>
MOMENTREE_INLINE constexpr Force<T>& operator+=(Force<T>& a, const Force<T>& b) {
  return a = a + b;
}
template <class T>
MOMENTREE_INLINE constexpr T dot(const Motion<T>& a, const Force<T>& b) {
  return dot(a.v, b.l) + dot(a.w, b.h);
}

/// (9): Ω × P = (ω × l; v × l + ω × h), the cross product for momenta and wrenches.
template <class T>
MOMENTREE_INLINE constexpr Force<T> cross(const Motion<T>& a, const Force<T>& b) {
  return {cross(a.w, b.l), cross(a.v, b.l) + cross(a.w, b.h)};
}
/// −(Ω ×)ᵀ applied to a velocity: the cross product for velocities.
template <class T>
MOMENTREE_INLINE constexpr Motion<T> cross(const Motion<T>& a, const Motion<T>& b) {
  return {cross(a.w, b.v) + cross(a.v, b.w), cross(a.w, b.w)};
}

/// Mass matrix of a rigid or articulated body, symmetric: l = A v + B ω, h = Bᵀ v + J ω.
template <class T>
struct SpatialMass {
  Symmetric3<T> A;
  Matrix3<T> B;
  Symmetric3<T> J;
};

template <class T>
MOMENTREE_INLINE constexpr Force<T> operator*(const SpatialMass<T>& M, const Motion<T>& a) {
  return {M.A * a.v + M.B * a.w, transpose_times(M.B, a.v) + M.J * a.w};
}
template <class T>
MOMENTREE_INLINE constexpr SpatialMass<T>& operator+=(SpatialMass<T>& a, const SpatialMass<T>& b) {
  a.A = a.A + b.A;
  a.B = {a.B.xx + b.B.xx, a.B.xy + b.B.xy, a.B.xz + b.B.xz, a.B.yx + b.B.yx, a.B.yy + b.B.yy,
         a.B.yz + b.B.yz, a.B.zx + b.B.zx, a.B.zy + b.B.zy, a.B.zz + b.B.zz};
  a.J = a.J + b.J;
  return a;
}

/// A rigid body in the current frame: mass m (kg), first moment m·c (kg m), inertia about O (kg m²).
struct RigidMass {
  double m = 0;
  Vec3 mc{};
  Sym3 J{};
};
/// (4): adds the mass matrix [m, −m c̃; m c̃, J] of a rigid body; zeros cost nothing.
template <class T, class Body>
MOMENTREE_INLINE constexpr void add_rigid_mass(SpatialMass<T>& M, const Body& b) {
  M.A.xx += b.m, M.A.yy += b.m, M.A.zz += b.m;
  M.B.xy += b.mc.z, M.B.yx -= b.mc.z;
  M.B.xz -= b.mc.y, M.B.zx += b.mc.y;
  M.B.yz += b.mc.x, M.B.zy -= b.mc.x;
  M.J.xx += b.J.xx, M.J.yy += b.J.yy, M.J.zz += b.J.zz;
  M.J.xy += b.J.xy, M.J.xz += b.J.xz, M.J.yz += b.J.yz;
}
/// The mass matrix (4) itself.
template <class T>
MOMENTREE_INLINE constexpr SpatialMass<T> rigid_mass(const RigidMass& b) {
  const T o(0), m(b.m), x(b.mc.x), y(b.mc.y), z(b.mc.z);
  return {{m, m, m, o, o, o}, {o, z, -y, -z, o, x, y, -x, o}, {T(b.J.xx), T(b.J.yy), T(b.J.zz), T(b.J.xy), T(b.J.xz), T(b.J.yz)}};
}
/// M Ω of a rigid body (4).
template <class T>
MOMENTREE_INLINE constexpr Force<T> momentum(const RigidMass& b, const Motion<T>& a) {
  return {b.m * a.v + cross(a.w, b.mc), cross(b.mc, a.v) + b.J * a.w};
}

/// Ω × M Ω (9) of a rigid body: the wrench that changes the direction of its momentum.
template <class T, class Body>
MOMENTREE_INLINE constexpr Force<T> gyroscopic_wrench(const Body& b, const Motion<T>& a) {
  const Vector3<T> s = cross(a.w, a.v);
  const T square = dot(a.w, a.w);
  const Vector3<T> centripetal = {square * b.mc.x, square * b.mc.y, square * b.mc.z};
  return {b.m * s + dot(a.w, b.mc) * a.w - centripetal, cross(b.mc, s) + cross(a.w, b.J * a.w)};
}

// ---- rotations about one axis: components in child axes to components in parent axes; c and s of the child's angle

/// Rotates (x, y) by the angle of (c, s): the two components that a rotation about the third axis mixes.
template <class T, class C>
MOMENTREE_INLINE constexpr void rotate(T& x, T& y, const C& c, const C& s) {
  const T t = c * x - s * y;
  y = s * x + c * y;
  x = t;
}
template <class T, class C>
MOMENTREE_INLINE constexpr void rotate_z(Vector3<T>& a, const C& c, const C& s) {
  rotate(a.x, a.y, c, s);
}
template <class T, class C>
MOMENTREE_INLINE constexpr void rotate_x(Vector3<T>& a, const C& c, const C& s) {
  rotate(a.y, a.z, c, s);
}
/// The effect of a rotation on products of two components: c·s, s², and cosine and sine of the double angle.
template <class C>
struct PlaneRotation {
  C cs, ss, c2, s2;
  MOMENTREE_INLINE constexpr PlaneRotation(const C& c, const C& s) : PlaneRotation(c * s, s * s, 0) {}
  /// From c·s and s², if these are known.
  MOMENTREE_INLINE static constexpr PlaneRotation of_products(const C& cs, const C& ss) { return {cs, ss, 0}; }

 private:
  MOMENTREE_INLINE constexpr PlaneRotation(const C& product, const C& square, int)
      : cs(product), ss(square), c2(C(1) - (square + square)), s2(product + product) {}
};
/// Rotates the 2x2 block (xx, xy; xy, yy) of a symmetric matrix in its plane: the trace is invariant, the rest rotates by the
/// double angle.
template <class T, class C>
MOMENTREE_INLINE constexpr void rotate_block(T& xx, T& xy, T& yy, const PlaneRotation<C>& by) {
  const T d = xx - yy;
  const T t = by.ss * d + by.s2 * xy;
  xy = by.cs * d + by.c2 * xy;
  xx = xx - t;
  yy = yy + t;
}
/// The same for a general block (xx, xy; yx, yy): trace and skew part are invariant.
template <class T, class C>
MOMENTREE_INLINE constexpr void rotate_block(T& xx, T& xy, T& yx, T& yy, const PlaneRotation<C>& by) {
  const T d = xx - yy, e = xy + yx;
  const T t = by.ss * d + by.cs * e;
  const T o = by.cs * d - by.ss * e;
  xx = xx - t;
  yy = yy + t;
  xy = xy + o;
  yx = yx + o;
}
template <class T, class C>
MOMENTREE_INLINE constexpr void rotate_z(SpatialMass<T>& M, const C& c, const C& s) {
  const PlaneRotation<C> products(c, s);
  rotate_block(M.A.xx, M.A.xy, M.A.yy, products);
  rotate(M.A.xz, M.A.yz, c, s);
  rotate_block(M.B.xx, M.B.xy, M.B.yx, M.B.yy, products);
  rotate(M.B.xz, M.B.yz, c, s);
  rotate(M.B.zx, M.B.zy, c, s);
  rotate_block(M.J.xx, M.J.xy, M.J.yy, products);
  rotate(M.J.xz, M.J.yz, c, s);
}
template <class T, class C>
MOMENTREE_INLINE constexpr void rotate_x(SpatialMass<T>& M, const C& c, const C& s) {
  const PlaneRotation<C> products(c, s);
  rotate_block(M.A.yy, M.A.yz, M.A.zz, products);
  rotate(M.A.xy, M.A.xz, c, s);
  rotate_block(M.B.yy, M.B.yz, M.B.zy, M.B.zz, products);
  rotate(M.B.xy, M.B.xz, c, s);
  rotate(M.B.yx, M.B.zx, c, s);
  rotate_block(M.J.yy, M.J.yz, M.J.zz, products);
  rotate(M.J.xy, M.J.xz, c, s);
}
/// R M Rᵀ for any rotation.
template <class T>
MOMENTREE_INLINE constexpr void rotate(SpatialMass<T>& M, const Matrix3<T>& R) {
  M.A = rotate(R, M.A);
  const Matrix3<T> t = R * M.B;
  M.B = t * transpose(R);
  M.J = rotate(R, M.J);
}

/// (16) for a mass matrix, the translation: from the child's origin, located at r (in the current axes), to the parent's. B ← B −
/// A r̃, J ← J + r̃ B_new + (r̃ B_old)ᵀ.
template <class T, class S>
MOMENTREE_INLINE constexpr void shift(SpatialMass<T>& M, const Vector3<S>& r) {
  const Matrix3<T> b = M.B;  // before
  const Symmetric3<T>& A = M.A;
  M.B = {b.xx - (A.xy * r.z - A.xz * r.y), b.xy - (A.xz * r.x - A.xx * r.z), b.xz - (A.xx * r.y - A.xy * r.x),
         b.yx - (A.yy * r.z - A.yz * r.y), b.yy - (A.yz * r.x - A.xy * r.z), b.yz - (A.xy * r.y - A.yy * r.x),
         b.zx - (A.yz * r.z - A.zz * r.y), b.zy - (A.zz * r.x - A.xz * r.z), b.zz - (A.xz * r.y - A.yz * r.x)};
  const Matrix3<T>& n = M.B;  // after
  M.J.xx += r.y * (n.zx + b.zx) - r.z * (n.yx + b.yx);
  M.J.yy += r.z * (n.xy + b.xy) - r.x * (n.zy + b.zy);
  M.J.zz += r.x * (n.yz + b.yz) - r.y * (n.xz + b.xz);
  M.J.xy += (r.y * n.zy - r.z * n.yy) + (r.z * b.xx - r.x * b.zx);
  M.J.xz += (r.y * n.zz - r.z * n.yz) + (r.x * b.yx - r.y * b.xx);
  M.J.yz += (r.z * n.xz - r.x * n.zz) + (r.x * b.yy - r.y * b.xy);
}
/// (16): momentum or wrench about the parent's origin.
template <class T, class S>
MOMENTREE_INLINE constexpr void shift(Force<T>& P, const Vector3<S>& r) {
  P.h += cross(r, P.l);
}
/// (17): velocity of the body-fixed point at r.
template <class T, class S>
MOMENTREE_INLINE constexpr void shift_outboard(Motion<T>& a, const Vector3<S>& r) {
  a.v += cross(a.w, r);
}

}  // namespace momentree
