#pragma once
// Prismatic (slider): one displacement along z. E = (e_z; 0), constant.
#include <momentree/joint/joint.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/joint/screw_kernels.hpp>

namespace momentree {

struct PrismaticKernels : ScrewKernels<PrismaticKernels, 1, 1> {
  static constexpr std::array<int, 0> angles{};
  template <class T>
  MOMENTREE_INLINE static Screw<T> screw(const Link& k, const JointState<T>& j) {
    return {T(k.cos_0), T(k.sin_0), j.q[0]};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 1> columns(const Link&, const JointState<T>&) {
    return {{{{T(0), T(0), T(1)}, {T(0), T(0), T(0)}}}};
  }
  static bool coordinates(const JointSpec& joint, const Pose& motion, double, double* q) {
    return coordinates::negligible(motion.rotation) && coordinates::along_axis(joint.axis, motion.position, q[0]);
  }
};

/// A slider: moves along `axis`.
struct Prismatic {
  static constexpr Kind kind = Kind::prismatic;
  static constexpr KindInfo info{Kind::prismatic, "prismatic", 1, 1, true, false, false, "m", "m"};
  using Kernels = PrismaticKernels;

  Vec3 axis{0, 0, 1};
  Values damping{}, stiffness{}, rest{}, armature{}, effort{};
  JointLimits limits{};
  JointFriction friction{};
  std::shared_ptr<const JointDrive> drive{};
  JointStrength strength{};
};

}  // namespace momentree
