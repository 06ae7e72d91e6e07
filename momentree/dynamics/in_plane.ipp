#pragma once
// Plane mechanisms: grounded trees of revolute joints with parallel axes, and such trees on a root with a planar or a free joint.
// A velocity has only three components, and in the plane's axes with absolute angles nothing is rotated from body to body.
// Included only by forward.ipp.
#include <momentree/dynamics/in_plane_root.ipp>
#include <momentree/dynamics/sweep_buffers.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/kinds.hpp>

namespace momentree {

/// Turns the joint angles in `angle` into absolute body angles, or on a free root into angles relative to it. A first child takes
/// its parent's from a local variable, because reading it back from memory would stall.
template <PlaneRoot Root, class T>
void add_up_angles(UncheckedTree tree, const KernelRun& run, T* angle) noexcept {
  constexpr bool free = Root == PlaneRoot::free;
  const int begin = free ? run.plane + 1 : run.begin, end = Root == PlaneRoot::revolute ? run.end : run.plane_end;
  const int root = tree.order()[static_cast<std::size_t>(run.begin)];
  T sum(0);
  for (int i = begin; i < end; ++i) {
    const int b = tree.order()[static_cast<std::size_t>(i)];
    const unsigned flags = tree.node_flags()[static_cast<std::size_t>(i)];
    T& own = angle[tree.first_angle(b)];
    if (free ? tree.parent(b) == root : (flags & node::root) != 0)
      sum = own;
    else if ((flags & node::first_child) != 0)
      sum = own + sum;
    else
      sum = own + angle[tree.first_angle(tree.parent(b))];
    own = sum;
  }
}

/// Both passes over a mechanism. `run`: of a floating mechanism, that of its root.
template <class T>
struct InPlaneSweep {
  UncheckedTree tree;
  const T* q;
  const T* p;
  Workspace<T>& workspace;
  InPlaneRoot<T> floating{tree, q, p, workspace};
  SweepBuffers<InPlaneInboard<T>, InPlaneOutboard<T>> buffers{tree, workspace.in_plane_child_sums.get(),
                                                              workspace.in_plane_parent_states.get()};

  /// (22)–(26) and (16), everything about the body's joint, in the plane's axes.
  template <bool Gravity, PlaneRoot Root>
  void inboard(const KernelRun& run) const {
    const int* order = tree.order().data();
    const unsigned char* node_flags = tree.node_flags().data();
    const auto [begin, end] = revolutes<Root>(run);
    InPlaneRecord<T>* const records = &workspace.template record<InPlaneKernels>(tree, order[begin]);  // denser than revolute's
    InPlaneInboard<T> a{};
    for (int i = end - 1; i >= begin; --i) {
      const int b = order[i], outer = tree.parent(b);
      const unsigned flags = node_flags[i];
      const LinkConstants& k = tree.link(b);
      const int angle = tree.first_angle(b);
      const T c = workspace.cos[angle], s = workspace.sin[angle];
      InPlaneRecord<T>& w = records[i - begin];
      if ((flags & node::leaf) != 0) a = {};
      buffers.gather_children(b, flags, a);
      const T mx = k.body.mc.x * c - k.body.mc.y * s, my = k.body.mc.x * s + k.body.mc.y * c;
      const T bx = a.bx - my, by = a.by + mx, J = a.J + k.body.J.zz;  // (22), (23)
      const T axx = a.axx + k.body.m, ayy = a.ayy + k.body.m;
      if constexpr (Gravity) {
        a.mx = a.mx + mx, a.my = a.my + my;
        w.mx = a.mx, w.my = a.my;
      }
      const T inverse = T(1) / J, u = p[tree.first_p(b)] - a.h;  // (24)
      const T gx = bx * inverse, gy = by * inverse;
      w.axx = axx - bx * gx, w.axy = a.axy - bx * gy, w.ayy = ayy - by * gy;  // (25)
      w.lx = a.lx + gx * u, w.ly = a.ly + gy * u;                             // (26)
      w.gx = gx, w.gy = gy, w.u0 = inverse * u;
      if ((flags & node::root) != 0) continue;
      T rx, ry;
      bool on_free_root = false;
      if constexpr (Root == PlaneRoot::free) on_free_root = outer == order[run.begin];
      if (on_free_root) {
        const Vec3 r = in_axes_of_plane(k, k.r);
        rx = T(r.x), ry = T(r.y);
      } else {
        const T cp = workspace.cos[tree.first_angle(outer)], sp = workspace.sin[tree.first_angle(outer)];
        rx = k.r.x * cp - k.r.y * sp, ry = k.r.x * sp + k.r.y * cp;
      }
      w.rx = rx, w.ry = ry;
      a.axx = w.axx, a.axy = w.axy, a.ayy = w.ayy, a.lx = w.lx, a.ly = w.ly;
      a.bx = w.axy * rx - w.axx * ry, a.by = w.ayy * rx - w.axy * ry;  // (16)
      a.J = rx * a.by - ry * a.bx;
      a.h = p[tree.first_p(b)] + (rx * w.ly - ry * w.lx);
      if constexpr (Gravity) a.mx = a.mx + tree.subtree_mass(b) * rx, a.my = a.my + tree.subtree_mass(b) * ry;
      buffers.add_to_parent(b, flags, a);
    }
    if constexpr (Root != PlaneRoot::revolute) {
      buffers.gather_children(order[run.begin], node_flags[run.begin], a);
      floating.template inboard<Gravity, Root>(run, a);
    }
  }

