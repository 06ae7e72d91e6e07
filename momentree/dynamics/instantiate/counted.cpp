#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/steps/generic_steps.ipp>
#include <momentree/math/counted.hpp>

namespace momentree {
template void evaluate_rates<Counted>(const Tree&, const Counted*, const Counted*, Workspace<Counted>&) noexcept;

StepScalar detail::counting_scalar() { return interpreting_scalar<Counted, Passes::stage_momenta>(); }
}  // namespace momentree
