#pragma once
// Velocities as the state of plane mechanisms (in_plane.ipp). In the plane's axes with absolute angles the bias of a body is the
// centripetal acceleration of its joint; velocities of points are not needed. Included only by velocity.ipp.
#include <momentree/dynamics/steps/in_plane.ipp>

namespace momentree {

template <class T>
struct InPlaneVelocitySweep {
  UncheckedTree tree;
  Workspace<T>& workspace;
  InPlaneBuffers<T> buffers{tree, workspace.in_plane.child_sums.get(), workspace.in_plane.parent_states.get()};

  /// Absolute angular velocities, and the joints' positions.
  void velocities(const KernelRun& run) const {
    auto* const records = workspace.template records_of<InPlaneRateKernels>(tree, run);
    buffers.outward(run, {}, [&](int i, int b, unsigned flags, InPlaneOutboard<T>& a) MOMENTREE_INLINE_LAMBDA {
      const int at = tree.first_p(b), outer = tree.parent(b);
      InPlaneRateRecord<T>& w = records[i - run.begin];
      const T u = workspace.v[at];
      workspace.qdot[tree.first_q(b)] = u;
      if ((flags & node::root) == 0) {
        const LinkConstants& k = tree.link(b);
        const T cp = workspace.cos[tree.first_angle(outer)], sp = workspace.sin[tree.first_angle(outer)];
        w.rx = k.r.x * cp - k.r.y * sp, w.ry = k.r.x * sp + k.r.y * cp;
        const T square = a.w * a.w;
        w.ax = -(square * w.rx), w.ay = -(square * w.ry);  // (39)
      } else {
        w.ax = w.ay = T(0);
      }
      a.w = a.w + u;
      w.w = a.w;
    });
  }

  /// (22)–(26) and (16) with joint forces and wrenches.
  void inboard(const KernelRun& run) const {
    auto* const records = workspace.template records_of<InPlaneRateKernels>(tree, run);
    buffers.inward(run, [&](int i, int b, unsigned flags, InPlaneInboard<T>& a) MOMENTREE_INLINE_LAMBDA {
      const LinkConstants& k = tree.link(b);
      const int angle = tree.first_angle(b);
      const T c = workspace.cos[angle], s = workspace.sin[angle], tau = workspace.a[tree.first_p(b)];
      InPlaneRateRecord<T>& w = records[i - run.begin];
      const T mx = k.body.mc.x * c - k.body.mc.y * s, my = k.body.mc.x * s + k.body.mc.y * c;
      const T bx = a.bx - my, by = a.by + mx, J = a.J + k.body.J.zz;  // (22)
      const T axx = a.axx + k.body.m, ayy = a.ayy + k.body.m;
      const T square = w.w * w.w;
      T lx = a.lx - square * mx, ly = a.ly - square * my;  // (23)
      const T inverse = T(1) / J, r = tau - a.h;           // (24)
      const T gx = bx * inverse, gy = by * inverse;
      w.gx = gx, w.gy = gy, w.u0 = inverse * r;
      if ((flags & node::root) != 0) return;
      a.axx = axx - bx * gx, a.axy = a.axy - bx * gy, a.ayy = ayy - by * gy;  // (25)
      lx = lx + gx * r, ly = ly + gy * r;                                     // (26)
      a.lx = lx + (a.axx * w.ax + a.axy * w.ay), a.ly = ly + (a.axy * w.ax + a.ayy * w.ay);
      const T rx = w.rx, ry = w.ry;
      a.bx = a.axy * rx - a.axx * ry, a.by = a.ayy * rx - a.axy * ry;  // (16)
      a.J = rx * a.by - ry * a.bx;
      a.h = tau + (rx * a.ly - ry * a.lx);
    });
  }

  /// (27), (17).
  void outboard(const KernelRun& run) const {
    const Vec3 gravity = gravity_in_plane(tree, tree.order()[static_cast<std::size_t>(run.begin)]);
    const auto* const records = workspace.template records_of<InPlaneRateKernels>(tree, run);
    const InPlaneOutboard<T> base{T(-gravity.x), T(-gravity.y), T(0)};
    buffers.outward(run, base, [&](int i, int b, unsigned flags, InPlaneOutboard<T>& a) MOMENTREE_INLINE_LAMBDA {
      const InPlaneRateRecord<T>& w = records[i - run.begin];
      if ((flags & node::root) == 0) a.vx = a.vx - a.w * w.ry + w.ax, a.vy = a.vy + a.w * w.rx + w.ay;
      const T total = w.u0 - (w.gx * a.vx + w.gy * a.vy);
      workspace.a[tree.first_p(b)] = total - a.w;
      a.w = total;
    });
  }
};

}  // namespace momentree
