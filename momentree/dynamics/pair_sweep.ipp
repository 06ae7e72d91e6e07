#pragma once
// The passes of forward.ipp over two paired branches at once: the same steps, on a scalar of two lanes. Included only by
// instantiate/*.cpp. An evaluation takes 40 % less time with them for a binary tree of 63 bodies, 29 % for ANYmal B, 27 % for the
// humanoid in scenarios/models/simple_humanoid, 11 % for MuJoCo's (g++ 12, AVX-512).
#include <momentree/dynamics/pair_sweep.hpp>
#include <momentree/dynamics/revolute_dispatch.hpp>
#include <momentree/dynamics/sweep_buffers.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/kinds.hpp>

namespace momentree {

struct PairSweep {
  UncheckedTree tree;
  const double* p;
  Workspace<double>& workspace;
  KernelRun first, second;
  const int* order = tree.order().data();
  const unsigned char* node_flags = tree.node_flags().data();
  const PairedLinks* links = tree.paired_links().data() + first.links;
  SweepBuffers<Inboard<BodyPair>, Outboard<BodyPair>> within{tree, workspace.pairs->child_sums.get(),
                                                             workspace.pairs->parent_states.get()};
  SweepBuffers<Inboard<double>, Outboard<double>> outside{tree, workspace.child_sums.get(), workspace.parent_states.get()};

  MOMENTREE_INLINE BodySweep<double>& motion_of(int b) const { return workspace.motions[static_cast<std::size_t>(b)]; }
  /// The two bodies at the same place of the paired branches.
  struct Bodies {
    int one, other;
  };
  MOMENTREE_INLINE Bodies bodies(int i) const { return {order[first.begin + i], order[second.begin + i]}; }
  MOMENTREE_INLINE int length() const { return first.end - first.begin; }
  MOMENTREE_INLINE BodyPair of(const double* values, int one, int other) const { return pairs(values[one], values[other]); }

  template <class K, bool Gravity, bool Keep>
  void revolutes_inboard() const {
    using Steps = typename K::Steps;
    Inboard<BodyPair> a;
    within.resume_inward(first, a);
    for (int i = length() - 1; i >= 0; --i) {
      const int b = bodies(i).one, c = bodies(i).other;  // no structured binding: clang 14 cannot capture it in lambdas
      const unsigned flags = flags_at(i);
      const PairedLinks& k = links[i];
      const int angle = tree.first_angle(b), there = tree.first_angle(c), at = tree.first_p(b), other = tree.first_p(c);
      ArmatureRecord<BodyPair>& record = workspace.pairs->records[static_cast<std::size_t>(b)];
      BodyPair armature(0);
      if constexpr (Steps::has_armature) armature = of(tree.armature(), at, other);
      const auto step = [&](auto shape, auto children, auto destination) MOMENTREE_INLINE_LAMBDA {
        const auto to = [&](Inboard<BodyPair>& out) MOMENTREE_INLINE_LAMBDA {
          Steps::template inboard<shape(), Gravity, Keep, children(), destination() == Destination::none>(
              k, pairs(tree.subtree_mass(b), tree.subtree_mass(c)), armature, of(workspace.cos.get(), angle, there),
              of(workspace.sin.get(), angle, there), of(p, at, other), a, within.child_sums[b], record, out);
        };
        if constexpr (destination() == Destination::parent_sum) {
          Inboard<BodyPair>& parent_sum = within.child_sums[tree.parent(b)];
          to(parent_sum);
          begin_moments<Gravity>(parent_sum);
        } else {
          to(a);
        }
      };
      dispatch_inboard<Steps::has_armature>(k.shape, flags, step);
      if constexpr (Keep) {
        const typename Steps::template Record<BodyPair>& both = record;
        part(both, workspace.record<K>(tree, b), workspace.record<K>(tree, c));
      }
      if (i > 0 || !first.branch) within.add_sibling(b, flags, a);
    }
    suspend_inward<Keep>(a);
  }

