#include <new>

#include <momentree/derive/symbolic.hpp>
#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/dynamics/velocity.ipp>
#include <momentree/generate/recording.hpp>

namespace momentree {
using T = Symbolic;
template void evaluate_rates<T>(const Tree&, const T*, const T*, Workspace<T>&) noexcept;
template void sweep_velocities<T, false>(const Tree&, const T*, const T*, Workspace<T>&) noexcept;
template void solve_accelerations<T, false>(const Tree&, const T*, Workspace<T>&, const Motion<T>&) noexcept;

void detail::record_steps(const Tree& tree, Variables variables, Workspace<T>& workspace) {
  const bool momenta = variables == Variables::momenta;
  auto& steps = workspace.table(momenta ? Passes::stage_momenta : Passes::stage_velocities);
  steps = make_step_table(momenta ? interpreting_scalar<T, Passes::stage_momenta>()
                                  : interpreting_scalar<T, Passes::stage_velocities>());
  if (!steps->follow(tree)) throw std::bad_alloc();
}
}  // namespace momentree
