#pragma once
// Bodies of the two recursions; included only by instantiate/*.cpp, one scalar each.
//
// The sweeps run along the order with their sums in locals: behind a body stands its first child, so that only where other
// children meet do sums pass through memory. Stretches of joints that share their kernels are one loop.
#include <momentree/dynamics/flat.ipp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/passage.hpp>
#include <momentree/dynamics/pin_dispatch.hpp>
#include <momentree/dynamics/twin_sweep.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/pack.hpp>

namespace momentree {

template <class T>
struct Sweep {
  UncheckedTree tree;
  const T* q;
  const T* p;
  Work<T>& work;
  bool falls;  // else nobody adds up first moments
  Passage<Inboard<T>, Outboard<T>> passage{tree, work.inlets.get(), work.outlets.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), work.cos.get() + tree.first_angle(b), work.sin.get() + tree.first_angle(b)};
  }

  /// Backward recursion over a stretch of the order. `Keep` as below.
  template <class K, bool Keep>
  void inboard(const Segment& segment) const {
    const auto order = tree.order();
    const auto flows = tree.flows();
    auto* const records = work.template records_of<K>(tree, segment);
    Inboard<T> a;
    passage.enter_in(segment, a);
    for (int i = segment.end - 1; i >= segment.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flow = flows[static_cast<std::size_t>(i)];
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      auto& record = records[i - segment.begin];
      if ((flow & flow::tip) != 0) a = {};  // Mb = M, Db = 0
      passage.collect(b, flow, a);
      add_rigid_mass(a.M, link.body);  // (22), (23): children are in `a` already
      a.mc.x += link.body.mc.x, a.mc.y += link.body.mc.y, a.mc.z += link.body.mc.z;
      if constexpr (K::rigid) {
        if constexpr (Keep) record.M = a.M, record.D = a.D;
      } else {
        record.mc = falls ? a.mc : Vector3<T>{T(0), T(0), T(0)};
        K::template reduce<T>(link, joint, p + tree.first_p(b), tree.armature() + tree.first_p(b), a.M, a.D,
                              record);  // (24)–(26)
        const auto over = [&](const auto& crossing) MOMENTREE_INLINE_LAMBDA {
          if ((flow & flow::root) != 0) return;  // nobody asks for it
          crossing.inboard(a.M);                 // (16)
          crossing.inboard(a.D);
          crossing.inboard(a.mc, tree.subtree_mass(b));
        };
        if (K::turns_about_z && (flow & flow::aligned) != 0)
          over(K::template crossing<true, T>(link, joint, record));
        else
          over(K::template crossing<false, T>(link, joint, record));
      }
      passage.deliver(b, flow, a);
    }
    passage.leave_in(segment, a);
  }

  /// Forward recursion over a stretch of the order. `Keep`: what changes and accelerations read, Ω and Pb, is kept; stages leave
  /// it out.
  template <class K, bool Keep>
  void outboard(const Segment& segment, const Outboard<T>& base) const {
    const auto order = tree.order();
    const auto flows = tree.flows();
    const auto* const records = work.template records_of<K>(tree, segment);
    Outboard<T> a;
    passage.enter_out(segment, a);
    for (int i = segment.begin; i < segment.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flow = flows[static_cast<std::size_t>(i)];
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = records[i - segment.begin];
      const int at = tree.first_p(b);
      T* u = work.v.get() + at;
      passage.receive(b, flow, base, a);
      if constexpr (K::rigid) {
        if constexpr (Keep) work.motions[static_cast<std::size_t>(b)] = {a.velocity, record.M * a.velocity + record.D};  // (21)
      } else {
        const auto over = [&](const auto& crossing) MOMENTREE_INLINE_LAMBDA {
          crossing.outboard(a.velocity);
          crossing.outboard(a.gravity);
        };
        if (K::turns_about_z && (flow & flow::aligned) != 0)
          over(K::template crossing_again<true, T>(link, joint, record));
        else
          over(K::template crossing_again<false, T>(link, joint, record));
        K::joint_velocity(record, a.velocity, u);                                  // (27)
        const Force<T> Pb = K::articulated_momentum(record, p + at, a.velocity);   // (21)
        a.velocity = K::template spatial_velocity<T>(link, joint, a.velocity, u);  // (17)
        if constexpr (Keep) work.motions[static_cast<std::size_t>(b)] = {a.velocity, Pb};
        const Force<T> weight{tree.subtree_mass(b) * a.gravity, cross(record.mc, a.gravity)};  // (15)
        const Force<T> wrench = weight - cross(a.velocity, Pb);                                // (9), (20)
        K::template momentum_rate<T>(link, joint, u, Pb, wrench, work.pdot.get() + at);        // (20)
        K::template coordinate_rate<T>(joint.q, u, work.qdot.get() + tree.first_q(b));
      }
      passage.hand_down(b, flow, a);
    }
    passage.leave_out(segment, a);
  }

  // The same for kinds that have whole steps by the shape of a link.

  template <class K, bool Gravity, bool Keep>
  void inboard_steps(const Segment& segment) const {
    const int* order = tree.order().data();
    const unsigned char* flows = tree.flows().data();
    [[maybe_unused]] const double* armature = tree.armature();
    auto* record = work.template records_of<K>(tree, segment) + (segment.end - segment.begin);
    Inboard<T> a;
    passage.enter_in(segment, a);
    for (std::ptrdiff_t i = segment.end - 1; i >= segment.begin; --i) {
      const int b = order[i];
      const unsigned flow = flows[i];
      const Link& link = tree.link(b);
      const int angle = tree.first_angle(b), at = tree.first_p(b);
      --record;
      const auto step = [&](auto shape, auto children, auto way) MOMENTREE_INLINE_LAMBDA {
        const auto to = [&](Inboard<T>& out) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template inboard<shape(), Gravity, Keep, children(), way() == Way::root>(
              link, tree.subtree_mass(b), K::Steps::rotor ? armature[at] : 0.0, work.cos[angle], work.sin[angle], p[at], a,
              passage.inlets[b], *record, out);
        };
        if constexpr (way() == Way::aside) {
          Inboard<T>& inlet = passage.inlets[tree.parent(b)];
          to(inlet);
          begin_moments<Gravity>(inlet);
        } else {
          to(a);
        }
      };
      dispatch_inboard<K::Steps::rotor>(link.shape, flow, step);
      passage.add(b, flow, a);
    }
    passage.leave_in(segment, a);
  }

  template <class K, bool Gravity, bool Keep>
  void outboard_steps(const Segment& segment, const Outboard<T>& base) const {
    const int* order = tree.order().data();
    const unsigned char* flows = tree.flows().data();
    const auto* record = work.template records_of<K>(tree, segment);
    Outboard<T> a;
    passage.enter_out(segment, a);
    for (std::ptrdiff_t i = segment.begin; i < segment.end; ++i, ++record) {
      const int b = order[i];
      const unsigned flow = flows[i];
      const Link& link = tree.link(b);
      const int angle = tree.first_angle(b), at = tree.first_p(b);
      auto* const kept = Keep ? &work.motions[static_cast<std::size_t>(b)] : nullptr;
      if ((flow & flow::root) != 0) {
        a = base;
        K::Steps::template outboard_root<Gravity, Keep>(link, work.cos[angle], work.sin[angle], *record, p[at], a, work.v[at],
                                                        work.pdot[at], kept);
      } else {
        passage.receive(b, flow, base, a);
        dispatch_link<K::Steps::rotor>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template outboard<shape(), Gravity, Keep>(link, work.cos[angle], work.sin[angle], *record, p[at],
                                                              (flow & flow::tip) != 0, a, work.v[at], work.pdot[at], kept);
        });
      }
      work.qdot[tree.first_q(b)] = work.v[at];
      passage.hand_down(b, flow, a);
    }
    passage.leave_out(segment, a);
  }
};