  template <class K, bool Gravity, bool Keep>
  void revolutes_outboard(const Outboard<double>& base) const {
    using Steps = typename K::Steps;
    Outboard<BodyPair> a;
    resume_outward(base, a);
    for (int i = 0; i < length(); ++i) {
      const int b = bodies(i).one, c = bodies(i).other;  // no structured binding: clang 14 cannot capture it in lambdas
      const unsigned flags = flags_at(i);
      const PairedLinks& k = links[i];
      const int angle = tree.first_angle(b), there = tree.first_angle(c), at = tree.first_p(b), other = tree.first_p(c);
      if (i > 0 || !first.branch) within.load_parent(b, flags, {}, a);
      const auto step = [&](auto of_shape) MOMENTREE_INLINE_LAMBDA {
        BodyPair u, pdot;
        BodySweep<BodyPair> motion;
        of_shape(of(workspace.cos.get(), angle, there), of(workspace.sin.get(), angle, there), u, pdot, motion);
        if constexpr (Keep) part(motion, motion_of(b), motion_of(c));
        workspace.v[at] = workspace.qdot[tree.first_q(b)] = u[0], workspace.v[other] = workspace.qdot[tree.first_q(c)] = u[1];
        workspace.pdot[at] = pdot[0], workspace.pdot[other] = pdot[1];
      };
      const ArmatureRecord<BodyPair>& record = workspace.pairs->records[static_cast<std::size_t>(b)];
      const BodyPair& momentum = of(p, at, other);
      if ((flags & node::root) != 0)
        step([&](const BodyPair& cosine, const BodyPair& sine, BodyPair& u, BodyPair& pdot, BodySweep<BodyPair>& motion)
                 MOMENTREE_INLINE_LAMBDA {
                   Steps::template outboard_root<Gravity, Keep>(k, cosine, sine, record, momentum, a, u, pdot, &motion);
                 });
      else
        dispatch_link<Steps::has_armature>(k.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          step([&](const BodyPair& cosine, const BodyPair& sine, BodyPair& u, BodyPair& pdot, BodySweep<BodyPair>& motion)
                   MOMENTREE_INLINE_LAMBDA {
                     Steps::template outboard<shape(), Gravity, Keep>(k, cosine, sine, record, momentum,
                                                                      (flags & node::leaf) != 0, a, u, pdot, &motion);
                   });
        });
      within.store_for_children(b, flags, a);
    }
    within.suspend_outward(first, a);
  }

  template <bool Keep>
  void welds_inboard() const {
    Inboard<BodyPair> a;
    within.resume_inward(first, a);
    for (int i = length() - 1; i >= 0; --i) {
      const auto [b, c] = bodies(i);
      const unsigned flags = flags_at(i);
      const PairedLinks& k = links[i];
      if ((flags & node::leaf) != 0) a = {};
      within.gather_children(b, flags, a);
      articulated_mass(k.body, a.M);  // (22)
      a.mc += k.body.mc;
      if constexpr (Keep) {
        auto &one = workspace.record<WeldKernels>(tree, b), &other = workspace.record<WeldKernels>(tree, c);
        part(a.M, one.M, other.M), part(a.D, one.D, other.D);
      }
      if (i > 0 || !first.branch) within.add_to_parent(b, flags, a);
    }
    suspend_inward<Keep>(a);
  }
  template <bool Keep>
  void welds_outboard(const Outboard<double>& base) const {
    Outboard<BodyPair> a;
    resume_outward(base, a);
    for (int i = 0; i < length(); ++i) {
      const auto [b, c] = bodies(i);
      const unsigned flags = flags_at(i);
      if (i > 0 || !first.branch) within.load_parent(b, flags, {}, a);
      if constexpr (Keep) {
        part(a.velocity, motion_of(b).velocity, motion_of(c).velocity);
        for (const int body : {b, c}) {  // (21)
          const auto& record = workspace.record<WeldKernels>(tree, body);
          motion_of(body).articulated = record.M * motion_of(body).velocity + record.D;
        }
      }
      within.store_for_children(b, flags, a);
    }
    within.suspend_outward(first, a);
  }

 private:
  /// The first bodies of paired branches keep their output in the accumulator: their parent is not part of the pair.
  MOMENTREE_INLINE unsigned flags_at(int i) const {
    const unsigned flags = node_flags[first.begin + i];
    return i == 0 && first.branch ? flags & ~unsigned{node::last_child} : flags;
  }
  MOMENTREE_INLINE void resume_outward(const Outboard<double>& base, Outboard<BodyPair>& value) const {
    if (!first.branch) return within.resume_outward(first, value);
    const int b = order[first.begin], outer = tree.parent(b);
    const Outboard<double>& from = outer < 0 ? base : outside.parent_states[outer];
    const auto both = [](Vector3<BodyPair>& to, const Vec3& x) {
      to.x = BodyPair(x.x), to.y = BodyPair(x.y), to.z = BodyPair(x.z);
    };
    both(value.velocity.v, from.velocity.v), both(value.velocity.w, from.velocity.w), both(value.gravity, from.gravity);
  }
  /// Adds each branch's contribution where the pass over single bodies would have put it.
  template <bool Keep>
  MOMENTREE_INLINE void suspend_inward(const Inboard<BodyPair>& sum) const {
    if (!first.branch) return within.suspend_inward(first, sum);
    const auto [b, c] = bodies(0);
    const int outer = tree.parent(b);
    if ((node_flags[first.begin] & (Keep ? node::root : node::grounded)) != 0) return;
    const bool is_first = (node_flags[first.begin] & node::first_child) != 0,
               is_last = (node_flags[second.begin] & node::last_child) != 0;
    Inboard<double>&parent_sum = outside.child_sums[outer], &one = outside.child_sums[b],
    &other = is_last ? parent_sum : outside.child_sums[c];
    part(sum, one, other);  // a first child's stays in child_sums[b]
    if (!is_last) parent_sum += other;
    if (!is_first) parent_sum += one;
  }
};

}  // namespace momentree
