#pragma once
// Rotational spring of ball and free joints: energy ½ Σ kᵢ φᵢ², φ = log(q0⁻¹ q) in child axes. With equal stiffnesses the torque
// is −k φ. In general it is −J_r(φ)⁻ᵀ K φ, the gradient of that energy: −K φ alone would not conserve it.
#include <momentree/math/dual.hpp>
#include <momentree/math/vec.hpp>

namespace momentree {

/// log_rotation of a quaternion of other scalars.
template <class T>
Vector3<T> log_rotation(const Quaternion<T>& q) {
  const double sign = value_of(q.w) < 0 ? -1 : 1;
  const T w = sign * q.w;
  const Vector3<T> v{sign * q.x, sign * q.y, sign * q.z};
  const T square = dot(v, v) / (w * w);
  if (value_of(square) < 1e-6) return ((2.0 - square * (2.0 / 3) + square * square * (2.0 / 5)) / w) * v;
  const T s = norm(v);
  return (2.0 * atan2(s, w) / s) * v;
}

template <class T>
T rotational_spring(const T* q, const double* q0, const double* stiffness, T* torque) {
  using std::tan;
  const Quaternion<T> relative =
      conjugate(Quaternion<T>{T(q0[0]), T(q0[1]), T(q0[2]), T(q0[3])}) * Quaternion<T>{q[0], q[1], q[2], q[3]};
  const Vector3<T> phi = log_rotation(relative);
  const Vector3<T> f{stiffness[0] * phi.x, stiffness[1] * phi.y, stiffness[2] * phi.z};
  // J_r(φ)⁻ᵀ f = f − ½ φ × f + b φ × (φ × f), b = (1 − (θ/2) cot(θ/2)) / θ²
  const T theta = norm(phi);
  const T half = 0.5 * theta;
  const T b = value_of(theta) < 1e-4 ? 1.0 / 12 + theta * theta / 720 : (1 - half / tan(half)) / (theta * theta);
  const Vector3<T> n = cross(phi, f);
  const Vector3<T> t = f - 0.5 * n + b * cross(phi, n);
  torque[0] = -t.x, torque[1] = -t.y, torque[2] = -t.z;
  return 0.5 * dot(f, phi);
}

}  // namespace momentree
