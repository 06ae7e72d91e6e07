#pragma once
// Free (six DoFs): position in parent-side axes and a unit quaternion; u = (v; ω) relative to the parent, in child axes, v being
// that of the joint's child-side origin. The kernel frame of a floating body is at its centre of mass, c from there: E = (I, −c×;
// 0, I), constant, with the inverse (I, c×; 0, I). Elsewhere, and for joints with armature or locked DoFs, c = 0. Eᵀ Pb = p
// determines Pb. Only Pb passes inboard: M̂ = 0 exactly. The generic subtraction would leave round-off there and couple bodies
// that are uncoupled.
#include <momentree/joint/joint.hpp>

namespace momentree {

struct FreeKernels;
struct GenericFree;

/// No constraint: q = position of the child-side origin in the parent-side frame and a unit quaternion (w, x, y, z); v = linear
/// velocity of that origin and angular velocity relative to the parent, both in child-side axes.
struct Free {
  static constexpr Kind kind = Kind::free;
  static constexpr KindInfo info{Kind::free, "free", 7, 6, false, false, false, "mmmnnnn", "mmmrrr"};
  using Kernels = FreeKernels;
  using Generic = GenericFree;

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

template <class K>
struct SixDofs : GenericKernels<K, 7, 6> {
  static constexpr std::array<int, 0> angles{};

  template <class T>
  MOMENTREE_INLINE static void pose(const auto&, const JointState<T>& j, Matrix3<T>& R, Vector3<T>& r) {
    R = rotation_matrix(Quaternion<T>{j.q[3], j.q[4], j.q[5], j.q[6]});
    r = {j.q[0], j.q[1], j.q[2]};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 6> columns(const auto&, const JointState<T>&) {
    const Vector3<T> o{T(0), T(0), T(0)}, x{T(1), T(0), T(0)}, y{T(0), T(1), T(0)}, z{T(0), T(0), T(1)};
    return {{{x, o}, {y, o}, {z, o}, {o, x}, {o, y}, {o, z}}};
  }
  template <class T>
  MOMENTREE_INLINE static void coordinate_rate(const T* q, const T* u, T* qdot) {
    const Quaternion<T> Q{q[3], q[4], q[5], q[6]};
    const Vector3<T> r = rotation_matrix(Q) * Vector3<T>{u[0], u[1], u[2]};
    const Quaternion<T> d = quaternion_rate(Q, Vector3<T>{u[3], u[4], u[5]});
    qdot[0] = r.x, qdot[1] = r.y, qdot[2] = r.z;
    qdot[3] = d.w, qdot[4] = d.x, qdot[5] = d.y, qdot[6] = d.z;
  }
  static void normalise(double* q) {
    const Quat n = normalized(Quat{q[3], q[4], q[5], q[6]});
    q[3] = n.w, q[4] = n.x, q[5] = n.y, q[6] = n.z;
  }
  static void zero(double* q) {
    for (int i = 0; i < 7; ++i) q[i] = i == 3 ? 1 : 0;
  }
  /// Translational springs along the parent-side axes, ½ Σ kᵢ (rᵢ − r0ᵢ)²; rotational springs as for a ball joint.
  template <class T>
  static T spring(const T* q, const double* q0, const double* stiffness, T* force) {
    const Vector3<T> x{q[0] - q0[0], q[1] - q0[1], q[2] - q0[2]};
    const Vector3<T> f{-stiffness[0] * x.x, -stiffness[1] * x.y, -stiffness[2] * x.z};
    const Vector3<T> child = transpose_times(rotation_matrix(Quaternion<T>{q[3], q[4], q[5], q[6]}), f);
    force[0] = child.x, force[1] = child.y, force[2] = child.z;
    return -0.5 * dot(f, x) + rotational_spring(q + 3, q0 + 3, stiffness + 3, force + 3);
  }
  static bool coordinates(const JointSpec&, const Pose& motion, const Turns&, double* q) {
    q[0] = motion.position.x, q[1] = motion.position.y, q[2] = motion.position.z;
    q[3] = motion.rotation.w, q[4] = motion.rotation.x, q[5] = motion.rotation.y, q[6] = motion.rotation.z;
    return true;
  }
  static void closure(const JointSpec&, Closure&) {}
};

/// With the kernel frame at c from the joint's child-side origin.
template <class K>
struct SixDofsOfCentre : SixDofs<K> {
  /// c
  template <class T>
  MOMENTREE_INLINE static Vector3<T> offset(const auto& k) {
    return {T(k.geometry[0]), T(k.geometry[1]), T(k.geometry[2])};
  }
  /// E⁻ᵀ f: forces or momenta of the DoFs as a wrench on the kernel frame.
  template <class T>
  MOMENTREE_INLINE static Force<T> wrench(const Vector3<T>& c, const T* f) {
    const Vector3<T> l{f[0], f[1], f[2]};
    return {l, Vector3<T>{f[3], f[4], f[5]} - cross(c, l)};
  }
  /// u = E⁻¹ a.
  template <class T>
  MOMENTREE_INLINE static void rates(const Vector3<T>& c, const Motion<T>& a, T* u) {
    const Vector3<T> v = a.v + cross(c, a.w);
    u[0] = v.x, u[1] = v.y, u[2] = v.z, u[3] = a.w.x, u[4] = a.w.y, u[5] = a.w.z;
  }
  template <class T>
  MOMENTREE_INLINE static void pose(const auto& k, const JointState<T>& j, Matrix3<T>& R, Vector3<T>& r) {
    SixDofs<K>::template pose<T>(k, j, R, r);
    r = r + R * offset<T>(k);
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 6> columns(const auto& k, const JointState<T>& j) {
    Columns<T, 6> E = SixDofs<K>::template columns<T>(k, j);
    const Vector3<T> c = offset<T>(k);
    E[3].v = {T(0), -c.z, c.y}, E[4].v = {c.z, T(0), -c.x}, E[5].v = {-c.y, c.x, T(0)};
    return E;
  }
  /// (17)
  template <class T>
  MOMENTREE_INLINE static Motion<T> spatial_velocity(const auto& k, const JointState<T>&, const Motion<T>& in, const T* u) {
    const Vector3<T> w{u[3], u[4], u[5]};
    return in + Motion<T>{Vector3<T>{u[0], u[1], u[2]} + cross(w, offset<T>(k)), w};
  }
  static Force<double> drive_wrench(const LinkConstants& k, const JointState<double>&, const double* force) {
    return wrench<double>(offset<double>(k), force);
  }
};

struct GenericFree : SixDofs<GenericFree> {};

template <class T>
struct FreeRecord {
  Motion<T> a0;        ///< E u if the parent is at rest
  Force<T> P;          ///< Pb
  Vector3<T> offset;   ///< c
  JointMass<T, 6> Mj;  ///< in terms of velocities of the kernel frame: Mb
  Vector3<T> mc;
  DenseTransform<T> x;
};

struct FreeKernels : SixDofsOfCentre<FreeKernels> {
  template <class T>
  using Record = FreeRecord<T>;

