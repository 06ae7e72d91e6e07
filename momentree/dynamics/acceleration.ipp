#pragma once
// Bodies of the second recursion; included only by instantiate/*.cpp, one scalar each. Segments run as those of the first
// recursion do, with accumulators in locals.
//
// The paper takes Ṗb outward and Tr = Ṗb + Ω × Pb − Tb from it (32), two numbers that nearly cancel where what hangs outboard
// is heavy and fast. Tr itself obeys the same recursion: Tr = Mb Ω̇ + W, where W is Ω × P of the body itself and what its
// children ask of it, and Ω̇ is less gravity; nothing is lost then.
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/passage.hpp>
#include <momentree/dynamics/pin_dispatch.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

template <class T>
struct RateSweep {
  UncheckedTree tree;
  const T* q;
  Work<T>& work;
  Passage<Force<T>, Motion<T>> passage{tree, work.wrench_inlets.get(), work.rate_outlets.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), work.cos.get() + tree.first_angle(b), work.sin.get() + tree.first_angle(b)};
  }

  /// Tip to base. For the way out there wait: the bias in `approaches`, and in `a` Mj⁻¹ (τ − Eᵀ W). Of Tr, what is not M̂ a′
  /// stays in `demands`: few ask for all wrenches.
  template <class K>
  void inboard(const Segment& segment) const {
    const auto order = tree.order();
    const auto flows = tree.flows();
    const Force<T>* const loads = tree.loaded_bodies().empty() ? nullptr : work.loads.get();
    Force<T> W;  // what the children ask, and soon the body itself
    passage.enter_in(segment, W);
    for (int i = segment.end - 1; i >= segment.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flow = flows[static_cast<std::size_t>(i)];
      const auto body = static_cast<std::size_t>(b);
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = work.template record<K>(tree, b);
      const int at = tree.first_p(b);
      T* udot = work.a.get() + at;  // τ on entry
      const Motion<T>& velocity = work.motions[body].velocity;
      if ((flow & flow::tip) != 0) W = {};
      passage.collect(b, flow, W);
      W += turning_wrench(link.body, velocity);
      if (loads != nullptr) W = W - loads[body];
      if constexpr (K::rigid) {
        put(W, work.demands[body]);
        put({}, work.approaches[body]);
        passage.deliver(b, flow, W);
        continue;
      }
      K::template reduce_wrench<T>(link, joint, record, udot, W, udot);  // (51)
      put(W, work.demands[body]);
      const Motion<T> bias = K::template acceleration_bias<T>(link, joint, velocity, work.v.get() + at);
      K::add_reduced_bias(record, bias, W);
      if constexpr (requires { typename K::Steps; })
        K::joint_acceleration(record, bias, udot);  // of (47) what need not wait for the way out
      else
        put(bias, work.approaches[body]);
      if constexpr (requires { typename K::Steps; })  // (45)
        dispatch_link<K::Steps::rotor>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template cross_inboard<shape()>(link, joint.c[0], joint.s[0], W);
        });
      else if (K::turns_about_z && (flow & flow::aligned) != 0)
        K::template crossing_again<true, T>(link, joint, record).inboard(W);
      else
        K::template crossing_again<false, T>(link, joint, record).inboard(W);
      passage.deliver(b, flow, W);
    }
    passage.leave_in(segment, W);
  }

  /// Base to tip. The ground accelerates against gravity: so every body has its weight, and none needs to know where down is.
  template <class K>
  void outboard(const Segment& segment, const Motion<T>& base) const {
    const auto order = tree.order();
    const auto flows = tree.flows();
    Motion<T> a;
    passage.enter_out(segment, a);
    for (int i = segment.begin; i < segment.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flow = flows[static_cast<std::size_t>(i)];
      const auto body = static_cast<std::size_t>(b);
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = work.template record<K>(tree, b);
      T* udot = work.a.get() + tree.first_p(b);
      passage.receive(b, flow, base, a);
      if constexpr (K::rigid) {
        put(a, work.approaches[body]);
        passage.hand_down(b, flow, a);
        continue;
      }
      if constexpr (requires { typename K::Steps; }) {
        dispatch_link<K::Steps::rotor>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template rate_outboard<shape()>(link, joint.c[0], joint.s[0], record, work.motions[body].velocity,
                                                    work.v[tree.first_p(b)], udot[0], a, work.approaches[body]);
        });
      } else {
        if (K::turns_about_z && (flow & flow::aligned) != 0)
          K::template crossing_again<true, T>(link, joint, record).outboard(a);
        else
          K::template crossing_again<false, T>(link, joint, record).outboard(a);
        a = a + work.approaches[body];  // a′ = X Ω̇_parent + bias
        put(a, work.approaches[body]);
        K::joint_acceleration(record, a, udot);                     // (47)
        a = K::template spatial_velocity<T>(link, joint, a, udot);  // (39)
      }
      passage.hand_down(b, flow, a);
    }
    passage.leave_out(segment, a);
  }
};

template <class T>
void evaluate_accelerations(const Tree& tree, const T* q, Work<T>& work) noexcept {
  const RateSweep<T> sweep{tree, q, work};
  const auto segments = tree.segments();
  for (std::size_t i = segments.size(); i-- > 0;) {
    const Segment& s = segments[i];
    dispatch_kernels(s.kind, s.variant, [&](auto tag) { sweep.template inboard<typename decltype(tag)::type>(s); });
  }
  const Vec3& g = tree.gravity();
  const Motion<T> base{{T(-g.x), T(-g.y), T(-g.z)}, {}};
  for (const Segment& s : segments)
    dispatch_kernels(s.kind, s.variant, [&](auto tag) { sweep.template outboard<typename decltype(tag)::type>(s, base); });
}

}  // namespace momentree
