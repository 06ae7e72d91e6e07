#pragma once
// Ball (spherical): a unit quaternion; u = ω relative to the parent, in child axes. E = (0; I), constant.
// p is a quasi-momentum: (20) holds unchanged, because Ω × Pb contains the structure constants.
#include <momentree/joint/joint.hpp>

namespace momentree {

struct BallKernels;

/// Rotates freely about a point: q = unit quaternion (w, x, y, z), v = relative angular velocity in child-side axes.
struct Ball {
  static constexpr Kind kind = Kind::ball;
  static constexpr KindInfo info{Kind::ball, "ball", 4, 3, false, false, false, "nnnn", "rrr"};
  using Kernels = BallKernels;

  Values damping{}, stiffness{}, rest{}, armature{}, effort{};
  JointFriction friction{};
  std::shared_ptr<const JointDrive> drive{};
  JointStrength strength{};
};

}  // namespace momentree

#ifdef MOMENTREE_KERNELS  // the functions of the recursions: only for the library's own sources
#include <momentree/joint/closure.hpp>
#include <momentree/joint/kernels.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/joint/quaternion_spring.hpp>

namespace momentree {

struct BallKernels : GenericKernels<BallKernels, 4, 3> {
  static constexpr std::array<int, 0> angles{};

  template <class T>
  MOMENTREE_INLINE static void pose(const auto&, const JointState<T>& j, Matrix3<T>& R, Vector3<T>& r) {
    R = rotation_matrix(Quaternion<T>{j.q[0], j.q[1], j.q[2], j.q[3]});
    r = {T(0), T(0), T(0)};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 3> columns(const auto&, const JointState<T>&) {
    const Vector3<T> o{T(0), T(0), T(0)};
    return {{{o, {T(1), T(0), T(0)}}, {o, {T(0), T(1), T(0)}}, {o, {T(0), T(0), T(1)}}}};
  }
  template <class T>
  MOMENTREE_INLINE static void coordinate_rate(const T* q, const T* u, T* qdot) {
    const Quaternion<T> d = quaternion_rate(Quaternion<T>{q[0], q[1], q[2], q[3]}, Vector3<T>{u[0], u[1], u[2]});
    qdot[0] = d.w, qdot[1] = d.x, qdot[2] = d.y, qdot[3] = d.z;
  }
  static void normalise(double* q) {
    const Quat n = normalized(Quat{q[0], q[1], q[2], q[3]});
    q[0] = n.w, q[1] = n.x, q[2] = n.y, q[3] = n.z;
  }
  static void zero(double* q) { q[0] = 1, q[1] = q[2] = q[3] = 0; }
  template <class T>
  static T spring(const T* q, const double* q0, const double* stiffness, T* force) {
    return rotational_spring(q, q0, stiffness, force);
  }
  static bool coordinates(const JointSpec&, const Pose& motion, const Turns&, double* q) {
    q[0] = motion.rotation.w, q[1] = motion.rotation.x, q[2] = motion.rotation.y, q[3] = motion.rotation.z;
    return coordinates::negligible(motion.position);
  }
  static void closure(const JointSpec&, Closure& rows) { rows.add_point(); }
};

}  // namespace momentree
#endif
