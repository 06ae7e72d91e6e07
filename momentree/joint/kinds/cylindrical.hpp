#pragma once
// Cylindrical: an angle about z and a displacement along z. E = (0 e_z; e_z 0), constant.
#include <momentree/joint/joint.hpp>

namespace momentree {

struct CylindricalKernels;

/// Rotates about `axis` and translates along it, independently: q = (angle, displacement).
struct Cylindrical {
  static constexpr Kind kind = Kind::cylindrical;
  static constexpr KindInfo info{Kind::cylindrical, "cylindrical", 2, 2, true, false, false, "rm", "rm"};
  using Kernels = CylindricalKernels;

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

struct CylindricalKernels : ScrewKernels<CylindricalKernels, 2, 2> {
  static constexpr std::array<int, 1> angles{0};
  template <class T>
  MOMENTREE_INLINE static Screw<T> screw(const auto&, const JointState<T>& j) {
    return {j.c[0], j.s[0], j.q[1]};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 2> columns(const auto&, const JointState<T>&) {
    return {{{{T(0), T(0), T(0)}, {T(0), T(0), T(1)}}, {{T(0), T(0), T(1)}, {T(0), T(0), T(0)}}}};
  }
  static bool coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint, double* q) {
    const bool turns = coordinates::about_axis(joint.axis, motion.rotation, hint.first, q[0]);
    return coordinates::along_axis(joint.axis, motion.position, q[1]) && turns;
  }
  static void lock_part(const JointSpec& joint, unsigned locked, const double* held, LockedForm& form) {
    if (locked == 1) {  // the angle
      form.parent.rotation = from_axis_angle(joint.axis, held[0]);
      form.rows.add_line(joint.axis), form.rows.add_rotation();
    } else {
      form.parent.position = held[1] * joint.axis;
      form.rows.add_point(), form.rows.add_axis(joint.axis);
    }
  }
  static void closure(const JointSpec& joint, Closure& rows) { rows.add_line(joint.axis), rows.add_axis(joint.axis); }
};

}  // namespace momentree
#endif
