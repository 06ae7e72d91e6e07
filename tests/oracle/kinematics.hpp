#pragma once
// Forward kinematics for any truncated series T: the pose of a joint's child if one DoF is displaced by ε (and all by v·τ).
#include <tests/oracle/oracle.hpp>

namespace momentree::oracle {

/// The motion of a joint: the velocities of its DoFs, the DoF displaced by ε (−1: none), and for a Curve their accelerations. ε
/// first: ball and free joints are displaced by ε and then move by τ, otherwise the other way round. The two differ by a Lie
/// bracket.
struct Perturbation {
  const Real* v = nullptr;
  int dof = -1;
  bool epsilon_first = true;
  const Real* a = nullptr;
};

template <class T>
M3<T> constant(const M3<Real>& m) {
  M3<T> out;
  for (unsigned i = 0; i < 9; ++i) out[i] = T(m[i]);
  return out;
}

/// For a quaternion of any length.
inline M3<Real> matrix_of(Real w, Real x, Real y, Real z) {
  const Real n = w * w + x * x + y * y + z * z;
  return {{(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n, 2 * (x * y + w * z) / n,
           (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n, 2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n,
           (w * w - x * x - y * y + z * z) / n}};
}
inline V3<Real> real(const Vec3& a) { return {{a.x, a.y, a.z}}; }
inline Frame<Real> frame_of(const Pose& pose) {
  const Quat& q = pose.rotation;
  return {matrix_of(q.w, q.x, q.y, q.z), real(pose.position)};
}
inline Frame<Real> inverse_of(const Frame<Real>& a) {
  const M3<Real> back = transposed(a.rotation);
  return {back, V3<Real>{} - back * a.position};
}
inline V3<Real> unit(const V3<Real>& a) { return scaled(1 / std::sqrt(dot(a, a)), a); }

/// Rotation by `angle` about the unit vector n (Rodrigues).
template <class T>
M3<T> turn(const V3<Real>& n, const T& angle) {
  const T s = sin(angle), c = cos(angle);
  const M3<Real> k = skew(n), kk = k * k;
  M3<T> out;
  for (unsigned i = 0; i < 9; ++i) out[i] = T(i % 4 == 0 ? 1 : 0) + k[i] * s + kk[i] * (T(1) - c);
  return out;
}

/// I + ã + ½ ã ã: exp(a) to second order in each infinitesimal.
template <class T>
M3<T> small_turn(const V3<T>& a) {
  M3<T> out = skew(a);
  const M3<T> square = out * out;
  for (unsigned i = 0; i < 9; ++i) out[i] = out[i] + Real(0.5) * square[i];
  for (unsigned i = 0; i < 9; i += 4) out[i] = out[i] + T(1);
  return out;
}
/// The displacement of an origin whose velocity rotates with it, to the same order: (I + ½ ã) s.
template <class T>
V3<T> small_way(const V3<T>& a, const V3<T>& s) {
  const V3<T> aside = skew(a) * s;
  return {{s[0] + Real(0.5) * aside[0], s[1] + Real(0.5) * aside[1], s[2] + Real(0.5) * aside[2]}};
}

/// exp of ε·(direction `dof`) and of τ·v in the group of the joint, in the order given by `by`.
template <class T>
Frame<T> small_motion(const Perturbation& by, int linear, int nv) {
  Frame<T> epsilon, tau;
  V3<T> a{}, w{};
  for (int i = 0; i < nv; ++i) {
    const unsigned k = static_cast<unsigned>(i < linear ? i : i - linear);
    (i < linear ? epsilon.position : a)[k] = T::variable(0, by.dof == i ? 1 : 0, 0, 0);
    (i < linear ? tau.position : w)[k] = T::variable(0, 0, by.v ? by.v[i] : 0, by.a ? by.a[i] : 0);
  }
  epsilon.rotation = small_turn(a);
  tau.rotation = small_turn(w);
  tau.position = small_way(w, tau.position);
  return by.epsilon_first ? epsilon * tau : tau * epsilon;
}

/// The joint's child-side frame in its parent-side frame.
template <class T>
Frame<T> joint_frame(const JointSpec& joint, const double* q, const Perturbation& by) {
  const auto x = [&](int i) { return T::variable(q[i], by.dof == i ? 1 : 0, by.v ? by.v[i] : 0, by.a ? by.a[i] : 0); };
  const V3<Real> n = joint.kind == Kind::planar || joint.kind == Kind::weld ? V3<Real>{{0, 0, 1}} : unit(real(joint.axis));
  const auto along = [&](const T& s) { return V3<T>{{n[0] * s, n[1] * s, n[2] * s}}; };
  Frame<T> f;
  switch (joint.kind) {
    case Kind::weld: break;
    case Kind::revolute: f.rotation = turn(n, x(0)); break;
    case Kind::prismatic: f.position = along(x(0)); break;
    case Kind::helical: {
      const Real per_radian = joint.pitch / (8 * std::atan(Real(1)));
      f = {turn(n, x(0)), along(per_radian * x(0))};
      break;
    }
    case Kind::cylindrical: f = {turn(n, x(0)), along(x(1))}; break;
    case Kind::universal: f.rotation = turn(n, x(0)) * turn(unit(real(joint.axis2)), x(1)); break;
    case Kind::planar: f = {turn(n, x(2)), {{x(0), x(1), T(0)}}}; break;
    case Kind::ball: f.rotation = constant<T>(matrix_of(q[0], q[1], q[2], q[3])) * small_motion<T>(by, 0, 3).rotation; break;
    case Kind::free: {
      Frame<T> start;
      start.rotation = constant<T>(matrix_of(q[3], q[4], q[5], q[6]));
      start.position = {{T(q[0]), T(q[1]), T(q[2])}};
      f = start * small_motion<T>(by, 3, 6);
      break;
    }
  }
  return f;
}

/// The constant frames of a link, in long double.
struct Mount {
  Frame<Real> at, child_back;
  V3<Real> com;
  M3<Real> inertia;
};
std::vector<Mount> mounts(const System& system);

template <class T>
Frame<T> body_frame(const Link& link, const Mount& mount, const Frame<T>& parent, const double* q, const Perturbation& by) {
  return parent * mount.at * joint_frame<T>(link.joint, q, by) * mount.child_back;
}

}  // namespace momentree::oracle
