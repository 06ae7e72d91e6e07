#pragma once
// The quantities that the inward and the outward pass hand from body to body.
#include <momentree/base/inline.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// Contribution of one child to its parent: reduced mass and remainder momentum (25), (26), and the first moment of the subtree
/// (kg m) for gravity.
template <class T>
struct Inboard {
  SpatialMass<T> M;
  Force<T> D;
  Vector3<T> mc;
};
template <class T>
MOMENTREE_INLINE void add_without_moments(const Inboard<T>& a, Inboard<T>& to) {
  to.M += a.M;
  to.D += a.D;
}
template <class T>
MOMENTREE_INLINE void operator+=(Inboard<T>& a, const Inboard<T>& b) {
  add_without_moments(b, a);
  a.mc += b.mc;
}
/// Stores a contribution without its first moments, number by number, as spatial quantities are.
template <class T>
MOMENTREE_INLINE void put_without_moments(const Inboard<T>& a, Inboard<T>& to) {
  const auto symmetric = [](const Symmetric3<T>& m, Symmetric3<T>& x) MOMENTREE_INLINE_LAMBDA {
    x.xx = m.xx, x.yy = m.yy, x.zz = m.zz, x.xy = m.xy, x.xz = m.xz, x.yz = m.yz;
  };
  const Matrix3<T>& B = a.M.B;
  Matrix3<T>& x = to.M.B;
  symmetric(a.M.A, to.M.A);
  x.xx = B.xx, x.xy = B.xy, x.xz = B.xz, x.yx = B.yx, x.yy = B.yy, x.yz = B.yz, x.zx = B.zx, x.zy = B.zy, x.zz = B.zz;
  symmetric(a.M.J, to.M.J);
  put(a.D, to.D);
}
template <class T>
MOMENTREE_INLINE void put(const Inboard<T>& a, Inboard<T>& to) {
  put_without_moments(a, to);
  to.mc.x = a.mc.x, to.mc.y = a.mc.y, to.mc.z = a.mc.z;
}
/// Input of a child from its parent: velocity, and gravity in the parent's axes (m/s²).
template <class T>
struct Outboard {
  Motion<T> velocity;
  Vector3<T> gravity;
};
template <class T>
MOMENTREE_INLINE void put(const Outboard<T>& a, Outboard<T>& to) {
  put(a.velocity, to.velocity);
  to.gravity.x = a.gravity.x, to.gravity.y = a.gravity.y, to.gravity.z = a.gravity.z;
}

/// What the velocities of a body contribute to the equations of accelerations, in its kernel frame: its gyroscopic wrench less
/// the external one, and the acceleration of the body that no acceleration of a joint causes, Ω × E u + Ė u (39).
template <class T>
struct BodyBias {
  Force<T> wrench;
  Motion<T> acceleration;
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
/// The same in the equations of accelerations. `ax`, `ay`: bias; `w`: absolute angular velocity.
template <class T>
struct InPlaneRateRecord {
  T gx, gy, u0, rx, ry, ax, ay, w;
};
struct InPlaneRateKernels {
  template <class T>
  using Record = InPlaneRateRecord<T>;
};
}  // namespace momentree
