#pragma once
// The sweeps of forward.ipp over two branches at once: the same steps, on a scalar of two lanes. Included only by
// instantiate/*.cpp.
#include <momentree/dynamics/passage.hpp>
#include <momentree/dynamics/pin_dispatch.hpp>
#include <momentree/dynamics/twin_sweep.hpp>
#include <momentree/dynamics/work.hpp>
#include <momentree/joint/kinds.hpp>

namespace momentree {

struct TwinSweep {
  UncheckedTree tree;
  const double* p;
  Work<double>& work;
  Segment first, second;
  const int* order = tree.order().data();
  const unsigned char* flows = tree.flows().data();
  const TwinLinks* links = tree.twin_links().data() + first.links;
  Passage<Inboard<Twins>, Outboard<Twins>> within{tree, work.twins.inlets.get(), work.twins.outlets.get()};
  Passage<Inboard<double>, Outboard<double>> outside{tree, work.inlets.get(), work.outlets.get()};

  MOMENTREE_INLINE BodySweep<double>& motion_of(int b) const { return work.motions[static_cast<std::size_t>(b)]; }
  /// A body and its twin.
  struct Bodies {
    int one, other;
  };
  MOMENTREE_INLINE Bodies bodies(int i) const { return {order[first.begin + i], order[second.begin + i]}; }
  MOMENTREE_INLINE int length() const { return first.end - first.begin; }
  MOMENTREE_INLINE Twins of(const double* values, int one, int other) const { return twins(values[one], values[other]); }

  template <class K, bool Gravity, bool Keep>
  void pins_inboard() const {
    using Steps = typename K::Steps;
    Inboard<Twins> a;
    within.enter_in(first, a);
    for (int i = length() - 1; i >= 0; --i) {
      const int b = bodies(i).one, c = bodies(i).other;  // no binding: clang 14 does not let lambdas have one
      const unsigned flow = flow_at(i);
      const TwinLinks& k = links[i];
      const int angle = tree.first_angle(b), there = tree.first_angle(c), at = tree.first_p(b), other = tree.first_p(c);
      RotorRecord<Twins>& record = work.twins.records[static_cast<std::size_t>(b)];
      Twins armature(0);
      if constexpr (Steps::rotor) armature = of(tree.armature(), at, other);
      const auto step = [&](auto shape, auto children, auto way) MOMENTREE_INLINE_LAMBDA {
        const auto to = [&](Inboard<Twins>& out) MOMENTREE_INLINE_LAMBDA {
          Steps::template inboard<shape(), Gravity, Keep, children(), way() == Way::root>(
              k, twins(tree.subtree_mass(b), tree.subtree_mass(c)), armature, of(work.cos.get(), angle, there),
              of(work.sin.get(), angle, there), of(p, at, other), a, within.inlets[b], record, out);
        };
        if constexpr (way() == Way::aside) {
          Inboard<Twins>& inlet = within.inlets[tree.parent(b)];
          to(inlet);
          begin_moments<Gravity>(inlet);
        } else {
          to(a);
        }
      };
      dispatch_inboard<Steps::rotor>(k.shape, flow, step);
      if constexpr (Keep) {
        const typename Steps::template Record<Twins>& both = record;
        part(both, work.record<K>(tree, b), work.record<K>(tree, c));
      }
      if (i > 0 || !first.branch) within.add(b, flow, a);
    }
    leave_in(a);
  }

