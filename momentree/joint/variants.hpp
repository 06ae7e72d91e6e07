#pragma once
// Kernels of joints that are not used as declared: with parent and child exchanged by re-rooting, or with locked DoFs. Both wrap
// any kind.
#include <momentree/joint/kernels.hpp>

namespace momentree {

/// Parent and child exchanged: pose and E of the inverse motion, with the same q, u. X_rev = X⁻¹, E_rev = −X⁻¹ E, Ė_rev = −X⁻¹
/// (cm(E u) E + Ė), cm being the cross product of velocities. Kinds that rotate about z do not need it: their kernel frame is
/// flipped instead (Tree::make_frame).
template <class K, int NQ, int NV>
struct ReversedKernels : GenericKernels<ReversedKernels<K, NQ, NV>, NQ, NV> {
  static constexpr auto angles = K::angles;

  template <class T>
  MOMENTREE_INLINE static void pose(const LinkConstants& k, const JointState<T>& j, Matrix3<T>& R, Vector3<T>& r) {
    Matrix3<T> forward;
    Vector3<T> at;
    K::template pose<T>(k, j, forward, at);
    R = transpose(forward);
    r = -(R * at);
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, NV> columns(const LinkConstants& k, const JointState<T>& j) {
    return inverted(k, j, K::template columns<T>(k, j));
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, NV> columns_rate(const LinkConstants& k, const JointState<T>& j, const T* u) {
    Columns<T, NV> E = K::template columns<T>(k, j);
    Motion<T> rel{};
    for (std::size_t i = 0; i < E.size(); ++i) rel = rel + Motion<T>{u[i] * E[i].v, u[i] * E[i].w};
    for (Motion<T>& e : E) e = cross(rel, e);
    if constexpr (requires { K::template columns_rate<T>(k, j, u); }) {
      const Columns<T, NV> Edot = K::template columns_rate<T>(k, j, u);
      for (std::size_t i = 0; i < E.size(); ++i) E[i] = E[i] + Edot[i];
    }
    return inverted(k, j, E);
  }
  template <class T>
  MOMENTREE_INLINE static void coordinate_rate(const T* q, const T* u, T* qdot) {
    K::template coordinate_rate<T>(q, u, qdot);
  }
  static void normalise(double* q) { K::normalise(q); }
  static void zero(double* q) { K::zero(q); }
  template <class T>
  static T spring(const T* q, const double* q0, const double* stiffness, T* force) {
    return K::spring(q, q0, stiffness, force);
  }
  static Mat3 frame(const JointSpec& joint, double* geometry) { return K::frame(joint, geometry); }
  /// The drive acts on the declared child as before, and on the body that now carries the joint with the opposite wrench.
  static Force<double> drive_wrench(const LinkConstants& k, const JointState<double>& j, const double* force) {
    const Force<double> W = K::drive_wrench(k, j, force);
    Mat3 R;
    Vec3 r;
    K::template pose<double>(k, j, R, r);
    Force<double> on_carrier{-(R * W.l), -(R * W.h)};
    shift(on_carrier, r);
    return on_carrier;
  }

 private:
  // −X⁻¹ E: from the declared child's frame to the declared parent's.
  template <class T>
  MOMENTREE_INLINE static Columns<T, NV> inverted(const LinkConstants& k, const JointState<T>& j, Columns<T, NV> E) {
    Matrix3<T> R;
    Vector3<T> r;
    K::template pose<T>(k, j, R, r);
    for (Motion<T>& e : E) {
      const Vector3<T> w = R * e.w;
      e = {-(R * e.v + cross(r, w)), -w};
    }
    return E;
  }
};

/// Some or all DoFs without momenta (LinkConstants::locked, a bit per DoF): frozen in place, or driven (LinkConstants::driven).
/// Their columns of E are dropped, and p holds their prescribed rate: u = p, zero if frozen. Coordinates and the lengths of q and
/// p stay, so that a lock moves nothing in memory.
template <class B, int NV>
struct LockedKernels : B {
  /// (24)–(26) with E′ = E B: a dropped column gets a one on the diagonal of Mj instead, so that its u equals p; the rate s of a
  /// driven DoF contributes momentum: Db + Mb E s.
  template <class T>
  MOMENTREE_INLINE static void reduce(const LinkConstants& k, const JointState<T>& j, const T* p, const double* armature,
                                      SpatialMass<T>& M, Force<T>& D, auto& w) {
    auto E = B::template columns<T>(k, j);
    double own[NV > 0 ? NV : 1] = {};
    for (std::size_t i = 0; i < E.size(); ++i) {
      const bool locked = (k.locked >> i & 1u) != 0;
      own[i] = locked ? 1.0 : armature[i];
      if ((k.driven >> i & 1u) != 0) D += M * Motion<T>{p[i] * E[i].v, p[i] * E[i].w};
      if (locked) E[i] = Motion<T>{};
    }
    if constexpr (NV == 1) {
      if (k.locked != 0) {  // nothing is left to reduce
        w.M = M, w.D = D, w.G[0] = Force<T>{}, w.u0[0] = p[0], w.Mj.inverse[0] = T(1);
        return;
      }
    }
    reduce_generic<T, NV>(E, p, own, M, D, w);
  }
  /// (20): zero for locked DoFs, which keep p = 0; the acceleration of driven DoFs is set by the caller.
  template <class T>
  MOMENTREE_INLINE static void momentum_rate(const LinkConstants& k, const JointState<T>& j, const T* u, const Force<T>& Pb,
                                             const Force<T>& wrench, T* pdot) {
    B::template momentum_rate<T>(k, j, u, Pb, wrench, pdot);
    for (int i = 0; i < NV; ++i)
      if ((k.locked >> i & 1) != 0) pdot[i] = T(0);
  }
  /// (51) with E′ = E B: a frozen DoF transmits no joint force and has u̇ = 0; for a driven DoF τ holds u̇, which M̂ resists.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const LinkConstants& k, const JointState<T>& j, const auto& w, const T* tau,
                                             Force<T>& W, T* udot) {
    auto E = B::template columns<T>(k, j);
    Motion<T> given{};
    for (std::size_t i = 0; i < E.size(); ++i) {
      if ((k.driven >> i & 1u) != 0) given = given + Motion<T>{tau[i] * E[i].v, tau[i] * E[i].w};
      if ((k.locked >> i & 1u) != 0) E[i] = Motion<T>{};
    }
    reduce_wrench_generic<T, NV>(E, w, tau, W, udot);
    if (k.driven != 0) {
      B::add_reduced(w, given, W);
      B::joint_acceleration(w, given, udot);  // of the free DoFs: the columns of G of the others are zero
    }
  }
};

}  // namespace momentree
