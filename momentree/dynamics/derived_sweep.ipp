#pragma once
// The passes over kernel runs of kinds with derived steps, in a stage; included as forward.ipp is.
#include <momentree/dynamics/derived_place.hpp>
#include <momentree/dynamics/forward.ipp>
#include <momentree/joint/all_derived.hpp>  // generated: includes every file of derived/

namespace momentree {

template <class T>
template <class K>
void Sweep<T>::inboard_derived(const KernelRun& run) const {
  const auto order = tree.order();
  const auto node_flags = tree.node_flags();
  auto* const records = workspace.template records_of<K>(tree, run);
  Inboard<T> a;
  buffers.resume_inward(run, a);
  for (int i = run.end - 1; i >= run.begin; --i) {
    const int b = order[static_cast<std::size_t>(i)];
    const unsigned flags = node_flags[static_cast<std::size_t>(i)];
    const LinkConstants& link = tree.link(b);
    if ((flags & node::leaf) == 0) buffers.gather_children(b, flags, a);
    const detail::Destinations to(flags);
    Inboard<T>& sum = to.parent_sum ? buffers.child_sums[tree.parent(b)] : a;
    with_derived_steps<DerivedSteps, K, momentum_forms<K>>(link, detail::place_of(flags), [&](auto tag) MOMENTREE_INLINE_LAMBDA {
      using Steps = typename decltype(tag)::type;
      const auto step = [&](auto adds) MOMENTREE_INLINE_LAMBDA {
        Steps::template inboard<adds(), T>(link, tree.subtree_mass(b), has_gravity, joint_state(b), p + tree.first_p(b), a,
                                           detail::derived_record<T, Steps>(records[i - run.begin]), sum);
      };
      if constexpr (Steps::place == BodyPlace::leaf)
        if (to.adds) return step(std::true_type{});
      step(std::false_type{});
    });
    if (to.sibling) buffers.add_sibling(b, flags, a);
  }
  buffers.suspend_inward(run, a);
}

template <class T>
template <class K>
void Sweep<T>::outboard_derived(const KernelRun& run, const Outboard<T>& base) const {
  const auto order = tree.order();
  const auto node_flags = tree.node_flags();
  auto* const records = workspace.template records_of<K>(tree, run);
  Outboard<T> a;
  buffers.resume_outward(run, a);
  for (int i = run.begin; i < run.end; ++i) {
    const int b = order[static_cast<std::size_t>(i)];
    const unsigned flags = node_flags[static_cast<std::size_t>(i)];
    const LinkConstants& link = tree.link(b);
    const int at = tree.first_p(b);
    buffers.load_parent(b, flags, base, a);
    with_derived_steps<DerivedSteps, K, momentum_forms<K>>(link, detail::place_of(flags), [&](auto tag) MOMENTREE_INLINE_LAMBDA {
      using Steps = typename decltype(tag)::type;
      Steps::template outboard<T>(link, tree.subtree_mass(b), joint_state(b), p + at,
                                  detail::derived_record<T, Steps>(records[i - run.begin]), a, workspace.v.get() + at,
                                  workspace.pdot.get() + at, workspace.qdot.get() + tree.first_q(b));
    });
    buffers.store_for_children(b, flags, a);
  }
  buffers.suspend_outward(run, a);
}

}  // namespace momentree