  template <class K, bool Gravity, bool Keep>
  void pins_outboard(const Outboard<double>& base) const {
    using Steps = typename K::Steps;
    Outboard<Twins> a;
    enter_out(base, a);
    for (int i = 0; i < length(); ++i) {
      const int b = bodies(i).one, c = bodies(i).other;  // no binding: clang 14 does not let lambdas have one
      const unsigned flow = flow_at(i);
      const TwinLinks& k = links[i];
      const int angle = tree.first_angle(b), there = tree.first_angle(c), at = tree.first_p(b), other = tree.first_p(c);
      if (i > 0 || !first.branch) within.receive(b, flow, {}, a);
      const auto step = [&](auto of_shape) MOMENTREE_INLINE_LAMBDA {
        Twins u, pdot;
        BodySweep<Twins> motion;
        of_shape(of(work.cos.get(), angle, there), of(work.sin.get(), angle, there), u, pdot, motion);
        if constexpr (Keep) part(motion, motion_of(b), motion_of(c));
        work.v[at] = work.qdot[tree.first_q(b)] = u[0], work.v[other] = work.qdot[tree.first_q(c)] = u[1];
        work.pdot[at] = pdot[0], work.pdot[other] = pdot[1];
      };
      const RotorRecord<Twins>& record = work.twins.records[static_cast<std::size_t>(b)];
      const Twins& momentum = of(p, at, other);
      if ((flow & flow::root) != 0)
        step([&](const Twins& cosine, const Twins& sine, Twins& u, Twins& pdot, BodySweep<Twins>& motion)
                 MOMENTREE_INLINE_LAMBDA {
                   Steps::template outboard_root<Gravity, Keep>(k, cosine, sine, record, momentum, a, u, pdot, &motion);
                 });
      else
        dispatch_link<Steps::rotor>(k.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          step([&](const Twins& cosine, const Twins& sine, Twins& u, Twins& pdot, BodySweep<Twins>& motion)
                   MOMENTREE_INLINE_LAMBDA {
                     Steps::template outboard<shape(), Gravity, Keep>(k, cosine, sine, record, momentum, (flow & flow::tip) != 0,
                                                                      a, u, pdot, &motion);
                   });
        });
      within.hand_down(b, flow, a);
    }
    within.leave_out(first, a);
  }

  template <bool Keep>
  void welds_inboard() const {
    Inboard<Twins> a;
    within.enter_in(first, a);
    for (int i = length() - 1; i >= 0; --i) {
      const auto [b, c] = bodies(i);
      const unsigned flow = flow_at(i);
      const TwinLinks& k = links[i];
      if ((flow & flow::tip) != 0) a = {};
      within.collect(b, flow, a);
      add_rigid_mass(a.M, k.body);
      a.mc += k.body.mc;
      if constexpr (Keep) {
        auto &one = work.record<WeldKernels>(tree, b), &other = work.record<WeldKernels>(tree, c);
        part(a.M, one.M, other.M), part(a.D, one.D, other.D);
      }
      if (i > 0 || !first.branch) within.deliver(b, flow, a);
    }
    leave_in(a);
  }
  template <bool Keep>
  void welds_outboard(const Outboard<double>& base) const {
    Outboard<Twins> a;
    enter_out(base, a);
    for (int i = 0; i < length(); ++i) {
      const auto [b, c] = bodies(i);
      const unsigned flow = flow_at(i);
      if (i > 0 || !first.branch) within.receive(b, flow, {}, a);
      if constexpr (Keep) {
        part(a.velocity, motion_of(b).velocity, motion_of(c).velocity);
        for (const int body : {b, c}) {  // (21)
          const auto& record = work.record<WeldKernels>(tree, body);
          motion_of(body).articulated = record.M * motion_of(body).velocity + record.D;
        }
      }
      within.hand_down(b, flow, a);
    }
    within.leave_out(first, a);
  }

 private:
  /// To the branches' own first bodies nothing comes from within.
  MOMENTREE_INLINE unsigned flow_at(int i) const {
    const unsigned flow = flows[first.begin + i];
    return i == 0 && first.branch ? flow & ~unsigned{flow::last} : flow;
  }
  MOMENTREE_INLINE void enter_out(const Outboard<double>& base, Outboard<Twins>& value) const {
    if (!first.branch) return within.enter_out(first, value);
    const int b = order[first.begin], outer = tree.parent(b);
    const Outboard<double>& from = outer < 0 ? base : outside.outlets[outer];
    const auto both = [](Vector3<Twins>& to, const Vec3& x) { to.x = Twins(x.x), to.y = Twins(x.y), to.z = Twins(x.z); };
    both(value.velocity.v, from.velocity.v), both(value.velocity.w, from.velocity.w), both(value.gravity, from.gravity);
  }
  /// What each branch asks, to where it would have put it by itself.
  MOMENTREE_INLINE void leave_in(const Inboard<Twins>& sum) const {
    if (!first.branch) return within.leave_in(first, sum);
    const auto [b, c] = bodies(0);
    const int outer = tree.parent(b);
    if (outer < 0) return;
    const bool is_first = (flows[first.begin] & flow::first) != 0, is_last = (flows[second.begin] & flow::last) != 0;
    Inboard<double>&inlet = outside.inlets[outer], &one = outside.inlets[b], &other = is_last ? inlet : outside.inlets[c];
    part(sum, one, other);  // a first child's waits there
    if (!is_last) inlet += other;
    if (!is_first) inlet += one;
  }
};

}  // namespace momentree
