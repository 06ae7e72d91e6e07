#pragma once
// Small fixed-size algebra for any scalar: vectors, 3x3 matrices, symmetric 3x3 matrices.
#include <cmath>

namespace momentree {

template <class T>
struct Vector3 {
  T x{}, y{}, z{};
};
using Vec3 = Vector3<double>;

template <class T>
constexpr Vector3<T> operator+(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
constexpr Vector3<T> operator-(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
constexpr Vector3<T> operator-(const Vector3<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T, class S>
constexpr Vector3<T> operator*(const S& s, const Vector3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
constexpr Vector3<T>& operator+=(Vector3<T>& a, const Vector3<T>& b) {
  return a = a + b;
}
template <class T>
constexpr Vector3<T>& operator-=(Vector3<T>& a, const Vector3<T>& b) {
  return a = a - b;
}
template <class T>
constexpr bool operator==(const Vector3<T>& a, const Vector3<T>& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}
template <class T, class S>
constexpr auto dot(const Vector3<T>& a, const Vector3<S>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// a × b; the skew matrix ã of (5) is never formed.
template <class T, class S>
constexpr auto cross(const Vector3<T>& a, const Vector3<S>& b) -> Vector3<decltype(a.x * b.x)> {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T norm(const Vector3<T>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}
inline Vec3 normalized(const Vec3& a) { return (1.0 / norm(a)) * a; }

/// Row-major 3x3 matrix; as a rotation it maps child axes to parent axes.
template <class T>
struct Matrix3 {
  T xx{}, xy{}, xz{}, yx{}, yy{}, yz{}, zx{}, zy{}, zz{};
};
using Mat3 = Matrix3<double>;

template <class T>
constexpr Matrix3<T> identity3() {
  return {T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)};
}
template <class T, class S>
constexpr auto operator*(const Matrix3<T>& m, const Vector3<S>& a) -> Vector3<decltype(m.xx * a.x)> {
  return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.yx * a.x + m.yy * a.y + m.yz * a.z, m.zx * a.x + m.zy * a.y + m.zz * a.z};
}
/// mᵀ a
template <class T, class S>
constexpr auto transpose_times(const Matrix3<T>& m, const Vector3<S>& a) -> Vector3<decltype(m.xx * a.x)> {
  return {m.xx * a.x + m.yx * a.y + m.zx * a.z, m.xy * a.x + m.yy * a.y + m.zy * a.z, m.xz * a.x + m.yz * a.y + m.zz * a.z};
}
template <class T>
constexpr Matrix3<T> transpose(const Matrix3<T>& m) {
  return {m.xx, m.yx, m.zx, m.xy, m.yy, m.zy, m.xz, m.yz, m.zz};
}
template <class T, class S>
constexpr auto operator*(const Matrix3<T>& a, const Matrix3<S>& b) -> Matrix3<decltype(a.xx * b.xx)> {
  return {
      a.xx * b.xx + a.xy * b.yx + a.xz * b.zx, a.xx * b.xy + a.xy * b.yy + a.xz * b.zy, a.xx * b.xz + a.xy * b.yz + a.xz * b.zz,
      a.yx * b.xx + a.yy * b.yx + a.yz * b.zx, a.yx * b.xy + a.yy * b.yy + a.yz * b.zy, a.yx * b.xz + a.yy * b.yz + a.yz * b.zz,
      a.zx * b.xx + a.zy * b.yx + a.zz * b.zx, a.zx * b.xy + a.zy * b.yy + a.zz * b.zy, a.zx * b.xz + a.zy * b.yz + a.zz * b.zz};
}

/// Symmetric 3x3 matrix, in the order in which users give an inertia.
template <class T>
struct Symmetric3 {
  T xx{}, yy{}, zz{}, xy{}, xz{}, yz{};
};
using Sym3 = Symmetric3<double>;

template <class T>
constexpr Symmetric3<T> operator+(const Symmetric3<T>& a, const Symmetric3<T>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}
template <class T, class S>
constexpr auto operator*(const Symmetric3<T>& m, const Vector3<S>& a) -> Vector3<decltype(m.xx * a.x)> {
  return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z, m.xz * a.x + m.yz * a.y + m.zz * a.z};
}
/// R m Rᵀ
template <class T, class S>
constexpr auto rotate(const Matrix3<T>& R, const Symmetric3<S>& m) -> Symmetric3<decltype(R.xx * m.xx)> {
  using U = decltype(R.xx * m.xx);
  const Matrix3<U> a = R * Matrix3<S>{m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz};
  return {a.xx * R.xx + a.xy * R.xy + a.xz * R.xz, a.yx * R.yx + a.yy * R.yy + a.yz * R.yz,
          a.zx * R.zx + a.zy * R.zy + a.zz * R.zz, a.xx * R.yx + a.xy * R.yy + a.xz * R.yz,
          a.xx * R.zx + a.xy * R.zy + a.xz * R.zz, a.yx * R.zx + a.yy * R.zy + a.yz * R.zz};
}

/// Unit quaternion (w, x, y, z): maps child axes to parent axes.
template <class T>
struct Quaternion {
  T w{1}, x{}, y{}, z{};
};
using Quat = Quaternion<double>;

template <class T>
constexpr Quaternion<T> operator*(const Quaternion<T>& a, const Quaternion<T>& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
template <class T>
constexpr Quaternion<T> conjugate(const Quaternion<T>& a) {
  return {a.w, -a.x, -a.y, -a.z};
}
/// Rotation matrix of a quaternion of any nonzero length: inside a step its length is not exactly one.
template <class T>
constexpr Matrix3<T> rotation_matrix(const Quaternion<T>& q) {
  const T s = T(2) / (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const T sx = s * q.x, sy = s * q.y, sz = s * q.z;
  const T wx = sx * q.w, wy = sy * q.w, wz = sz * q.w;
  const T xx = sx * q.x, xy = sx * q.y, xz = sx * q.z, yy = sy * q.y, yz = sy * q.z, zz = sz * q.z;
  return {T(1) - (yy + zz), xy - wz, xz + wy, xy + wz, T(1) - (xx + zz), yz - wx, xz - wy, yz + wx, T(1) - (xx + yy)};
}
/// Q̇ = ½ Q (0, ω), ω in child axes.
template <class T>
constexpr Quaternion<T> quaternion_rate(const Quaternion<T>& q, const Vector3<T>& w) {
  const T h(0.5);
  return {h * (-(q.x * w.x) - q.y * w.y - q.z * w.z), h * (q.w * w.x + q.y * w.z - q.z * w.y),
          h * (q.w * w.y + q.z * w.x - q.x * w.z), h * (q.w * w.z + q.x * w.y - q.y * w.x)};
}
Quat normalized(const Quat& q);
/// The quaternion of a rotation matrix, w >= 0; the largest component is computed by a square root, so that no orientation is
/// singular.
Quat quaternion_of(const Mat3& R);
/// Rotation by |phi| (rad) about phi.
Quat exp_rotation(const Vec3& phi);
/// Rotation vector of q (rad), of length at most pi.
Vec3 log_rotation(const Quat& q);
/// Roll, pitch, yaw (rad) about fixed x, y, z axes, as in URDF.
Quat from_rpy(double roll, double pitch, double yaw);
Quat from_axis_angle(const Vec3& axis, double angle);

/// Placement of one frame in another: `position` of its origin (m), `rotation` of its axes.
struct Pose {
  Vec3 position{};
  Quat rotation{};
  constexpr Pose() = default;
  constexpr Pose(double x, double y, double z) : position{x, y, z} {}
  constexpr Pose(const Vec3& position_) : position(position_) {}  // NOLINT(google-explicit-constructor): .at = {x, y, z}
  constexpr Pose(const Vec3& position_, const Quat& rotation_) : position(position_), rotation(rotation_) {}
};
/// Composition: the pose, in the frame in which a is given, of a frame that b places in a's frame.
Pose operator*(const Pose& a, const Pose& b);
Pose inverse(const Pose& a);
Vec3 operator*(const Pose& a, const Vec3& point);

constexpr Sym3 diagonal(double a) { return {a, a, a, 0, 0, 0}; }
constexpr Sym3 diagonal(double x, double y, double z) { return {x, y, z, 0, 0, 0}; }

}  // namespace momentree
