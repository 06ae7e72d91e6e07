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

}  // namespace momentree
