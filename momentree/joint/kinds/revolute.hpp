#pragma once
// Revolute (pin): one angle about z. E = (0; e_z), constant. The kind of the paper's tables, so the one with most structure.
#include <momentree/joint/joint.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/joint/screw_kernels.hpp>

namespace momentree {

/// What any pin needs; with the generic reduction it serves pins with a rotor (armature), whose reduced mass has no zeros.
template <class K>
struct PinKernels : ScrewKernels<K, 1, 1> {
  static constexpr std::array<int, 1> angles{0};
  template <class T>
  MOMENTREE_INLINE static Screw<T> screw(const Link&, const JointState<T>& j) {
    return {j.c[0], j.s[0], T(0)};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 1> columns(const Link&, const JointState<T>&) {
    return {{{{T(0), T(0), T(0)}, {T(0), T(0), T(1)}}}};
  }
  static bool coordinates(const JointSpec& joint, const Pose& motion, double hint, double* q) {
    return coordinates::negligible(motion.position) && coordinates::about_axis(joint.axis, motion.rotation, hint, q[0]);
  }
  template <class T>
  MOMENTREE_INLINE static Motion<T> acceleration_bias(const Link&, const JointState<T>&, const Motion<T>& a, const T* u) {
    return {{u[0] * a.v.y, -(u[0] * a.v.x), T(0)}, {u[0] * a.w.y, -(u[0] * a.w.x), T(0)}};
  }
};
struct PinWithRotor : PinKernels<PinWithRotor> {};

/// What reduction about z leaves: M̂ E = 0, so B has no z column and J no z row; D̂·E = p; G·E = 1.
template <class T>
struct RevoluteRecord {
  Symmetric3<T> A;
  T Bxx, Bxy, Byx, Byy, Bzx, Bzy, Jxx, Jxy, Jyy;
  Vector3<T> l;  // D̂
  T hx, hy;
  Vector3<T> gl;  // G
  T ghx, ghy;
  T u0, inverse_mass;
  Vector3<T> mc;
};

/// (16) for what a pin without rotor has reduced: the zero rows stay zero while turning about z.
template <class T, bool Aligned>
struct RevoluteCrossing : ScrewCrossing<T, Aligned> {
  using ScrewCrossing<T, Aligned>::inboard;
  MOMENTREE_INLINE void inboard(SpatialMass<T>& M) const {
    const Link& k = this->link;
    const T cq = this->c, sq = this->s, cs = cq * sq, ss = sq * sq;
    turn_block(M.A.xx, M.A.xy, M.A.yy, cs, ss);
    turn(M.A.xz, M.A.yz, cq, sq);
    turn_block(M.B.xx, M.B.xy, M.B.yx, M.B.yy, cs, ss);
    turn(M.B.zx, M.B.zy, cq, sq);
    turn_block(M.J.xx, M.J.xy, M.J.yy, cs, ss);
    // About x, by the constant α; what was zero is filled.
    const double ca = k.cos_a, sa = k.sin_a, csa = ca * sa, ssa = sa * sa;
    turn_block(M.A.yy, M.A.yz, M.A.zz, csa, ssa);
    turn(M.A.xy, M.A.xz, ca, sa);
    const T a = ca * M.B.yy - sa * M.B.zy, b = sa * M.B.yy + ca * M.B.zy;  // rows y, z of the y column
    M.B.yy = ca * a, M.B.yz = sa * a, M.B.zy = ca * b, M.B.zz = sa * b;
    M.B.xz = sa * M.B.xy;
    M.B.xy = ca * M.B.xy;
    turn(M.B.yx, M.B.zx, ca, sa);
    M.J.zz = ssa * M.J.yy;
    M.J.yz = csa * M.J.yy;
    M.J.yy = M.J.yy - M.J.zz;
    M.J.xz = sa * M.J.xy;
    M.J.xy = ca * M.J.xy;
    if constexpr (!Aligned) turn_z(M, k.cos_b, k.sin_b);
    shift(M, k.r);
  }
};

struct RevoluteKernels : PinKernels<RevoluteKernels> {
  template <class T>
  using Record = RevoluteRecord<T>;
  template <class T, bool Aligned>
  using Crossing = RevoluteCrossing<T, Aligned>;

