#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/dynamics/velocity.ipp>

namespace momentree {
template void sweep_velocities<double, false>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void sweep_velocities<double, true>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void reduce_accelerations<double, true>(const Tree&, const double*, Workspace<double>&) noexcept;
template void resolve_accelerations<double, true>(const Tree&, const double*, Workspace<double>&, const Motion<double>&) noexcept;
template void solve_accelerations<double, false>(const Tree&, const double*, Workspace<double>&, const Motion<double>&) noexcept;
template void solve_accelerations<double, true>(const Tree&, const double*, Workspace<double>&, const Motion<double>&) noexcept;

StepScalar detail::double_velocities(bool kept) {
  return kept ? step_scalar<double, Passes::velocities>(StepWidth::one)
              : step_scalar<double, Passes::stage_velocities>(StepWidth::one);
}
}  // namespace momentree
