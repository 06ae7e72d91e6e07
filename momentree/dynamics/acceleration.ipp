#pragma once
// Bodies of the second recursion; included only by instantiate/*.cpp, one scalar each. Segments run as those of the first
// recursion do, with accumulators in locals.
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

  /// Tip to base. On the way out there wait: in `accelerations` the bias, in `reactions` Tr but for M̂ a′, in `a` Mj⁻¹ (π − Eᵀ
  /// Ḋb).
  template <class K, bool Aligned>
  void inboard(const Segment& segment) const {
    const auto order = tree.order();
    Force<T> D{};  // Ḋb; a tip has none
    if (segment.junction >= 0) D = work.inlets[static_cast<std::size_t>(segment.junction)].D;
    for (int i = segment.end - 1; i >= segment.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const auto body = static_cast<std::size_t>(b);
      const Link& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = work.template record<K>(tree, b);
      const int at = tree.first_p(b);
      const T* u = work.v.get() + at;
      const BodySweep<T>& m = work.motions[body];
      T pi[6];
      K::template rate_without_turning<T>(link, joint, u, m.articulated, work.pdot.get() + at, pi);
      K::template reduce_rate<T>(link, joint, record, pi, D, work.a.get() + at);  // (51)
      work.reactions[body] = D - m.wrench;
      const Motion<T> bias = K::template acceleration_bias<T>(link, joint, m.velocity, u);
      work.accelerations[body] = bias;
      K::template remainder_rate<T>(link, joint, record, bias, u, m.articulated, D);
      K::template crossing_again<Aligned, T>(link, joint, record).inboard(D);  // (45)
    }
    if (segment.deposit == Segment::Deposit::assign) work.inlets[static_cast<std::size_t>(segment.parent)].D = D;
    if (segment.deposit == Segment::Deposit::add) work.inlets[static_cast<std::size_t>(segment.parent)].D += D;
  }

  /// Base to tip.
  template <class K, bool Aligned>
  void outboard(const Segment& segment) const {
    const auto order = tree.order();
    Motion<T> a{};  // the ground rests
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
      K::add_reduced(record, a, work.reactions[body]);            // (44) as Ṗb = M̂ a′ + D̂̇ without bias; (32)
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
