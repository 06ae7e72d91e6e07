#pragma once
// The passes in velocities over kernel runs of kinds with derived steps, in a stage; included as velocity.ipp is.
#include <momentree/dynamics/derived_place.hpp>
#include <momentree/dynamics/velocity.ipp>
#include <momentree/joint/all_velocity_derived.hpp>  // generated: includes every file of derived_velocity/

namespace momentree {

namespace detail {
/// Calls f with the steps in velocities for the link of a body with these node flags.
template <class K, class F>
MOMENTREE_INLINE void with_velocity_steps(const LinkConstants& link, unsigned flags, F&& f) {
  with_derived_steps<DerivedVelocitySteps, K, velocity_forms<K>>(link, place_of(flags), f);
}
}  // namespace detail

template <class T, bool Keep>
template <class K>
void VelocitySweep<T, Keep>::velocities_derived(const KernelRun& run) const {
  const auto order = tree.order();
  const auto node_flags = tree.node_flags();
  auto* const records = workspace.template records_of<K>(tree, run);
  Motion<T> a;
  buffers.resume_outward(run, a);
  for (int i = run.begin; i < run.end; ++i) {
    const int b = order[static_cast<std::size_t>(i)];
    const unsigned flags = node_flags[static_cast<std::size_t>(i)];
    const LinkConstants& link = tree.link(b);
    buffers.load_parent(b, flags, {}, a);
    detail::with_velocity_steps<K>(link, flags, [&](auto tag) MOMENTREE_INLINE_LAMBDA {
      using Steps = typename decltype(tag)::type;
      Steps::template velocities<T>(link, joint_state(b), workspace.v.get() + tree.first_p(b),
                                    detail::derived_record<T, Steps>(records[i - run.begin]), a,
                                    workspace.qdot.get() + tree.first_q(b));
    });
    buffers.store_for_children(b, flags, a);
  }
  buffers.suspend_outward(run, a);
}

template <class T, bool Keep>
template <class K>
void VelocitySweep<T, Keep>::inboard_derived(const KernelRun& run) const {
  const auto order = tree.order();
  const auto node_flags = tree.node_flags();
  auto* const records = workspace.template records_of<K>(tree, run);
  Inboard<T> a;
  buffers.resume_inward(run, a);
  for (int i = run.end - 1; i >= run.begin; --i) {
    const int b = order[static_cast<std::size_t>(i)];
    const unsigned flags = node_flags[static_cast<std::size_t>(i)];
    const LinkConstants& link = tree.link(b);
    const int at = tree.first_p(b);
    if ((flags & node::leaf) == 0) buffers.gather_children(b, flags, a);
    const detail::Destinations to(flags);
    Inboard<T>& sum = to.parent_sum ? buffers.child_sums[tree.parent(b)] : a;
    detail::with_velocity_steps<K>(link, flags, [&](auto tag) MOMENTREE_INLINE_LAMBDA {
      using Steps = typename decltype(tag)::type;
      const auto step = [&](auto adds) MOMENTREE_INLINE_LAMBDA {
        Steps::template inboard<adds(), T>(link, tree.armature()[at], joint_state(b), workspace.a.get() + at, a,
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

template <class T, bool Keep>
template <class K>
void VelocitySweep<T, Keep>::outboard_derived(const KernelRun& run, const Motion<T>& base) const {
  const auto order = tree.order();
  const auto node_flags = tree.node_flags();
  auto* const records = workspace.template records_of<K>(tree, run);
  Motion<T> a;
  buffers.resume_outward(run, a);
  for (int i = run.begin; i < run.end; ++i) {
    const int b = order[static_cast<std::size_t>(i)];
    const unsigned flags = node_flags[static_cast<std::size_t>(i)];
    const LinkConstants& link = tree.link(b);
    buffers.load_parent(b, flags, base, a);
    detail::with_velocity_steps<K>(link, flags, [&](auto tag) MOMENTREE_INLINE_LAMBDA {
      using Steps = typename decltype(tag)::type;
      Steps::template outboard<T>(link, joint_state(b), detail::derived_record<T, Steps>(records[i - run.begin]), a,
                                  workspace.a.get() + tree.first_p(b));
    });
    buffers.store_for_children(b, flags, a);
  }
  buffers.suspend_outward(run, a);
}

}  // namespace momentree
