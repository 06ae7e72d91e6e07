#pragma once
// Constants of a body's inboard link, in the frames that the kernels use, and the transforms across the link in both directions.
//
// The kernel frame of a body has its origin at the inboard joint (child side) and its z axis along the joint's axis if the kind
// has one. It is fixed in the body; `Tree` stores its pose in the user's frame of the body (KernelFrame).
#include <momentree/base/inline.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// The terms that a link's placement has; kernels omit the others. Found when a topology is compiled.
enum class PlacementShape : unsigned char {
  general,        ///< any rotation, any offset
  tilted,         ///< β = 0: the parent's x axis is perpendicular to both joint axes
  screw,          ///< in addition, the offset is r.x along that x axis and d along the joint's own axis (Denavit–Hartenberg)
  screw_a,        ///< d = 0
  screw_d,        ///< r.x = 0: the axes intersect
  right,          ///< α = 90°, both offsets
  right_a,        ///< α = 90°, d = 0
  right_d,        ///< α = 90°, r.x = 0
  right_meeting,  ///< α = 90°, no offset
  parallel,       ///< α = 0, both offsets
  parallel_a,     ///< α = 0, d = 0: a link in a plane
};

/// Placement of the joint in the parent's frame: R = Rz(β) Rx(α) Rz(θ0), origin at r (m); mass properties in the body's kernel
/// frame. Rotations about one axis at a time cost half of a general one, and β = 0 if the parent's x axis could be chosen for
/// this link. Links that are made and placed alike have equal constants, and a tree stores equal links once.
struct LinkConstants {
  double cos_a = 1, sin_a = 0;
  double cs_a = 0, ss_a = 0;  ///< cos α sin α, sin² α
  Vec3 r{};
  double d = 0;  ///< if the shape has it: r = r.x along the parent's x, plus d along the joint's axis
  double cos_b = 1, sin_b = 0;
  RigidMass body{};
  PlacementShape shape{};
  unsigned char locked = 0;  ///< a bit per DoF without a momentum of its own: frozen or driven
  unsigned char driven = 0;  ///< a bit per DoF among these whose rate is prescribed: p holds the rate
  double cos_0 = 1, sin_0 = 0;
  double angle_0 = 0;           ///< θ0
  double geometry[2] = {0, 0};  ///< helical: metres per radian; universal: x and z components of the first axis
};
/// True if the link needs no rotation about the parent's z axis (β = 0).
inline bool aligned(const LinkConstants& link) { return link.sin_b == 0 && link.cos_b == 1; }
/// Rz(β) Rx(α) Rz(θ0).
Mat3 placement_rotation(const LinkConstants& link);
/// Rz(β) Rx(α): for kinds that add θ0 to their own angle.
Mat3 tilt_rotation(const LinkConstants& link);

/// Contribution of one child to its parent: reduced mass and remainder momentum (25), (26), and the first moment of the subtree
/// (kg m) for gravity.
template <class T>
struct Inboard {
  SpatialMass<T> M;
  Force<T> D;
  Vector3<T> mc;
};
template <class T>
MOMENTREE_INLINE void operator+=(Inboard<T>& a, const Inboard<T>& b) {
  a.M += b.M;
  a.D += b.D;
  a.mc += b.mc;
}
/// Without gravity the revolute steps do not write first moments; a sum to which other contributions are added must still start
/// from zero.
template <bool Gravity, class T>
MOMENTREE_INLINE void begin_moments(Inboard<T>& sum) {
  if constexpr (!Gravity) sum.mc.x = T(0), sum.mc.y = T(0), sum.mc.z = T(0);
}
/// Input of a child from its parent: velocity, and gravity in the parent's axes (m/s²).
template <class T>
struct Outboard {
  Motion<T> velocity;
  Vector3<T> gravity;
};

/// Spatial velocity and articulated momentum of a body, in its kernel frame.
template <class T>
struct BodySweep {
  Motion<T> velocity;    ///< Ω
  Force<T> articulated;  ///< Pb (14)
};

/// Contribution of one child to its parent in a plane mechanism, in the plane's axes.
template <class T>
struct InPlaneInboard {
  T axx, axy, ayy, bx, by, J;  ///< l = A v + b ω, h = b·v + J ω
  T lx, ly, h;
  T mx, my;  ///< first moment of the subtree
};
template <class T>
MOMENTREE_INLINE void operator+=(InPlaneInboard<T>& a, const InPlaneInboard<T>& b) {
  a.axx = a.axx + b.axx, a.axy = a.axy + b.axy, a.ayy = a.ayy + b.ayy;
  a.bx = a.bx + b.bx, a.by = a.by + b.by, a.J = a.J + b.J;
  a.lx = a.lx + b.lx, a.ly = a.ly + b.ly, a.h = a.h + b.h;
  a.mx = a.mx + b.mx, a.my = a.my + b.my;
}
template <class T>
struct InPlaneOutboard {
  T vx, vy, w;
};
/// Quantities of a body in a plane mechanism that the inward pass stores; kept in the memory of a revolute record.
template <class T>
struct InPlaneRecord {
  T axx, axy, ayy, lx, ly, gx, gy, u0, rx, ry, mx, my;
};
struct InPlaneKernels {
  template <class T>
  using Record = InPlaneRecord<T>;
};

