#include <momentree/derive/symbolic.hpp>
#include <momentree/dynamics/loops/loop_place.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/dynamics/velocity.ipp>
#include <momentree/generate/recording.hpp>

namespace momentree {
#define MOMENTREE_LOOPS_OF(T)                                                                                                   \
  template void sweep_velocities<T, true>(const Tree&, const T*, const T*, Workspace<T>&) noexcept;                             \
  template void reduce_accelerations<T, true>(const Tree&, const T*, Workspace<T>&) noexcept;                                   \
  template void resolve_accelerations<T, true>(const Tree&, const T*, Workspace<T>&, const Motion<T>&) noexcept;                \
  template void detail::place_closures<T>(const Tree&, const T*, Workspace<T>&, LoopSystem<T>&, bool, LoopRows) noexcept;       \
  template void detail::soften<T>(LoopSystem<T>&) noexcept;                                                                     \
  template void detail::gather_loops<T>(const Tree&, const T*, Workspace<T>&, LoopSystem<T>&, const Motion<T>&, bool) noexcept; \
  template void detail::apply_multipliers<T>(const Tree&, const T*, Workspace<T>&, LoopSystem<T>&) noexcept;
MOMENTREE_LOOPS_OF(Symbolic)
#undef MOMENTREE_LOOPS_OF

void detail::record_kept_steps(const Tree& tree, Workspace<Symbolic>& workspace) {
  workspace.table(Passes::velocities) =
      make_step_table(step_scalar<Symbolic, Passes::velocities>(StepWidth::none), tree.bodies());
}
}  // namespace momentree
