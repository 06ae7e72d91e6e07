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

/// After reduction about z: M̂ E = 0, so A has no z row and B no z row; D̂·E = p; G·E = 1.
template <class T>
struct PrismaticRecord {
  T Axx, Axy, Ayy, Bxx, Bxy, Bxz, Byx, Byy, Byz;
  Symmetric3<T> J;
  T lx, ly;  // D̂
  Vector3<T> h;
  T glx, gly;  // G
  Vector3<T> gh;
  T u0, inverse_mass;
  Vector3<T> mc;
};

/// Transform of reduced quantities across a prismatic joint (16), (17): rotation by θ0, rotation by the placement, and a single
/// shift that combines the placement's offset and the joint's displacement.
template <class T, bool Aligned>
struct PrismaticTransform {
  const LinkConstants& link;
  Vector3<T> r;

  MOMENTREE_INLINE PrismaticTransform(const LinkConstants& k, const T& d) : link(k) {
    const double across = Aligned ? 1 : k.cos_b;
    r = {T(k.r.x), k.r.y - (across * k.sin_a) * d, k.r.z + k.cos_a * d};
    if constexpr (!Aligned) r.x = k.r.x + (k.sin_b * k.sin_a) * d;
  }
  template <class V>
  MOMENTREE_INLINE void rotate_inboard(V& a) const {
    rotate_z(a, link.cos_0, link.sin_0);
    rotate_x(a, link.cos_a, link.sin_a);
    if constexpr (!Aligned) rotate_z(a, link.cos_b, link.sin_b);
  }
  MOMENTREE_INLINE void inboard(Force<T>& P) const {
    rotate_inboard(P.l), rotate_inboard(P.h);
    shift(P, r);
  }
  MOMENTREE_INLINE void inboard(Vector3<T>& mc, double mass) const {
    rotate_inboard(mc);
    mc += mass * r;
  }
  /// A reduced mass, of which only A.xx, A.xy, A.yy, the upper rows of B, and J are nonzero.
  MOMENTREE_INLINE void inboard(SpatialMass<T>& M) const {
    const PlaneRotation<double> by(link.cos_0, link.sin_0);
    rotate_block(M.A.xx, M.A.xy, M.A.yy, by);
    rotate_block(M.B.xx, M.B.xy, M.B.yx, M.B.yy, by);
    rotate(M.B.xz, M.B.yz, link.cos_0, link.sin_0);
    rotate_block(M.J.xx, M.J.xy, M.J.yy, by);
    rotate(M.J.xz, M.J.yz, link.cos_0, link.sin_0);

    const double c = link.cos_a, s = link.sin_a;
    const T yy = M.A.yy, xy = M.A.xy;
    M.A.yy = (c * c) * yy, M.A.yz = link.cs_a * yy, M.A.zz = link.ss_a * yy, M.A.xy = c * xy, M.A.xz = s * xy;
    rotate(M.B.xy, M.B.xz, c, s);
    rotate(M.B.yy, M.B.yz, c, s);
    M.B.zx = s * M.B.yx, M.B.zy = s * M.B.yy, M.B.zz = s * M.B.yz;
    M.B.yx = c * M.B.yx, M.B.yy = c * M.B.yy, M.B.yz = c * M.B.yz;
    rotate_block(M.J.yy, M.J.yz, M.J.zz, PlaneRotation<double>::of_products(link.cs_a, link.ss_a));
    rotate(M.J.xy, M.J.xz, c, s);
    if constexpr (!Aligned) rotate_z(M, link.cos_b, link.sin_b);
    shift(M, r);
  }
  MOMENTREE_INLINE void place(Matrix3<T>& R, Vector3<T>& at) const {
    rotate_inboard(R), rotate_inboard(at);
    at += r;
  }
  MOMENTREE_INLINE void outboard(Vector3<T>& a) const {
    placement_outboard<Aligned>(link, a);
    rotate_z(a, link.cos_0, -link.sin_0);
  }
  MOMENTREE_INLINE void outboard(Motion<T>& a) const {
    shift_outboard(a, r);
    outboard(a.v), outboard(a.w);
  }
};

/// Without armature, one row of the reduced mass is zero.
struct PrismaticKernels : PrismaticKernelsBase<PrismaticKernels> {
  template <class T>
  using Record = PrismaticRecord<T>;

