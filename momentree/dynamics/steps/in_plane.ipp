#pragma once
// Stages of plane mechanisms, grounded trees of revolute joints with parallel axes. The plane's axes are those of the root joint
// before its rotation. A velocity has only three components there, and with absolute angles nothing is rotated from body to body.
// Included only by forward.ipp.
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// Gravity in the axes of the plane of a root joint.
inline Vec3 gravity_in_plane(UncheckedTree tree, int root) {
  Vec3 g = tree.gravity();
  placement_outboard<false>(tree.link(root), g);
  return g;
}

/// Turns the joint angles in `angle` into absolute body angles. A first child takes its parent's from a local variable, because
/// reading it back from memory would stall.
template <class T>
void add_up_angles(UncheckedTree tree, const KernelRun& run, T* angle) noexcept {
  T sum(0);
  for (int i = run.begin; i < run.end; ++i) {
    const int b = tree.order()[static_cast<std::size_t>(i)];
    const unsigned flags = tree.tables().node_flags[static_cast<std::size_t>(i)];
    T& own = angle[tree.first_angle(b)];
    if ((flags & node::root) != 0)
      sum = own;
    else if ((flags & node::first_child) != 0)
      sum = own + sum;
    else
      sum = own + angle[tree.first_angle(tree.parent(b))];
    own = sum;
  }
}

/// Transfer of sums between bodies along the order: `In` are the sums of the inward pass, `Out` the values that the outward pass
/// hands to children. The first child of a body follows it directly, so that sums pass through memory only for later children.
template <class T>
struct InPlaneBuffers {
  using In = InPlaneInboard<T>;
  using Out = InPlaneOutboard<T>;

  UncheckedTree tree;
  In* child_sums;
  Out* parent_states;

  /// Calls step(place in the order, b, flags, a) for the bodies of a mechanism, inward. In: the sum of its children's
  /// contributions. Out: its own.
  template <class F>
  MOMENTREE_INLINE void inward(const KernelRun& run, F&& step) const {
    In a{};
    for (int i = run.end - 1; i >= run.begin; --i) {
      const int b = body_at(i);
      const unsigned flags = flags_at(i);
      if ((flags & node::leaf) != 0) a = {};
      gather_children(b, flags, a);
      step(i, b, flags, a);
      add_to_parent(b, flags, a);
    }
  }
  /// The same, outward. In: what its parent hands on, or `base` for roots. Out: what it hands on itself.
  template <class F>
  MOMENTREE_INLINE void outward(const KernelRun& run, const Out& base, F&& step) const {
    Out a{};
    for (int i = run.begin; i < run.end; ++i) {
      const int b = body_at(i);
      const unsigned flags = flags_at(i);
      load_parent(b, flags, base, a);
      step(i, b, flags, a);
      store_for_children(b, flags, a);
    }
  }

 private:
  /// Inward, before a body: adds its other children to `sum`, which holds its first child's contribution (undefined for a leaf).
  MOMENTREE_INLINE void gather_children(int b, unsigned flags, In& sum) const {
    if ((flags & node::branching) == 0) return;
    sum += child_sums[b];
  }
  /// Inward, after a body: adds its contribution to its parent, unless it is a first child, whose parent comes next.
  MOMENTREE_INLINE void add_to_parent(int b, unsigned flags, const In& sum) const {
    if ((flags & (node::first_child | node::root)) != 0) return;
    In& parent_sum = child_sums[tree.parent(b)];
    if ((flags & node::last_child) != 0)
      parent_sum = sum;
    else
      parent_sum += sum;
  }
  /// Outward, before a body: loads its parent's output, unless the parent came directly before.
  MOMENTREE_INLINE void load_parent(int b, unsigned flags, const Out& base, Out& value) const {
    if ((flags & node::first_child) != 0) return;
    value = (flags & node::root) != 0 ? base : parent_states[tree.parent(b)];
  }
  /// Outward, after a body: stores its output for children that do not come next.
  MOMENTREE_INLINE void store_for_children(int b, unsigned flags, const Out& value) const {
    if ((flags & node::branching) != 0) parent_states[b] = value;
  }

  MOMENTREE_INLINE int body_at(int place) const { return tree.order()[static_cast<std::size_t>(place)]; }
  MOMENTREE_INLINE unsigned flags_at(int place) const { return tree.tables().node_flags[static_cast<std::size_t>(place)]; }
};

/// Both passes over a mechanism.
template <class T>
struct InPlaneSweep {
  UncheckedTree tree;
  const T* p;
  Workspace<T>& workspace;
  InPlaneBuffers<T> buffers{tree, workspace.in_plane.child_sums.get(), workspace.in_plane.parent_states.get()};

  /// (22)–(26) and (16), everything about the body's joint, in the plane's axes.
  template <bool Gravity>
  void inboard(const KernelRun& run) const {
    InPlaneRecord<T>* const records = workspace.template records_of<InPlaneKernels>(tree, run);  // denser than revolute's
    buffers.inward(run, [&](int i, int b, unsigned flags, InPlaneInboard<T>& a) MOMENTREE_INLINE_LAMBDA {
      const LinkConstants& k = tree.link(b);
      const int angle = tree.first_angle(b);
      const T c = workspace.cos[angle], s = workspace.sin[angle];
      InPlaneRecord<T>& w = records[i - run.begin];
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
      if ((flags & node::root) != 0) return;
      const int outer = tree.parent(b);
      const T cp = workspace.cos[tree.first_angle(outer)], sp = workspace.sin[tree.first_angle(outer)];
      const T rx = k.r.x * cp - k.r.y * sp, ry = k.r.x * sp + k.r.y * cp;
      w.rx = rx, w.ry = ry;
      a.axx = w.axx, a.axy = w.axy, a.ayy = w.ayy, a.lx = w.lx, a.ly = w.ly;
      a.bx = w.axy * rx - w.axx * ry, a.by = w.ayy * rx - w.axy * ry;  // (16)
      a.J = rx * a.by - ry * a.bx;
      a.h = p[tree.first_p(b)] + (rx * w.ly - ry * w.lx);
      if constexpr (Gravity) a.mx = a.mx + tree.subtree_mass(b) * rx, a.my = a.my + tree.subtree_mass(b) * ry;
    });
  }

  /// (17), (27), (21), (20).
  template <bool Gravity>
  void outboard(const KernelRun& run) const {
    const InPlaneRecord<T>* const records = workspace.template records_of<InPlaneKernels>(tree, run);
    const Vec3 gravity = gravity_in_plane(tree, tree.order()[static_cast<std::size_t>(run.begin)]);
    buffers.outward(run, {}, [&](int i, int b, unsigned flags, InPlaneOutboard<T>& a) MOMENTREE_INLINE_LAMBDA {
      const int at = tree.first_p(b);
      const InPlaneRecord<T>& w = records[i - run.begin];
      if ((flags & node::root) == 0) a.vx = a.vx - a.w * w.ry, a.vy = a.vy + a.w * w.rx;         // (17)
      const T total = w.u0 - (w.gx * a.vx + w.gy * a.vy);                                        // (27)
      const T lx = w.axx * a.vx + w.axy * a.vy + w.lx, ly = w.axy * a.vx + w.ayy * a.vy + w.ly;  // (21)
      T pdot = a.vy * lx - a.vx * ly;                                                            // (20)
      if constexpr (Gravity) pdot = pdot + (w.mx * gravity.y - w.my * gravity.x);
      const T u = total - a.w;
      workspace.v[at] = u, workspace.qdot[tree.first_q(b)] = u, workspace.pdot[at] = pdot;
      a.w = total;
    });
  }
};

}  // namespace momentree