  /// (24)–(26): the DoFs span all velocities, so that Pb = E⁻ᵀ p, M̂ = 0 and D̂ = Pb.
  template <class T>
  MOMENTREE_INLINE static void reduce(const auto& k, const JointState<T>&, const T* p, const auto*, SpatialMass<T>& M,
                                      Force<T>& D, Record<T>& w) {
    auto& m = w.Mj;
    m(0, 0) = M.A.xx, m(1, 0) = M.A.xy, m(1, 1) = M.A.yy, m(2, 0) = M.A.xz, m(2, 1) = M.A.yz, m(2, 2) = M.A.zz;
    m(3, 0) = M.B.xx, m(3, 1) = M.B.yx, m(3, 2) = M.B.zx, m(4, 0) = M.B.xy, m(4, 1) = M.B.yy, m(4, 2) = M.B.zy;
    m(5, 0) = M.B.xz, m(5, 1) = M.B.yz, m(5, 2) = M.B.zz;
    m(3, 3) = M.J.xx, m(4, 3) = M.J.xy, m(4, 4) = M.J.yy, m(5, 3) = M.J.xz, m(5, 4) = M.J.yz, m(5, 5) = M.J.zz;
    m.factorise();
    w.offset = offset<T>(k);
    w.P = wrench<T>(w.offset, p);
    w.a0 = solved(w, w.P - D);
    M = {};
    D = w.P;
  }
  /// (27)
  template <class T>
  MOMENTREE_INLINE static void joint_velocity(const Record<T>& w, const Motion<T>& in, T* u) {
    rates<T>(w.offset, {w.a0.v - in.v, w.a0.w - in.w}, u);
  }
  /// (21)
  template <class T>
  MOMENTREE_INLINE static Force<T> articulated_momentum(const Record<T>& w, const T*, const Motion<T>&) {
    return w.P;
  }
  /// Ω × Pb, (20), of a body that carries no other. There Pb.l = m v + ω × mc, and without the products m v v, which cancel,
  /// nothing but its own momentum turns a light body.
  template <class T>
  MOMENTREE_INLINE static Force<T> gyroscopic(const auto& mc, const Motion<T>& a, const Force<T>& P) {
    const Vector3<T> c{T(mc.x), T(mc.y), T(mc.z)};
    return {cross(a.w, P.l), cross(a.w, P.h) + cross(a.v, cross(a.w, c))};
  }
  /// (51): only τ reaches the parent.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const auto&, const JointState<T>&, const Record<T>& w, const T* tau, Force<T>& W,
                                             T* udot) {
    const Force<T> t = wrench<T>(w.offset, tau);
    rates<T>(w.offset, solved(w, t - W), udot);
    W = t;
  }
  /// (47)
  template <class T>
  MOMENTREE_INLINE static void joint_acceleration(const Record<T>& w, const Motion<T>& in, T* udot) {
    T without[6];
    rates<T>(w.offset, in, without);
    for (int i = 0; i < 6; ++i) udot[i] = udot[i] - without[i];
  }
  template <class T>
  MOMENTREE_INLINE static void add_reduced(const Record<T>&, const Motion<T>&, Force<T>&) {}

 private:
  /// Mb⁻¹ f
  template <class T>
  MOMENTREE_INLINE static Motion<T> solved(const Record<T>& w, const Force<T>& f) {
    std::array<T, 6> a{f.l.x, f.l.y, f.l.z, f.h.x, f.h.y, f.h.z};
    w.Mj.solve(a);
    return {{a[0], a[1], a[2]}, {a[3], a[4], a[5]}};
  }
};

}  // namespace momentree
#endif
