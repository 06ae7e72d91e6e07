#pragma once
// The laws of forces on bodies, for numbers and for numbers with derivatives.
#include <cmath>

#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/math/dual.hpp>

namespace momentree::forces {

/// Work and dissipation per time (W).
template <class T>
struct PowerOf {
  T work{}, dissipated{};
};

/// The wrench of one force on a body, in its kernel frame, from its pose and velocity.
template <class T>
Force<T> wrench_of(const BodyForce& force, const KernelFrame& frame, const Kinematics<T>& body, double t, PowerOf<T>& power) {
  using std::sqrt;
  const auto to_kernel = [&](const std::array<Signal, 3>& signals) -> Vector3<T> {
    const Vec3 a{signals[0].value(t), signals[1].value(t), signals[2].value(t)};
    if (!force.body_axes) return transpose_times(body.R, a);
    const Vec3 own = transpose_times(frame.R, a);
    return {T(own.x), T(own.y), T(own.z)};
  };
  const Vec3 at = transpose_times(frame.R, force.point - frame.r);
  const Vector3<T> v = body.velocity.v + cross(body.velocity.w, at);
  Force<T> W{to_kernel(force.force), to_kernel(force.torque)};
  power.work += dot(W.l, v) + dot(W.h, body.velocity.w);
  if (force.drag.any()) {
    const T speed = sqrt(dot(v, v)), resistance = force.drag.linear + force.drag.quadratic * force.drag.area * speed;
    W.l = W.l - resistance * v;
    power.dissipated += resistance * speed * speed;
  }
  W.h += cross(at, W.l);
  return W;
}

/// An end of a spring in the world, or a point of the ground.
template <class T>
struct SpringPoint {
  Vector3<T> place, velocity;
  Vec3 at{};                            ///< in the kernel frame of its body
  const Kinematics<T>* body = nullptr;  ///< null: the ground
};
template <class T>
SpringPoint<T> spring_point(const SpringEnd& end, const KernelFrame* frame, const Kinematics<T>* body) {
  if (body == nullptr) return {{T(end.point.x), T(end.point.y), T(end.point.z)}, {T(0), T(0), T(0)}};
  const Vec3 at = transpose_times(frame->R, end.point - frame->r);
  return {body->r + body->R * at, body->R * (body->velocity.v + cross(body->velocity.w, at)), at, body};
}
/// The line between two ends: as of SpringMotion.
template <class T>
struct SpringStretch {
  Vector3<T> direction{};
  T length, rate{};
  SpringStretch(const SpringPoint<T>& from, const SpringPoint<T>& to) : length(norm(to.place - from.place)) {
    if (!(value_of(length) > 0)) return;
    direction = (1.0 / length) * (to.place - from.place);
    rate = dot(direction, to.velocity - from.velocity);
  }
};
/// A force at that point, in world axes, as a wrench on its body in the kernel frame.
template <class T>
Force<T> pull(const SpringPoint<T>& end, const Vector3<T>& force) {
  const Vector3<T> own = transpose_times(end.body->R, force);
  return {own, cross(end.at, own)};
}

inline double tension_of(const SpringLaw& law, double length, double rate) { return law.tension(length, rate); }
template <class E>
Dual<E> tension_of(const SpringLaw& law, const Dual<E>& length, const Dual<E>& rate) {
  const double tension = law.tension(length.r, rate.r);
  if (law.tension_only && tension == 0) return Dual<E>(0);
  return {tension, law.stiffness * length.e + law.damping * rate.e};
}

}  // namespace momentree::forces
