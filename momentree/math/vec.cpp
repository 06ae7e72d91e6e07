#include <momentree/math/sine_cosine.hpp>
#include <momentree/math/vec.hpp>

#include <numbers>

namespace momentree {

Quat normalized(const Quat& q) {
  const double s = 1.0 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}

Quat quaternion_of(const Mat3& R) {
  const double t = R.xx + R.yy + R.zz;
  Quat q;
  if (t >= R.xx && t >= R.yy && t >= R.zz) {
    q = {1 + t, R.zy - R.yz, R.xz - R.zx, R.yx - R.xy};
  } else if (R.xx >= R.yy && R.xx >= R.zz) {
    q = {R.zy - R.yz, 1 + R.xx - R.yy - R.zz, R.xy + R.yx, R.xz + R.zx};
  } else if (R.yy >= R.zz) {
    q = {R.xz - R.zx, R.xy + R.yx, 1 - R.xx + R.yy - R.zz, R.yz + R.zy};
  } else {
    q = {R.yx - R.xy, R.xz + R.zx, R.yz + R.zy, 1 - R.xx - R.yy + R.zz};
  }
  q = normalized(q);
  return q.w < 0 ? Quat{-q.w, -q.x, -q.y, -q.z} : q;
}

Quat exp_rotation(const Vec3& phi) {
  const double angle = norm(phi);
  const SineCosine half = sine_cosine(angle / 2);
  const double s = angle < 1e-8 ? 0.5 - angle * angle / 48 : half.s / angle;
  return normalized(Quat{half.c, s * phi.x, s * phi.y, s * phi.z});
}

Vec3 log_rotation(const Quat& q) {
  const double sign = q.w < 0 ? -1 : 1, w = sign * q.w;
  const Vec3 v{sign * q.x, sign * q.y, sign * q.z};
  const double s = norm(v);
  return (s < 1e-150 ? 2.0 / w : 2.0 * std::atan2(s, w) / s) * v;
}

Quat from_axis_angle(const Vec3& axis, double angle) { return exp_rotation(angle * normalized(axis)); }

Quat from_rpy(double roll, double pitch, double yaw) {
  return normalized(exp_rotation({0, 0, yaw}) * exp_rotation({0, pitch, 0}) * exp_rotation({roll, 0, 0}));
}

Pose operator*(const Pose& a, const Pose& b) { return {a * b.position, normalized(a.rotation * b.rotation)}; }
Pose inverse(const Pose& a) { return {-transpose_times(rotation_matrix(a.rotation), a.position), conjugate(a.rotation)}; }
Vec3 operator*(const Pose& a, const Vec3& point) { return a.position + rotation_matrix(a.rotation) * point; }

}  // namespace momentree
