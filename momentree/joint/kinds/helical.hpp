#pragma once
// Helical (screw): an angle about z, with a displacement of `pitch` per revolution. E = (h e_z; e_z), constant, h in metres per
// radian.
#include <momentree/joint/joint.hpp>

namespace momentree {

struct HelicalKernels;

/// A screw: rotates about `axis` and translates along it by `pitch` metres per revolution.
struct Helical {
  static constexpr Kind kind = Kind::helical;
  static constexpr KindInfo info{Kind::helical, "helical", 1, 1, true, false, true, "r", "r"};
  using Kernels = HelicalKernels;

  Vec3 axis{0, 0, 1};
  double pitch = 0;
  Values damping{}, stiffness{}, rest{}, armature{}, effort{};
  JointLimits limits{};
  JointFriction friction{};
  std::shared_ptr<const JointDrive> drive{};
  JointStrength strength{};
};

}  // namespace momentree

#ifdef MOMENTREE_KERNELS  // the functions of the recursions: only for the library's own sources
#include <numbers>

#include <momentree/joint/closure.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/joint/screw_kernels.hpp>

namespace momentree {

struct HelicalKernels : ScrewKernels<HelicalKernels, 1, 1> {
  static constexpr std::array<int, 1> angles{0};
  static Mat3 frame(const JointSpec& joint, double* geometry) {
    geometry[0] = joint.pitch / (2 * std::numbers::pi);
    return frame_with_z(joint.axis);
  }
  template <class T>
  MOMENTREE_INLINE static Screw<T> screw(const auto& k, const JointState<T>& j) {
    return {j.c[0], j.s[0], k.geometry[0] * j.q[0]};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 1> columns(const auto& k, const JointState<T>&) {
    return {{{{T(0), T(0), T(k.geometry[0])}, {T(0), T(0), T(1)}}}};
  }
  static bool coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint, double* q) {
    return coordinates::about_axis(joint.axis, motion.rotation, hint.first, q[0]) &&
           coordinates::negligible(motion.position - (joint.pitch / (2 * std::numbers::pi) * q[0]) * joint.axis);
  }
  static void closure(const JointSpec& joint, Closure& rows) {
    rows.add_line(joint.axis), rows.add_axis(joint.axis), rows.add_screw(joint.axis, joint.pitch / (2 * std::numbers::pi));
  }
  /// A pure torque about the axis; the thread produces the force along it.
  static Force<double> drive_wrench(const LinkConstants&, const JointState<double>&, const double* force) {
    return {{}, {0, 0, force[0]}};
  }
};

}  // namespace momentree
#endif
