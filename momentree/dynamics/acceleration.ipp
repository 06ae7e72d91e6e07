#pragma once
// Bodies of the second recursion; included only by instantiate/*.cpp, one scalar each. Segments run as those of the first
// recursion do, with accumulators in locals.
//
// The paper takes Ṗb outward and Tr = Ṗb + Ω × Pb − Tb from it (32), two numbers that nearly cancel where what hangs outboard
// is heavy and fast. Tr itself obeys the same recursion: Tr = Mb Ω̇ + W, where W is Ω × P of the body itself and what its
// children ask of it, and Ω̇ is less gravity; nothing is lost then.
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

template <class T>
struct RateSweep {
  const Tree& tree;
  const T* q;
  Work<T>& work;

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), work.cos.get() + tree.first_angle(b), work.sin.get() + tree.first_angle(b)};
  }

  /// Tip to base. For the way out there wait: the bias in `accelerations`, Tr without M̂ a′ in `reactions`, and in `a`
  /// Mj⁻¹ (τ − Eᵀ W).
  template <class K, bool Aligned>
  void inboard(const Segment& segment) const {
    const auto order = tree.order();
    const Force<T>* const loads = tree.loaded_bodies().empty() ? nullptr : work.loads.get();
    Force<T> W{};  // what the children ask, and soon the body itself
    if (segment.junction >= 0) W = work.inlets[static_cast<std::size_t>(segment.junction)].D;
    for (int i = segment.end - 1; i >= segment.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const auto body = static_cast<std::size_t>(b);
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = work.template record<K>(tree, b);
      const int at = tree.first_p(b);
      T* udot = work.a.get() + at;  // τ on entry
      const Motion<T>& velocity = work.motions[body].velocity;
      W += turning_wrench(link.body, velocity);
      if (loads != nullptr) W = W - loads[body];
      K::template reduce_wrench<T>(link, joint, record, udot, W, udot);  // (51)
      work.reactions[body] = W;
      const Motion<T> bias = K::template acceleration_bias<T>(link, joint, velocity, work.v.get() + at);
      work.accelerations[body] = bias;
      K::add_reduced_bias(record, bias, W);
      K::template crossing_again<Aligned, T>(link, joint, record).inboard(W);  // (45)
    }
    if (segment.deposit == Segment::Deposit::assign) work.inlets[static_cast<std::size_t>(segment.parent)].D = W;
    if (segment.deposit == Segment::Deposit::add) work.inlets[static_cast<std::size_t>(segment.parent)].D += W;
  }

  /// Base to tip. The ground accelerates against gravity: so every body has its weight, and none needs to know where down is.
  template <class K, bool Aligned>
  void outboard(const Segment& segment) const {
    const auto order = tree.order();
    const Vec3& g = tree.gravity();
    Motion<T> a{{T(-g.x), T(-g.y), T(-g.z)}, {}};
    if (segment.parent >= 0) a = work.outlets[static_cast<std::size_t>(segment.parent)].velocity;
    for (int i = segment.begin; i < segment.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const auto body = static_cast<std::size_t>(b);
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = work.template record<K>(tree, b);
      T* udot = work.a.get() + tree.first_p(b);
      K::template crossing_again<Aligned, T>(link, joint, record).outboard(a);
      a = a + work.accelerations[body];                           // a′ = X Ω̇_parent + bias
      K::joint_acceleration(record, a, udot);                     // (47)
      K::add_reduced(record, a, work.reactions[body]);            // (44), (32)
      a = K::template spatial_velocity<T>(link, joint, a, udot);  // (39)
      work.accelerations[body] = a;
    }
    if (segment.junction >= 0) work.outlets[static_cast<std::size_t>(segment.junction)].velocity = a;
  }
};

template <class T>
void evaluate_accelerations(const Tree& tree, const T* q, Work<T>& work) noexcept {
  const RateSweep<T> sweep{tree, q, work};
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
        if (s.aligned) return sweep.template outboard<K, true>(s);
      }
      sweep.template outboard<K, false>(s);
    });
  }
}

}  // namespace momentree