  /// (24)–(26): Mb E is the third column of the right half.
  template <class T>
  MOMENTREE_INLINE static void reduce(const Link&, const JointState<T>&, const T* p, const double*, SpatialMass<T>& M,
                                      Force<T>& D, Record<T>& w) {
    const Vector3<T> el{M.B.xz, M.B.yz, M.B.zz};
    const T ex = M.J.xz, ey = M.J.yz;
    const T inverse = T(1) / M.J.zz;  // (24)
    const Vector3<T> gl = inverse * el;
    const T gx = inverse * ex, gy = inverse * ey;
    M.A.xx -= el.x * gl.x, M.A.yy -= el.y * gl.y, M.A.zz -= el.z * gl.z;  // (25)
    M.A.xy -= el.x * gl.y, M.A.xz -= el.x * gl.z, M.A.yz -= el.y * gl.z;
    M.B.xx -= ex * gl.x, M.B.yx -= ex * gl.y, M.B.zx -= ex * gl.z;
    M.B.xy -= ey * gl.x, M.B.yy -= ey * gl.y, M.B.zy -= ey * gl.z;
    M.B.xz = T(0), M.B.yz = T(0), M.B.zz = T(0);
    M.J.xx -= ex * gx, M.J.xy -= ex * gy, M.J.yy -= ey * gy;
    M.J.xz = T(0), M.J.yz = T(0), M.J.zz = T(0);
    const T u = p[0] - D.h.z;
    D.l += u * gl;  // (26)
    D.h = {D.h.x + gx * u, D.h.y + gy * u, p[0]};
    w.A = M.A;
    w.Bxx = M.B.xx, w.Bxy = M.B.xy, w.Byx = M.B.yx, w.Byy = M.B.yy, w.Bzx = M.B.zx, w.Bzy = M.B.zy;
    w.Jxx = M.J.xx, w.Jxy = M.J.xy, w.Jyy = M.J.yy;
    w.l = D.l, w.hx = D.h.x, w.hy = D.h.y;
    w.gl = gl, w.ghx = gx, w.ghy = gy;
    w.u0 = inverse * u, w.inverse_mass = inverse;
  }
  /// (27)
  template <class T>
  MOMENTREE_INLINE static void joint_velocity(const Record<T>& w, const Motion<T>& in, T* u) {
    u[0] = w.u0 - ((w.gl.x * in.v.x + w.ghx * in.w.x) + (w.gl.y * in.v.y + w.ghy * in.w.y) + w.gl.z * in.v.z) - in.w.z;
  }
  /// (21)
  template <class T>
  MOMENTREE_INLINE static Force<T> articulated_momentum(const Record<T>& w, const T* p, const Motion<T>& in) {
    const Vector3<T>&v = in.v, &o = in.w;
    return {{(w.A.xx * v.x + w.Bxx * o.x) + (w.A.xy * v.y + w.Bxy * o.y) + (w.A.xz * v.z + w.l.x),
             (w.A.xy * v.x + w.Byx * o.x) + (w.A.yy * v.y + w.Byy * o.y) + (w.A.yz * v.z + w.l.y),
             (w.A.xz * v.x + w.Bzx * o.x) + (w.A.yz * v.y + w.Bzy * o.y) + (w.A.zz * v.z + w.l.z)},
            {(w.Bxx * v.x + w.Jxx * o.x) + (w.Byx * v.y + w.Jxy * o.y) + (w.Bzx * v.z + w.hx),
             (w.Bxy * v.x + w.Jxy * o.x) + (w.Byy * v.y + w.Jyy * o.y) + (w.Bzy * v.z + w.hy), p[0]}};
  }
  /// (17)
  template <class T>
  MOMENTREE_INLINE static Motion<T> spatial_velocity(const Link&, const JointState<T>&, const Motion<T>& in, const T* u) {
    return {in.v, {in.w.x, in.w.y, in.w.z + u[0]}};
  }
  /// (51): the last component becomes τ, as that of D̂ becomes p.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const Link&, const JointState<T>&, const Record<T>& w, const T* tau, Force<T>& W,
                                             T* udot) {
    const T r = tau[0] - W.h.z;
    W.l += r * w.gl;
    W.h = {W.h.x + w.ghx * r, W.h.y + w.ghy * r, tau[0]};
    udot[0] = w.inverse_mass * r;
  }
  template <class T>
  MOMENTREE_INLINE static void add_reduced_bias(const Record<T>& w, const Motion<T>& bias, Force<T>& F) {
    const Vector3<T>&v = bias.v, &o = bias.w;
    F.l.x = F.l.x + ((w.A.xx * v.x + w.Bxx * o.x) + (w.A.xy * v.y + w.Bxy * o.y));
    F.l.y = F.l.y + ((w.A.xy * v.x + w.Byx * o.x) + (w.A.yy * v.y + w.Byy * o.y));
    F.l.z = F.l.z + ((w.A.xz * v.x + w.Bzx * o.x) + (w.A.yz * v.y + w.Bzy * o.y));
    F.h.x = F.h.x + ((w.Bxx * v.x + w.Jxx * o.x) + (w.Byx * v.y + w.Jxy * o.y));
    F.h.y = F.h.y + ((w.Bxy * v.x + w.Jxy * o.x) + (w.Byy * v.y + w.Jyy * o.y));
  }
  /// (47)
  template <class T>
  MOMENTREE_INLINE static void joint_acceleration(const Record<T>& w, const Motion<T>& in, T* udot) {
    udot[0] = udot[0] - ((w.gl.x * in.v.x + w.ghx * in.w.x) + (w.gl.y * in.v.y + w.ghy * in.w.y) + w.gl.z * in.v.z) - in.w.z;
  }
  template <class T>
  MOMENTREE_INLINE static void add_reduced(const Record<T>& w, const Motion<T>& a, Force<T>& F) {
    const Vector3<T>&v = a.v, &o = a.w;
    F.l.x = F.l.x + ((w.A.xx * v.x + w.Bxx * o.x) + (w.A.xy * v.y + w.Bxy * o.y) + w.A.xz * v.z);
    F.l.y = F.l.y + ((w.A.xy * v.x + w.Byx * o.x) + (w.A.yy * v.y + w.Byy * o.y) + w.A.yz * v.z);
    F.l.z = F.l.z + ((w.A.xz * v.x + w.Bzx * o.x) + (w.A.yz * v.y + w.Bzy * o.y) + w.A.zz * v.z);
    F.h.x = F.h.x + ((w.Bxx * v.x + w.Jxx * o.x) + (w.Byx * v.y + w.Jxy * o.y) + w.Bzx * v.z);
    F.h.y = F.h.y + ((w.Bxy * v.x + w.Jxy * o.x) + (w.Byy * v.y + w.Jyy * o.y) + w.Bzy * v.z);
  }
};

/// A pin: turns about `axis` through the joint's origin.
struct Revolute {
  static constexpr Kind kind = Kind::revolute;
  static constexpr KindInfo info{Kind::revolute, "revolute", 1, 1, true, false, false, "r", "r"};
  using Kernels = RevoluteKernels;
  using ArmatureKernels = PinWithRotor;

  Vec3 axis{0, 0, 1};
  Values damping{}, stiffness{}, rest{}, armature{}, effort{};
  JointLimits limits{};
  JointFriction friction{};
  std::shared_ptr<const JointDrive> drive{};
  JointStrength strength{};
};

}  // namespace momentree
