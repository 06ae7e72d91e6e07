#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>

namespace momentree {
template void evaluate_rates<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void evaluate_motions<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void reduce_momenta<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void resolve_momenta<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;

StepScalar detail::double_momenta(bool kept) {
  return kept ? step_scalar<double, Passes::momenta>(StepWidth::one) : step_scalar<double, Passes::stage_momenta>(StepWidth::one);
}
}  // namespace momentree
