#pragma once
// Universal (Hooke, Cardan): R = R(n1, a) R(n2, b). The frame is chosen so that n2 = z and n1 lies in the x-z plane.
// E = [R2ᵀ n1, n2] in its angular part; Ė = [−(ḃ n2) × R2ᵀ n1, 0].
#include <momentree/joint/joint.hpp>

namespace momentree {

struct UniversalKernels;

/// Two intersecting axes: rotates about `axis`, then about `axis2`, which the first rotation carries along.
struct Universal {
  static constexpr Kind kind = Kind::universal;
  static constexpr KindInfo info{Kind::universal, "universal", 2, 2, true, true, false, "rr", "rr"};
  using Kernels = UniversalKernels;

  Vec3 axis{1, 0, 0}, axis2{0, 1, 0};
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

struct UniversalKernels : GenericKernels<UniversalKernels, 2, 2> {
  static constexpr std::array<int, 2> angles{0, 1};
  /// z = n2, x = the component of n1 perpendicular to it, normalised.
  static Mat3 frame(const JointSpec& joint, double* geometry) {
    const Vec3 z = joint.axis2, y = normalized(cross(z, joint.axis)), x = cross(y, z);
    geometry[0] = dot(joint.axis, x);
    geometry[1] = dot(joint.axis, z);
    return {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
  }

  template <class T>
  MOMENTREE_INLINE static void pose(const auto& k, const JointState<T>& j, Matrix3<T>& R, Vector3<T>& r) {
    const auto x = k.geometry[0], z = k.geometry[1];
    const T c = j.c[0], s = j.s[0], o = T(1) - c;
    const Matrix3<T> R1{c + o * (x * x), -(s * z), o * (x * z), s * z, c, -(s * x), o * (x * z), s * x, c + o * (z * z)};
    const Matrix3<T> R2{j.c[1], -j.s[1], T(0), j.s[1], j.c[1], T(0), T(0), T(0), T(1)};
    R = R1 * R2;
    r = {T(0), T(0), T(0)};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 2> columns(const auto& k, const JointState<T>& j) {
    const Vector3<T> n1{j.c[1] * k.geometry[0], -(j.s[1] * k.geometry[0]), T(k.geometry[1])};
    const Vector3<T> o{T(0), T(0), T(0)};
    return {{{o, n1}, {o, {T(0), T(0), T(1)}}}};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 2> columns_rate(const auto& k, const JointState<T>& j, const T* u) {
    const Vector3<T> o{T(0), T(0), T(0)};
    return {{{o, {-(u[1] * (j.s[1] * k.geometry[0])), -(u[1] * (j.c[1] * k.geometry[0])), T(0)}}, {o, o}}};
  }
  /// The first rotation takes axis2 to its direction after the motion; the remaining rotation is the second.
  static bool coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint, double* q) {
    const Vec3 from = joint.axis2, to = rotation_matrix(motion.rotation) * joint.axis2;
    const double along = dot(joint.axis, from);
    q[0] = coordinates::unwrapped(std::atan2(dot(joint.axis, cross(from, to)), dot(from, to) - along * along), hint.first);
    const Quat rest = conjugate(from_axis_angle(joint.axis, q[0])) * motion.rotation;
    return coordinates::about_axis(joint.axis2, rest, hint.second, q[1]) && coordinates::negligible(motion.position) &&
           std::fabs(dot(joint.axis, to) - along) <= coordinates::tolerance;
  }
  static void lock_part(const JointSpec& joint, unsigned locked, const double* held, LockedForm& form) {
    const bool first = locked == 1;
    (first ? form.parent : form.child).rotation = from_axis_angle(first ? joint.axis : joint.axis2, first ? held[0] : -held[1]);
    form.rows.add_point(), form.rows.add_axis(first ? joint.axis2 : joint.axis);
  }
  static void closure(const JointSpec& joint, Closure& rows) { rows.add_point(), rows.add_direction(joint.axis, joint.axis2); }
  /// A torque in the plane of the axes that are not locked: along the remaining axis if only one is.
  static Force<double> drive_wrench(const LinkConstants& k, const JointState<double>& j, const double* force) {
    const Columns<double, 2> E = columns<double>(k, j);
    const double c = k.locked == 0 ? k.geometry[1] : 0, across = 1 - c * c;
    return {{}, ((force[0] - c * force[1]) / across) * E[0].w + ((force[1] - c * force[0]) / across) * E[1].w};
  }
};

}  // namespace momentree
#endif