  /// (17), (27), (21), (20).
  template <bool Gravity, PlaneRoot Root>
  void outboard(const KernelRun& run) const {
    const int* order = tree.order().data();
    const unsigned char* node_flags = tree.node_flags().data();
    const auto [begin, end] = revolutes<Root>(run);
    const InPlaneRecord<T>* const records = &workspace.template record<InPlaneKernels>(tree, order[begin]);
    InPlaneOutboard<T> a{};
    const auto gravity = [&] {
      if constexpr (Root == PlaneRoot::revolute)
        return gravity_in_plane(tree, order[run.begin]);
      else
        return floating.template outboard<Gravity, Root>(run, a);
    }();
    if (Root != PlaneRoot::revolute) buffers.store_for_children(order[run.begin], node_flags[run.begin], a);
    for (int i = begin; i < end; ++i) {
      const int b = order[i], at = tree.first_p(b);
      const unsigned flags = node_flags[i];
      const InPlaneRecord<T>& w = records[i - begin];
      buffers.load_parent(b, flags, {}, a);
      if ((flags & node::root) == 0) a.vx = a.vx - a.w * w.ry, a.vy = a.vy + a.w * w.rx;         // (17)
      const T total = w.u0 - (w.gx * a.vx + w.gy * a.vy);                                        // (27)
      const T lx = w.axx * a.vx + w.axy * a.vy + w.lx, ly = w.axy * a.vx + w.ayy * a.vy + w.ly;  // (21)
      T pdot = a.vy * lx - a.vx * ly;                                                            // (20)
      if constexpr (Gravity) pdot = pdot + (w.mx * gravity.y - w.my * gravity.x);
      const T u = total - a.w;
      workspace.v[at] = u, workspace.qdot[tree.first_q(b)] = u, workspace.pdot[at] = pdot;
      a.w = total;
      buffers.store_for_children(b, flags, a);
    }
  }

 private:
  struct Places {
    int begin, end;
  };
  /// The mechanism's revolute joints.
  template <PlaneRoot Root>
  static Places revolutes(const KernelRun& run) {
    if constexpr (Root == PlaneRoot::revolute) return {run.begin, run.end};
    return {run.begin + 1, run.plane_end};
  }
};

}  // namespace momentree
