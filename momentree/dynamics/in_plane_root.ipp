#pragma once
// The root of a plane mechanism. The plane's axes are those of the root joint before its rotation; on a free root, those of the
// first joint on the root before its rotation, so that they move with the root. Included only by in_plane.ipp.
#include <array>
#include <cmath>

#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/joint_transforms.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/math/joint_mass.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

enum class PlaneRoot { revolute, planar, free };

/// Components in a link's parent axes to components before the joint's own rotation.
template <class T>
MOMENTREE_INLINE Vector3<T> in_axes_of_plane(const LinkConstants& k, Vector3<T> a) {
  placement_outboard<false>(k, a);
  return a;
}
/// The inverse.
template <class T>
MOMENTREE_INLINE Vector3<T> from_axes_of_plane(const LinkConstants& k, Vector3<T> a) {
  rotate_x(a, k.cos_a, k.sin_a);
  rotate_z(a, k.cos_b, k.sin_b);
  return a;
}
/// Gravity in the axes of a plane that a revolute root joint holds.
inline Vec3 gravity_in_plane(UncheckedTree tree, int root) { return in_axes_of_plane(tree.link(root), tree.gravity()); }

/// The steps for a root that floats. `run`: the root's.
template <class T>
struct InPlaneRoot {
  UncheckedTree tree;
  const T* q;
  const T* p;
  Workspace<T>& workspace;

  /// Prepares the evaluation of a mechanism in its plane. False if its root leaves the plane.
  template <PlaneRoot Root>
  bool enter(const KernelRun& run) const {
    const int root = tree.order()[static_cast<std::size_t>(run.begin)];
    Vec3 g = gravity_at_root(root);
    if constexpr (Root == PlaneRoot::free) {
      g = gravity_on_root(run);
      if (!moves_in_plane(run, g)) return false;
    }
    auto& w = record(root);
    w.gravity_x = T(g.x), w.gravity_y = T(g.y);
    return true;
  }

  /// After an evaluation by the spatial kernels: if a free root moves in the plane, removes the round-off by which it would
  /// leave.
  void stay(const KernelRun& run) const {
    if (!moves_in_plane(run, gravity_on_root(run))) return;
    const LinkConstants& plane = first_link(run);
    T* const pdot = workspace.pdot.get() + tree.first_p(tree.order()[static_cast<std::size_t>(run.begin)]);
    const Vector3<T> f = in_axes_of_plane(plane, Vector3<T>{pdot[0], pdot[1], pdot[2]});
    const Vector3<T> t = in_axes_of_plane(plane, Vector3<T>{pdot[3], pdot[4], pdot[5]});
    put(plane, f.x, f.y, t.z, pdot);
  }

  /// (22)–(24); `a`: the contributions of its children. The ground needs no output.
  template <bool Gravity, PlaneRoot Root>
  void inboard(const KernelRun& run, const InPlaneInboard<T>& a) const {
    const int root = tree.order()[static_cast<std::size_t>(run.begin)];
    const LinkConstants &k = tree.link(root), &plane = first_link(run);
    auto& w = record(root);
    const Vec3 mc = in_axes_of_plane(plane, k.body.mc), n = from_axes_of_plane(plane, Vec3{0, 0, 1});
    const double about_normal =
        n.x * n.x * k.body.J.xx + n.y * n.y * k.body.J.yy + n.z * n.z * k.body.J.zz;  // n: one of the axes
    T mx(mc.x), my(mc.y);
    if constexpr (Root == PlaneRoot::planar)
      rotate(mx, my, workspace.cos[tree.first_angle(root)], workspace.sin[tree.first_angle(root)]);
    JointMass<T, 3> M;
    M(0, 0) = a.axx + k.body.m, M(1, 0) = a.axy, M(1, 1) = a.ayy + k.body.m;
    M(2, 0) = a.bx - my, M(2, 1) = a.by + mx, M(2, 2) = a.J + about_normal;
    M.factorise();
    const Vector3<T> P = momentum<Root>(run);
    std::array<T, 3> u{P.x - a.lx, P.y - a.ly, P.z - a.h};
    M.solve(u);
    w.vx = u[0], w.vy = u[1], w.w = u[2];
    if constexpr (Gravity) w.mx = a.mx + mx, w.my = a.my + my;
  }

