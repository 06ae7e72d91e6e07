#pragma once
// Planar: x, y in the parent-side axes, then an angle about z. E = [Rᵀe_x, Rᵀe_y; e_z], Ė = [−ω × Rᵀe_x, −ω × Rᵀe_y; 0].
#include <momentree/joint/joint.hpp>

namespace momentree {

struct PlanarKernels;

/// Translates in the x-y plane of the joint's frame and rotates about its z axis.
struct Planar {
  static constexpr Kind kind = Kind::planar;
  static constexpr KindInfo info{Kind::planar, "planar", 3, 3, false, false, false, "mmr", "mmr"};
  using Kernels = PlanarKernels;

  Values damping{}, stiffness{}, rest{}, armature{}, effort{};
  JointLimits limits{};
  JointFriction friction{};
  std::shared_ptr<const JointDrive> drive{};
  JointStrength strength{};
};

}  // namespace momentree

#ifdef MOMENTREE_KERNELS  // the functions of the recursions: only for the library's own sources
#include <momentree/joint/closure.hpp>
#include <momentree/joint/kernels.hpp>
#include <momentree/joint/motion.hpp>

namespace momentree {

struct PlanarKernels : GenericKernels<PlanarKernels, 3, 3> {
  static constexpr std::array<int, 1> angles{2};

  template <class T>
  MOMENTREE_INLINE static void pose(const auto&, const JointState<T>& j, Matrix3<T>& R, Vector3<T>& r) {
    R = {j.c[0], -j.s[0], T(0), j.s[0], j.c[0], T(0), T(0), T(0), T(1)};
    r = {j.q[0], j.q[1], T(0)};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 3> columns(const auto&, const JointState<T>& j) {
    const Vector3<T> o{T(0), T(0), T(0)};
    return {{{{j.c[0], -j.s[0], T(0)}, o}, {{j.s[0], j.c[0], T(0)}, o}, {o, {T(0), T(0), T(1)}}}};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 3> columns_rate(const auto&, const JointState<T>& j, const T* u) {
    const Vector3<T> o{T(0), T(0), T(0)};
    const T w = u[2];
    return {{{{-(w * j.s[0]), -(w * j.c[0]), T(0)}, o}, {{w * j.c[0], -(w * j.s[0]), T(0)}, o}, {o, o}}};
  }
  static bool coordinates(const JointSpec&, const Pose& motion, const Turns& hint, double* q) {
    q[0] = motion.position.x, q[1] = motion.position.y;
    return coordinates::about_axis(z_axis, motion.rotation, hint.first, q[2]) &&
           std::fabs(motion.position.z) <= coordinates::tolerance;
  }
  static void closure(const JointSpec&, Closure& rows) { rows.add_position({0, 0, 1}), rows.add_axis({0, 0, 1}); }
};

}  // namespace momentree
#endif