/// Across the placement, after the child's joint: rotation about x by α, about z by β unless the frames are aligned, shift by r.
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_inboard(const LinkConstants& k, Force<T>& P) {
  rotate_x(P.l, k.cos_a, k.sin_a);
  rotate_x(P.h, k.cos_a, k.sin_a);
  if constexpr (!Aligned) {
    rotate_z(P.l, k.cos_b, k.sin_b);
    rotate_z(P.h, k.cos_b, k.sin_b);
  }
  shift(P, k.r);
}
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_inboard(const LinkConstants& k, Vector3<T>& mc, double mass) {
  rotate_x(mc, k.cos_a, k.sin_a);
  if constexpr (!Aligned) rotate_z(mc, k.cos_b, k.sin_b);
  mc += Vector3<T>{T(mass * k.r.x), T(mass * k.r.y), T(mass * k.r.z)};
}
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_inboard(const LinkConstants& k, SpatialMass<T>& M) {
  rotate_x(M, k.cos_a, k.sin_a);
  if constexpr (!Aligned) rotate_z(M, k.cos_b, k.sin_b);
  shift(M, k.r);
}
/// The inverse for a direction: components in the parent's axes to components before the joint's own motion.
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_outboard(const LinkConstants& k, Vector3<T>& a) {
  if constexpr (!Aligned) rotate_z(a, k.cos_b, -k.sin_b);
  rotate_x(a, k.cos_a, -k.sin_a);
}
template <bool Aligned, class T>
MOMENTREE_INLINE void placement_outboard(const LinkConstants& k, Motion<T>& a) {
  shift_outboard(a, k.r);
  placement_outboard<Aligned>(k, a.v);
  placement_outboard<Aligned>(k, a.w);
}

/// R ← Rz R and R ← Rx R.
template <class T, class C>
MOMENTREE_INLINE void rotate_z(Matrix3<T>& R, const C& c, const C& s) {
  rotate(R.xx, R.yx, c, s);
  rotate(R.xy, R.yy, c, s);
  rotate(R.xz, R.yz, c, s);
}
template <class T, class C>
MOMENTREE_INLINE void rotate_x(Matrix3<T>& R, const C& c, const C& s) {
  rotate(R.yx, R.zx, c, s);
  rotate(R.yy, R.zy, c, s);
  rotate(R.yz, R.zz, c, s);
}

/// Transform of a joint that rotates about z and translates along z (revolute, prismatic, helical, cylindrical): c, s of the
/// angle including θ0, d the displacement (m). (16), (17).
template <class T, bool Aligned>
struct ScrewTransform {
  const LinkConstants& link;
  T c, s, d;

  MOMENTREE_INLINE void inboard(Force<T>& P) const {
    rotate_z(P.l, c, s);
    rotate_z(P.h, c, s);
    P.h.x = P.h.x - d * P.l.y;
    P.h.y = P.h.y + d * P.l.x;
    placement_inboard<Aligned>(link, P);
  }
  /// A first moment of a subtree with that mass.
  MOMENTREE_INLINE void inboard(Vector3<T>& mc, double mass) const {
    rotate_z(mc, c, s);
    mc.z = mc.z + d * T(mass);
    placement_inboard<Aligned>(link, mc, mass);
  }
  MOMENTREE_INLINE void inboard(SpatialMass<T>& M) const {
    rotate_z(M, c, s);
    shift(M, Vector3<T>{T(0), T(0), d});
    placement_inboard<Aligned>(link, M);
  }
  /// A frame with the pose (R, r) in the child's frame: its pose in the parent's.
  MOMENTREE_INLINE void place(Matrix3<T>& R, Vector3<T>& r) const {
    rotate_z(R, c, s);
    rotate_z(r, c, s);
    r.z = r.z + d;
    rotate_x(R, link.cos_a, link.sin_a);
    rotate_x(r, link.cos_a, link.sin_a);
    if constexpr (!Aligned) {
      rotate_z(R, link.cos_b, link.sin_b);
      rotate_z(r, link.cos_b, link.sin_b);
    }
    r += Vector3<T>{T(link.r.x), T(link.r.y), T(link.r.z)};
  }
  MOMENTREE_INLINE void outboard(Vector3<T>& a) const {
    placement_outboard<Aligned>(link, a);
    rotate_z(a, c, -s);
  }
  MOMENTREE_INLINE void outboard(Motion<T>& a) const {
    placement_outboard<Aligned>(link, a);
    a.v.x = a.v.x + d * a.w.y;
    a.v.y = a.v.y - d * a.w.x;
    rotate_z(a.v, c, -s);
    rotate_z(a.w, c, -s);
  }
};

/// Transform of any joint from its pose: R child axes to parent axes, r the child's origin, both including the placement.
template <class T>
struct DenseTransform {
  Matrix3<T> R;
  Vector3<T> r;

  MOMENTREE_INLINE void inboard(Force<T>& P) const {
    P = {R * P.l, R * P.h};
    shift(P, r);
  }
  MOMENTREE_INLINE void inboard(Vector3<T>& mc, double mass) const { mc = R * mc + T(mass) * r; }
  MOMENTREE_INLINE void inboard(SpatialMass<T>& M) const {
    rotate(M, R);
    shift(M, r);
  }
  MOMENTREE_INLINE void place(Matrix3<T>& axes, Vector3<T>& origin) const {
    axes = R * axes;
    origin = r + R * origin;
  }
  MOMENTREE_INLINE void outboard(Vector3<T>& a) const { a = transpose_times(R, a); }
  MOMENTREE_INLINE void outboard(Motion<T>& a) const {
    shift_outboard(a, r);
    a = {transpose_times(R, a.v), transpose_times(R, a.w)};
  }
};

}  // namespace momentree