/// Sines and cosines of angle(0), angle(1) …, a few at a time: what was just found is still at hand.
template <class T, class Angle>
MOMENTREE_INLINE void sincos_in_blocks(int n, const Angle& angle, T* s, T* c) {
  if constexpr (std::is_same_v<T, double>) {
    sincos_by_fours(n, angle, s, c);
  } else {
    constexpr int block = 64;
    T some[block];
    for (int first = 0; first < n; first += block) {
      const int count = n - first < block ? n - first : block;
      for (int i = 0; i < count; ++i) some[i] = angle(first + i);
      sincos(count, some, s + first, c + first);
    }
  }
}

/// Of the joints' angles, θ0 added; of mechanisms in a plane, at a stage, those of the bodies' angles instead.
template <class T, bool Keep>
MOMENTREE_INLINE void find_sines(const Tree& tree, const T* q, Work<T>& work) {
  const int* const coordinates = tree.angle_coordinates().data();
  const double* const offsets = tree.angle_offsets().data();
  const int n = static_cast<int>(tree.angle_coordinates().size());
  T *const s = work.sin.get(), *const c = work.cos.get();
  const auto angle = [&](int i) MOMENTREE_INLINE_LAMBDA { return q[coordinates[i]] + offsets[i]; };
  bool flat = false;
  if constexpr (!Keep)
    for (const Segment& segment : tree.segments()) flat = flat || segment.planar;
  if (!flat) return sincos_in_blocks(n, angle, s, c);
  for (int i = 0; i < n; ++i) s[i] = angle(i);
  for (const Segment& segment : tree.segments())
    if (segment.planar) add_up_angles(tree, segment, s);
  sincos_in_blocks(
      n, [s](int i) MOMENTREE_INLINE_LAMBDA { return s[i]; }, s, c);
}

