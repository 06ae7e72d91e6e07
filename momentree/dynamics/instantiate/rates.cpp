#include <momentree/dynamics/forward.ipp>

namespace momentree {
template void evaluate_rates<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void evaluate_motions<double>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;

StepScalar detail::double_momenta() { return step_scalar<double, true>(StepWidth::one); }
}  // namespace momentree
