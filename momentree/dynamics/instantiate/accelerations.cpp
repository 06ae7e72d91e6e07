#include <momentree/dynamics/acceleration.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>

namespace momentree {
template void evaluate_accelerations<double>(const Tree&, const double*, Workspace<double>&) noexcept;
template void solve_with_factors<double>(const Tree&, const double*, Workspace<double>&, double*, int, int) noexcept;

StepScalar detail::double_accelerations(bool solutions) {
  return solutions ? step_scalar<double, Passes::solutions>(StepWidth::one) : step_scalar<double, Passes::rates>(StepWidth::one);
}
}  // namespace momentree