  template <bool Aligned, class T>
  MOMENTREE_INLINE static PrismaticTransform<T, Aligned> joint_transform(const LinkConstants& k, const JointState<T>& j,
                                                                         const auto&) {
    return {k, j.q[0]};
  }
  template <bool Aligned, class T>
  MOMENTREE_INLINE static PrismaticTransform<T, Aligned> cached_transform(const LinkConstants& k, const JointState<T>& j,
                                                                          const auto&) {
    return {k, j.q[0]};
  }
  /// (24)–(26)
  template <class T>
  MOMENTREE_INLINE static void reduce(const LinkConstants&, const JointState<T>&, const T* p, const double*, SpatialMass<T>& M,
                                      Force<T>& D, Record<T>& w) {
    const T ex = M.A.xz, ey = M.A.yz, hx = M.B.zx, hy = M.B.zy, hz = M.B.zz;  // Mb E without the entry that is Mj
    const T inverse = 1.0 / M.A.zz, r = p[0] - D.l.z, o(0);
    const T gx = inverse * ex, gy = inverse * ey, kx = inverse * hx, ky = inverse * hy, kz = inverse * hz;
    M.A = {M.A.xx - gx * ex, M.A.yy - gy * ey, o, M.A.xy - gx * ey, o, o};
    M.B = {M.B.xx - gx * hx, M.B.xy - gx * hy, M.B.xz - gx * hz, M.B.yx - gy * hx, M.B.yy - gy * hy, M.B.yz - gy * hz, o, o, o};
    M.J = {M.J.xx - kx * hx, M.J.yy - ky * hy, M.J.zz - kz * hz, M.J.xy - kx * hy, M.J.xz - kx * hz, M.J.yz - ky * hz};
    D.l = {D.l.x + r * gx, D.l.y + r * gy, p[0]};
    D.h = {D.h.x + r * kx, D.h.y + r * ky, D.h.z + r * kz};
    w.Axx = M.A.xx, w.Axy = M.A.xy, w.Ayy = M.A.yy;
    w.Bxx = M.B.xx, w.Bxy = M.B.xy, w.Bxz = M.B.xz, w.Byx = M.B.yx, w.Byy = M.B.yy, w.Byz = M.B.yz;
    w.J = M.J;
    w.lx = D.l.x, w.ly = D.l.y, w.h = D.h;
    w.glx = gx, w.gly = gy, w.gh = {kx, ky, kz};
    w.u0 = inverse * r, w.inverse_mass = inverse;
  }
  /// (27)
  template <class T>
  MOMENTREE_INLINE static void joint_velocity(const Record<T>& w, const Motion<T>& in, T* u) {
    u[0] = w.u0 - along(w, in);
  }
  /// (21)
  template <class T>
  MOMENTREE_INLINE static Force<T> articulated_momentum(const Record<T>& w, const T* p, const Motion<T>& in) {
    Force<T> P{{w.lx, w.ly, p[0]}, w.h};
    add_reduced(w, in, P);
    return P;
  }
  /// (17)
  template <class T>
  MOMENTREE_INLINE static Motion<T> spatial_velocity(const LinkConstants&, const JointState<T>&, const Motion<T>& in,
                                                     const T* u) {
    return {{in.v.x, in.v.y, in.v.z + u[0]}, in.w};
  }
  /// (20)
  template <class T>
  MOMENTREE_INLINE static void momentum_rate(const LinkConstants&, const JointState<T>&, const T*, const Force<T>&,
                                             const Force<T>& wrench, T* pdot) {
    pdot[0] = wrench.l.z;
  }
  /// (39): Ω × E u.
  template <class T>
  MOMENTREE_INLINE static Motion<T> acceleration_bias(const LinkConstants&, const JointState<T>&, const Motion<T>& a,
                                                      const T* u) {
    return {{u[0] * a.w.y, -(u[0] * a.w.x), T(0)}, {T(0), T(0), T(0)}};
  }
  /// (51): the component along the axis becomes τ, just as that of D̂ becomes p.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const LinkConstants&, const JointState<T>&, const Record<T>& w, const T* tau,
                                             Force<T>& W, T* udot) {
    const T r = tau[0] - W.l.z;
    W.l = {W.l.x + r * w.glx, W.l.y + r * w.gly, tau[0]};
    W.h += r * w.gh;
    udot[0] = w.inverse_mass * r;
  }
  template <class T>
  MOMENTREE_INLINE static void add_reduced_bias(const Record<T>& w, const Motion<T>& bias, Force<T>& F) {
    const Vector3<T>& v = bias.v;
    F.l.x = F.l.x + (w.Axx * v.x + w.Axy * v.y);
    F.l.y = F.l.y + (w.Axy * v.x + w.Ayy * v.y);
    F.h.x = F.h.x + (w.Bxx * v.x + w.Byx * v.y);
    F.h.y = F.h.y + (w.Bxy * v.x + w.Byy * v.y);
    F.h.z = F.h.z + (w.Bxz * v.x + w.Byz * v.y);
  }
  /// (47)
  template <class T>
  MOMENTREE_INLINE static void joint_acceleration(const Record<T>& w, const Motion<T>& in, T* udot) {
    udot[0] = udot[0] - along(w, in);
  }
  template <class T>
  MOMENTREE_INLINE static void add_reduced(const Record<T>& w, const Motion<T>& a, Force<T>& F) {
    const Vector3<T>&v = a.v, &o = a.w;
    F.l.x = F.l.x + ((w.Axx * v.x + w.Bxx * o.x) + (w.Axy * v.y + w.Bxy * o.y) + w.Bxz * o.z);
    F.l.y = F.l.y + ((w.Axy * v.x + w.Byx * o.x) + (w.Ayy * v.y + w.Byy * o.y) + w.Byz * o.z);
    F.h.x = F.h.x + ((w.Bxx * v.x + w.J.xx * o.x) + (w.Byx * v.y + w.J.xy * o.y) + w.J.xz * o.z);
    F.h.y = F.h.y + ((w.Bxy * v.x + w.J.xy * o.x) + (w.Byy * v.y + w.J.yy * o.y) + w.J.yz * o.z);
    F.h.z = F.h.z + ((w.Bxz * v.x + w.J.xz * o.x) + (w.Byz * v.y + w.J.yz * o.y) + w.J.zz * o.z);
  }

 private:
  /// Gᵀ a.
  template <class T>
  MOMENTREE_INLINE static T along(const Record<T>& w, const Motion<T>& a) {
    return (w.glx * a.v.x + w.gh.x * a.w.x) + (w.gly * a.v.y + w.gh.y * a.w.y) + (a.v.z + w.gh.z * a.w.z);
  }
};

}  // namespace momentree
#endif
