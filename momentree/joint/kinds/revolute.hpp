#pragma once
// Revolute (hinge): one angle about z. E = (0; e_z), constant. The kind of the paper's tables.
#include <momentree/joint/joint.hpp>

namespace momentree {

struct RevoluteKernels;
struct GenericRevolute;

/// Revolute joint: rotates about `axis` through the joint's origin.
struct Revolute {
  static constexpr Kind kind = Kind::revolute;
  static constexpr KindInfo info{Kind::revolute, "revolute", 1, 1, true, false, false, "r", "r"};
  using Kernels = RevoluteKernels;
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
#include <momentree/joint/screw_kernels.hpp>

namespace momentree {

/// Common to all revolute joints. With the generic functions it serves those that are locked or have armature.
template <class K>
struct RevoluteKernelsBase : ScrewKernels<K, 1, 1> {
  static constexpr std::array<int, 1> angles{0};
  static constexpr bool placed_by_shape = true;
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
  MOMENTREE_INLINE static Motion<T> acceleration_bias(const auto&, const JointState<T>&, const Motion<T>& a, const T* u) {
    return {{u[0] * a.v.y, -(u[0] * a.v.x), T(0)}, {u[0] * a.w.y, -(u[0] * a.w.x), T(0)}};
  }
};
struct GenericRevolute : RevoluteKernelsBase<GenericRevolute> {};
struct RevoluteKernels : UnitKernels<RevoluteKernelsBase<RevoluteKernels>, 5> {};

}  // namespace momentree
#endif
