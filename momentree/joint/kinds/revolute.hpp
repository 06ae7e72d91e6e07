#pragma once
// Revolute (hinge): one angle about z. E = (0; e_z), constant. The kind of the paper's tables, and the most specialised one.
#include <momentree/joint/joint.hpp>

namespace momentree {

template <bool Armature>
struct RevoluteKernelsWith;
struct GenericRevolute;

/// Revolute joint: rotates about `axis` through the joint's origin.
struct Revolute {
  static constexpr Kind kind = Kind::revolute;
  static constexpr KindInfo info{Kind::revolute, "revolute", 1, 1, true, false, false, "r", "r"};
  using Kernels = RevoluteKernelsWith<false>;
  using ArmatureKernels = RevoluteKernelsWith<true>;
  using Generic = GenericRevolute;

  Vec3 axis{0, 0, 1};
  Values damping{}, stiffness{}, rest{}, armature{}, effort{};
  JointLimits limits{};
  JointFriction friction{};
  std::shared_ptr<const JointDrive> drive{};
  JointStrength strength{};
};

}  // namespace momentree

#ifdef MOMENTREE_KERNELS  // the functions of the recursions: only for the library's own sources
#include <momentree/joint/closure.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/joint/revolute_steps.hpp>
#include <momentree/joint/screw_kernels.hpp>

namespace momentree {

/// Common to all revolute joints. With the generic functions it serves those that are locked, and is the reference for the
/// specialised steps.
template <class K>
struct RevoluteKernelsBase : ScrewKernels<K, 1, 1> {
  static constexpr std::array<int, 1> angles{0};
  template <class T>
  MOMENTREE_INLINE static Screw<T> screw(const auto&, const JointState<T>& j) {
    return {j.c[0], j.s[0], T(0)};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 1> columns(const auto&, const JointState<T>&) {
    return {{{{T(0), T(0), T(0)}, {T(0), T(0), T(1)}}}};
  }
  static bool coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint, double* q) {
    return coordinates::about_axis(joint.axis, motion.rotation, hint.first, q[0]) && coordinates::negligible(motion.position);
  }
  static void closure(const JointSpec& joint, Closure& rows) { rows.add_point(), rows.add_axis(joint.axis); }
  template <class T>
  MOMENTREE_INLINE static Motion<T> acceleration_bias(const LinkConstants&, const JointState<T>&, const Motion<T>& a,
                                                      const T* u) {
    return {{u[0] * a.v.y, -(u[0] * a.v.x), T(0)}, {u[0] * a.w.y, -(u[0] * a.w.x), T(0)}};
  }
};
struct GenericRevolute : RevoluteKernelsBase<GenericRevolute> {};

/// Without armature, or with it: then the reduced mass has no structural zeros.
template <bool Armature>
struct RevoluteKernelsWith : RevoluteKernelsBase<RevoluteKernelsWith<Armature>> {
  /// Whole steps of both passes by the shape of the link, in place of the separate functions of other kinds: (24)–(27), (21),
  /// (20).
  using Steps = RevoluteStepsOf<Armature>;
  using Generic = GenericRevolute;
  template <class T>
  using Record = typename Steps::template Record<T>;

  /// (17)
  template <class T>
  MOMENTREE_INLINE static Motion<T> spatial_velocity(const LinkConstants&, const JointState<T>&, const Motion<T>& in,
                                                     const T* u) {
    return {in.v, {in.w.x, in.w.y, in.w.z + u[0]}};
  }
  /// (51): the last component becomes τ, just as that of D̂ becomes p; with armature, less the part that accelerates it.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const LinkConstants&, const JointState<T>&, const Record<T>& w, const T* tau,
                                             Force<T>& W, T* udot) {
    const T r = tau[0] - W.h.z;
    T z = tau[0];
    if constexpr (Armature) z = W.h.z + w.ghz * r;
    W.l += r * w.gl;
    W.h = {W.h.x + w.ghx * r, W.h.y + w.ghy * r, z};
    udot[0] = w.inverse_mass * r;
  }
  template <class T>
  MOMENTREE_INLINE static void add_reduced_bias(const Record<T>& w, const Motion<T>& bias, Force<T>& F) {
    Steps::add_reduced_bias(w, bias, F);
  }
  /// (47)
  template <class T>
  MOMENTREE_INLINE static void joint_acceleration(const Record<T>& w, const Motion<T>& in, T* udot) {
    T last = in.w.z;
    if constexpr (Armature) last = w.ghz * last;
    udot[0] = udot[0] - along(w, in) - last;
  }
  template <class T>
  MOMENTREE_INLINE static void add_reduced(const Record<T>& w, const Motion<T>& a, Force<T>& F) {
    const Vector3<T>&v = a.v, &o = a.w;
    F.l.x = F.l.x + ((w.A.xx * v.x + w.Bxx * o.x) + (w.A.xy * v.y + w.Bxy * o.y) + w.A.xz * v.z);
    F.l.y = F.l.y + ((w.A.xy * v.x + w.Byx * o.x) + (w.A.yy * v.y + w.Byy * o.y) + w.A.yz * v.z);
    F.l.z = F.l.z + ((w.A.xz * v.x + w.Bzx * o.x) + (w.A.yz * v.y + w.Bzy * o.y) + w.A.zz * v.z);
    F.h.x = F.h.x + ((w.Bxx * v.x + w.Jxx * o.x) + (w.Byx * v.y + w.Jxy * o.y) + w.Bzx * v.z);
    F.h.y = F.h.y + ((w.Bxy * v.x + w.Jxy * o.x) + (w.Byy * v.y + w.Jyy * o.y) + w.Bzy * v.z);
    if constexpr (Armature) {
      const T turned = w.armature * o.z;
      F.l += turned * w.gl;
      F.h.x = F.h.x + turned * w.ghx, F.h.y = F.h.y + turned * w.ghy;
      F.h.z = F.h.z + (w.armature * along(w, a) + turned * w.ghz);
    }
  }

 private:
  /// Gᵀ a without its last term.
  template <class T>
  MOMENTREE_INLINE static T along(const Record<T>& w, const Motion<T>& a) {
    return (w.gl.x * a.v.x + w.ghx * a.w.x) + (w.gl.y * a.v.y + w.ghy * a.w.y) + w.gl.z * a.v.z;
  }
};
using RevoluteKernels = RevoluteKernelsWith<false>;
using ArmatureKernels = RevoluteKernelsWith<true>;

}  // namespace momentree
#endif