  /// (20); p is the whole articulated momentum. Returns gravity, and the root's velocity in `a`.
  template <bool Gravity, PlaneRoot Root>
  Vector3<T> outboard(const KernelRun& run, InPlaneOutboard<T>& a) const {
    const int root = tree.order()[static_cast<std::size_t>(run.begin)], at = tree.first_p(root);
    const LinkConstants& plane = first_link(run);
    T *const u = workspace.v.get() + at, *const pdot = workspace.pdot.get() + at,
             *const qdot = workspace.qdot.get() + tree.first_q(root);
    const auto& w = record(root);
    a = {w.vx, w.vy, w.w};
    const Vector3<T> P = momentum<Root>(run);
    T fx(0), fy(0), t = a.vy * P.x - a.vx * P.y;
    if constexpr (Gravity) {
      const double mass = tree.subtree_mass(root);
      fx = mass * w.gravity_x, fy = mass * w.gravity_y;
      t = t + (w.mx * w.gravity_y - w.my * w.gravity_x);
    }
    if constexpr (Root == PlaneRoot::planar) {  // in the plane's axes, which do not turn
      u[0] = qdot[0] = a.vx, u[1] = qdot[1] = a.vy, u[2] = qdot[2] = a.w;
      pdot[0] = fx, pdot[1] = fy, pdot[2] = t;
    } else {
      const Vec3 c = offset(run);  // u and p belong to the joint's own origin
      put(plane, a.vx + a.w * c.y, a.vy - a.w * c.x, a.w, u);
      fx = fx + a.w * P.y, fy = fy - a.w * P.x;
      put(plane, fx, fy, t + (c.x * fy - c.y * fx), pdot);
      FreeKernels::coordinate_rate<T>(q + tree.first_q(root), u, qdot);
    }
    return {w.gravity_x, w.gravity_y, T(0)};
  }

 private:
  /// Gravity in the axes of the root joint before its motion.
  Vec3 gravity_at_root(int root) const {
    const LinkConstants& k = tree.link(root);
    Vec3 g = gravity_in_plane(tree, root);
    rotate_z(g, k.cos_0, -k.sin_0);
    return g;
  }
  /// Gravity in the axes of a plane that moves with a free root.
  Vec3 gravity_on_root(const KernelRun& run) const {
    const int root = tree.order()[static_cast<std::size_t>(run.begin)];
    const T* const x = q + tree.first_q(root);
    const Mat3 R = rotation_matrix(Quat{x[3], x[4], x[5], x[6]});
    return in_axes_of_plane(first_link(run), transpose_times(R, gravity_at_root(root)));
  }
  /// True if a free root moves in the plane: its momenta out of the plane are exactly zero. They remain so if gravity is in the
  /// plane, up to round-off, because its direction is found from a rounded quaternion.
  bool moves_in_plane(const KernelRun& run, const Vec3& g) const {
    constexpr double round_off = 1e-14;
    const LinkConstants& plane = first_link(run);
    const T* const m = p + tree.first_p(tree.order()[static_cast<std::size_t>(run.begin)]);
    const Vector3<T> l = in_axes_of_plane(plane, Vector3<T>{m[0], m[1], m[2]});
    const Vector3<T> h = in_axes_of_plane(plane, Vector3<T>{m[3], m[4], m[5]});
    return l.z == 0 && h.x == 0 && h.y == 0 && std::fabs(g.z) <= round_off * (std::fabs(g.x) + std::fabs(g.y));
  }
  /// The momentum in the plane's axes: two linear components and the angular one.
  template <PlaneRoot Root>
  Vector3<T> momentum(const KernelRun& run) const {
    const T* const m = p + tree.first_p(tree.order()[static_cast<std::size_t>(run.begin)]);
    if constexpr (Root == PlaneRoot::planar) return {m[0], m[1], m[2]};
    const LinkConstants& plane = first_link(run);
    const Vector3<T> l = in_axes_of_plane(plane, Vector3<T>{m[0], m[1], m[2]});
    const Vector3<T> h = in_axes_of_plane(plane, Vector3<T>{m[3], m[4], m[5]});
    const Vec3 c = offset(run);
    return {l.x, l.y, h.z - (c.x * l.y - c.y * l.x)};
  }
  /// From the origin of a free root joint to that of the kernel frame, in the plane's axes.
  Vec3 offset(const KernelRun& run) const {
    const LinkConstants& k = tree.link(tree.order()[static_cast<std::size_t>(run.begin)]);
    return in_axes_of_plane(first_link(run), FreeKernels::offset<double>(k));
  }
  /// Writes a velocity, momentum or rate in the plane in the axes of a free root.
  static void put(const LinkConstants& plane, const T& x, const T& y, const T& about, T* to) {
    const T o(0);
    const Vector3<T> l = from_axes_of_plane(plane, Vector3<T>{x, y, o}), h = from_axes_of_plane(plane, Vector3<T>{o, o, about});
    to[0] = l.x, to[1] = l.y, to[2] = l.z, to[3] = h.x, to[4] = h.y, to[5] = h.z;
  }
  const LinkConstants& first_link(const KernelRun& run) const {
    return tree.link(tree.order()[static_cast<std::size_t>(run.begin + 1)]);
  }
  InPlaneRootRecord<T>& record(int root) const { return workspace.template record<InPlaneRootKernels>(tree, root); }
};

}  // namespace momentree