template <class T, bool Keep>
void sweep_rates(const Tree& tree, const T* q, const T* p, Work<T>& work) noexcept {
  MT_REQUIRE(work.capacity() >= tree.bodies(), "the work has room for the tree's bodies: make it for this tree");
  work.evaluated = {};
  work.located = {};
  work.accelerated = {};
  constexpr bool in_pairs = has_twin_lanes && std::is_same_v<T, double>;  // branches that are built alike
  const auto segments = in_pairs ? tree.twin_segments() : tree.segments();
  find_sines<T, Keep>(tree, q, work);

  const Vec3& g = tree.gravity();
  const bool falls = g.x != 0 || g.y != 0 || g.z != 0;
  const FlatSweep<T> planar{tree, q, p, work};
  const Sweep<T> sweep{tree, q, p, work, falls};
  T o(0);  // not constant, and written out: compilers clear structs at a cost that small mechanisms feel
  const Outboard<T> base{{{o, o, o}, {o, o, o}}, {T(g.x), T(g.y), T(g.z)}};
  for (std::size_t i = segments.size(); i-- > 0;) {
    const Segment& s = segments[i];
    if (!Keep && s.planar) {
      falls ? planar.template inboard<true>(s) : planar.template inboard<false>(s);
      continue;
    }
    if constexpr (in_pairs) {
      if (s.twin >= 0) {
        if (s.begin > s.twin) twins_inboard<Keep>(tree, s, falls, p, work);
        continue;
      }
    }
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (requires { typename K::Steps; }) {
        if (falls)
          sweep.template inboard_steps<K, true, Keep>(s);
        else
          sweep.template inboard_steps<K, false, Keep>(s);
      } else {
        sweep.template inboard<K, Keep && K::rigid>(s);  // only rigid kernels keep anything on the way in
      }
    });
  }
  for (const Segment& s : segments) {
    if (!Keep && s.planar) {
      falls ? planar.template outboard<true>(s) : planar.template outboard<false>(s);
      continue;
    }
    if constexpr (in_pairs) {
      if (s.twin >= 0) {
        if (s.begin < s.twin) twins_outboard<Keep>(tree, s, falls, base, p, work);
        continue;
      }
    }
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (requires { typename K::Steps; }) {
        if (falls)
          sweep.template outboard_steps<K, true, Keep>(s, base);
        else
          sweep.template outboard_steps<K, false, Keep>(s, base);
      } else {
        sweep.template outboard<K, Keep>(s, base);
      }
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
