#pragma once
// Shared by the kinds that rotate about z and translate along z: revolute, prismatic, helical, cylindrical. Their kernel frame
// has z along the joint's axis; the placement's last rotation θ0 is added to the joint angle, so that one rotation does both.
#include <momentree/joint/kernels.hpp>

namespace momentree {

/// The generic record without the dense transform, which (c, s, d) of the screw replaces at no cost.
template <class T, int N>
struct ScrewRecord {
  SpatialMass<T> M;
  Force<T> D;
  std::array<Force<T>, static_cast<std::size_t>(N)> G;
  std::array<T, static_cast<std::size_t>(N)> u0;
  JointMass<T, N> Mj;
  Vector3<T> mc;
};

template <class T>
struct Screw {
  T c, s, d;
};

/// A right-handed frame whose z axis is the unit vector `axis`: the shortest rotation from z, exact if axis is ±x, ±y, ±z.
inline Mat3 frame_with_z(const Vec3& axis) {
  const double sign = axis.z < 0 ? -1.0 : 1.0;
  const double a = -1.0 / (sign + axis.z), b = axis.x * axis.y * a;
  return {
      1 + sign * axis.x * axis.x * a, b, axis.x, sign * b, sign + axis.y * axis.y * a, axis.y, -sign * axis.x, -axis.y, axis.z};
}

/// K provides `screw(link, joint state)`, with θ0 included in c and s, and `columns`.
template <class K, int NQ, int NV>
struct ScrewKernels : GenericKernels<K, NQ, NV> {
  template <class T>
  using Record = ScrewRecord<T, NV>;
  static constexpr bool rotates_about_z = true;
  static Mat3 frame(const JointSpec& joint, double*) { return frame_with_z(joint.axis); }

  template <class T>
  MOMENTREE_INLINE static void pose(const auto& k, const JointState<T>& j, Matrix3<T>& R, Vector3<T>& r) {
    const Screw<T> m = K::template screw<T>(k, j);
    R = {m.c, -m.s, T(0), m.s, m.c, T(0), T(0), T(0), T(1)};
    r = {T(0), T(0), m.d};
  }
  template <bool Aligned, class T>
  MOMENTREE_INLINE static auto joint_transform(const auto& k, const JointState<T>& j, const auto&) {
    Screw<T> m = K::template screw<T>(k, j);
    if constexpr (requires { k.d_apart; }) m.d = m.d + k.d;
    return ScrewTransform<T, Aligned, std::remove_cvref_t<decltype(k)>>{k, m.c, m.s, m.d};
  }
  template <bool Aligned, class T>
  MOMENTREE_INLINE static auto cached_transform(const auto& k, const JointState<T>& j, const auto& w) {
    return joint_transform<Aligned>(k, j, w);
  }
  /// E u = (v e_z; ω e_z).
  template <class T>
  MOMENTREE_INLINE static Screw<T> twist(const auto& k, const JointState<T>& j, const T* u) {
    const auto E = K::template columns<T>(k, j);
    Screw<T> t{T(0), T(0), T(0)};
    for (std::size_t i = 0; i < E.size(); ++i) t.s = t.s + u[i] * E[i].w.z, t.d = t.d + u[i] * E[i].v.z;
    return t;
  }
  /// Ω × E u.
  template <class T>
  MOMENTREE_INLINE static Motion<T> acceleration_bias(const auto& k, const JointState<T>& j, const Motion<T>& a, const T* u) {
    const Screw<T> t = twist(k, j, u);
    return {{t.s * a.v.y + t.d * a.w.y, -(t.s * a.v.x) - t.d * a.w.x, T(0)}, {t.s * a.w.y, -(t.s * a.w.x), T(0)}};
  }
};

/// For kinds with one DoF whose E is a unit vector, without armature. A row of the reduced mass is zero then, and G·E = 1.
/// `entry`: that of E in a motion or force.
template <class Base, std::size_t entry>
struct UnitKernels : Base {
  /// (24)–(26), with M̂ E = 0 and Eᵀ D̂ = p without round-off.
  template <class T>
  MOMENTREE_INLINE static void reduce(const auto& k, const JointState<T>& j, const T* p, const auto* armature, SpatialMass<T>& M,
                                      Force<T>& D, auto& w) {
    Base::reduce(k, j, p, armature, M, D, w);
    const T o(0);
    if constexpr (entry == 5)
      M.B.xz = M.B.yz = M.B.zz = M.J.xz = M.J.yz = M.J.zz = o, D.h.z = p[0], w.G[0].h.z = T(1);
    else
      M.A.xz = M.A.yz = M.A.zz = M.B.zx = M.B.zy = M.B.zz = o, D.l.z = p[0], w.G[0].l.z = T(1);
    w.M = M, w.D = D;
  }
  /// (51), with Eᵀ Ŵ = τ without round-off.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const auto& k, const JointState<T>& j, const auto& w, const T* tau, Force<T>& W,
                                             T* udot) {
    const T given = tau[0];  // `tau` may alias `udot`
    Base::reduce_wrench(k, j, w, tau, W, udot);
    (entry == 5 ? W.h.z : W.l.z) = given;
  }
  template <class T>
  MOMENTREE_INLINE static Motion<T> move(const auto&, const JointState<T>&, const auto& w, const Motion<T>& in, T* u) {
    return added(w, w.u0[0], in, u);
  }
  template <class T>
  MOMENTREE_INLINE static Motion<T> accelerate(const auto&, const JointState<T>&, const auto& w, const Motion<T>& in, T* udot) {
    return added(w, T(udot[0]), in, udot);
  }

 private:
  /// The entry of Ω first: u alone would lose digits beside a fast parent, and again in the sum.
  template <class T>
  MOMENTREE_INLINE static Motion<T> added(const auto& w, const T& u0, const Motion<T>& in, T* u) {
    Motion<T> out = in;
    const Force<T>& g = w.G[0];
    const Vector3<T>&v = in.v, &o = in.w;
    if constexpr (entry == 5) {
      out.w.z = u0 - ((g.l.x * v.x + g.h.x * o.x) + (g.l.y * v.y + g.h.y * o.y) + g.l.z * v.z);
      u[0] = out.w.z - o.z;
    } else {
      out.v.z = u0 - ((g.l.x * v.x + g.h.x * o.x) + (g.l.y * v.y + g.h.y * o.y) + g.h.z * o.z);
      u[0] = out.v.z - v.z;
    }
    return out;
  }
};

}  // namespace momentree
