#pragma once
// Bodies of the two recursions; included only by instantiate/*.cpp, one scalar each.
//
// A segment runs with its accumulators in locals: the reduced mass of a child is the next body's start. Only where paths meet
// do they pass through memory.
#include <momentree/dynamics/forward.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/sincos.hpp>

namespace momentree {

template <class T>
struct Sweep {
  const Tree& tree;
  const T* q;
  const T* p;
  Work<T>& work;

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), work.cos.get() + tree.first_angle(b), work.sin.get() + tree.first_angle(b)};
  }

  /// Backward recursion along a segment, tip to base.
  template <class K, bool Aligned>
  void inboard(const Segment& segment) const {
    const auto order = tree.order();
    Inboard<T> a{};  // a tip: Mb = M, Db = 0
    if (segment.junction >= 0) a = work.inlets[static_cast<std::size_t>(segment.junction)];
    for (int i = segment.end - 1; i >= segment.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      auto& record = work.template record<K>(tree, b);
      add_rigid_mass(a.M, link.body);  // (22), (23): children are in `a` already
      a.mc.x += link.body.mc.x, a.mc.y += link.body.mc.y, a.mc.z += link.body.mc.z;
      record.mc = a.mc;
      K::template reduce<T>(link, joint, p + tree.first_p(b), tree.armature() + tree.first_p(b), a.M, a.D, record);  // (24)–(26)
      const auto crossing = K::template crossing<Aligned, T>(link, joint, record);
      crossing.inboard(a.M);  // (16)
      crossing.inboard(a.D);
      crossing.inboard(a.mc);
    }
    if (segment.deposit == Segment::Deposit::assign) work.inlets[static_cast<std::size_t>(segment.parent)] = a;
    if (segment.deposit == Segment::Deposit::add) work.inlets[static_cast<std::size_t>(segment.parent)] += a;
  }

  /// Forward recursion along a segment, base to tip. `Keep`: what changes and accelerations read, Ω and Pb, is kept; stages leave
  /// it out.
  template <class K, bool Aligned, bool Keep>
  void outboard(const Segment& segment) const {
    const auto order = tree.order();
    const Vec3& g = tree.gravity();
    Outboard<T> a{{}, {T(g.x), T(g.y), T(g.z)}};
    if (segment.parent >= 0) a = work.outlets[static_cast<std::size_t>(segment.parent)];
    for (int i = segment.begin; i < segment.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = work.template record<K>(tree, b);
      const int at = tree.first_p(b);
      T* u = work.v.get() + at;
      const auto& crossing = K::template crossing_again<Aligned, T>(link, joint, record);
      crossing.outboard(a.velocity);
      crossing.outboard(a.gravity);
      K::joint_velocity(record, a.velocity, u);                                  // (27)
      const Force<T> Pb = K::articulated_momentum(record, p + at, a.velocity);   // (21)
      a.velocity = K::template spatial_velocity<T>(link, joint, a.velocity, u);  // (17)
      if constexpr (Keep) work.motions[static_cast<std::size_t>(b)] = {a.velocity, Pb};
      const Force<T> weight{link.subtree_mass * a.gravity, cross(record.mc, a.gravity)};  // (15)
      const Force<T> wrench = weight - cross(a.velocity, Pb);                             // (9), (20)
      K::template momentum_rate<T>(link, joint, u, Pb, wrench, work.pdot.get() + at);     // (20)
      K::template coordinate_rate<T>(joint.q, u, work.qdot.get() + tree.first_q(b));
    }
    if (segment.junction >= 0) work.outlets[static_cast<std::size_t>(segment.junction)] = a;
  }
};

template <class T, bool Keep>
void sweep_rates(const Tree& tree, const T* q, const T* p, Work<T>& work) noexcept {
  MT_REQUIRE(work.capacity() >= tree.bodies(), "the work has room for the bodies that were added");
  work.evaluated = {};
  work.located = {};
  work.accelerated = {};
  const auto coordinates = tree.angle_coordinates();
  const auto offsets = tree.angle_offsets();
  const int angles = static_cast<int>(coordinates.size());
  for (int i = 0; i < angles; ++i)
    work.angle[static_cast<std::size_t>(i)] = q[coordinates[static_cast<std::size_t>(i)]] + offsets[static_cast<std::size_t>(i)];
  sincos(angles, work.angle.get(), work.sin.get(), work.cos.get());

  const Sweep<T> sweep{tree, q, p, work};
  const auto segments = tree.segments();
  for (std::size_t i = segments.size(); i-- > 0;) {
    const Segment& s = segments[i];
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (K::turns_about_z) {
        if (s.aligned) return sweep.template inboard<K, true>(s);
      }
      sweep.template inboard<K, false>(s);
    });
  }
  for (const Segment& s : segments) {
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (K::turns_about_z) {
        if (s.aligned) return sweep.template outboard<K, true, Keep>(s);
      }
      sweep.template outboard<K, false, Keep>(s);
    });
  }
}

template <class T>
void evaluate_rates(const Tree& tree, const T* q, const T* p, Work<T>& work) noexcept {
  sweep_rates<T, false>(tree, q, p, work);
}
template <class T>
void evaluate_motions(const Tree& tree, const T* q, const T* p, Work<T>& work) noexcept {
  sweep_rates<T, true>(tree, q, p, work);
}

}  // namespace momentree
