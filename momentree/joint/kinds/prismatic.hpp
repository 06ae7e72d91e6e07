#pragma once
// Prismatic (slider): one displacement along z. E = (e_z; 0), constant.
#include <momentree/joint/joint.hpp>

namespace momentree {

struct PrismaticKernels;
struct GenericPrismatic;

/// Prismatic joint: translates along `axis`.
struct Prismatic {
  static constexpr Kind kind = Kind::prismatic;
  static constexpr KindInfo info{Kind::prismatic, "prismatic", 1, 1, true, false, false, "m", "m"};
  using Kernels = PrismaticKernels;
  using Generic = GenericPrismatic;

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

/// Common to all prismatic joints. With the generic functions it serves those that are locked or have armature.
template <class K>
struct PrismaticKernelsBase : ScrewKernels<K, 1, 1> {
  static constexpr std::array<int, 0> angles{};
  template <class T>
  MOMENTREE_INLINE static Screw<T> screw(const auto& k, const JointState<T>& j) {
    return {T(k.cos_0), T(k.sin_0), j.q[0]};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 1> columns(const auto&, const JointState<T>&) {
    return {{{{T(0), T(0), T(1)}, {T(0), T(0), T(0)}}}};
  }
  static bool coordinates(const JointSpec& joint, const Pose& motion, const Turns&, double* q) {
    return coordinates::along_axis(joint.axis, motion.position, q[0]) && coordinates::negligible(motion.rotation);
  }
  static void closure(const JointSpec& joint, Closure& rows) { rows.add_line(joint.axis), rows.add_rotation(); }
};
struct GenericPrismatic : PrismaticKernelsBase<GenericPrismatic> {};
struct PrismaticKernels : UnitKernels<PrismaticKernelsBase<PrismaticKernels>, 2> {};

}  // namespace momentree
#endif
