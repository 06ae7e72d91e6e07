#include <momentree/dynamics/derived_sweep.ipp>
#include <momentree/math/counted.hpp>

namespace momentree {
template void evaluate_rates<Counted>(const Tree&, const Counted*, const Counted*, Workspace<Counted>&) noexcept;
}  // namespace momentree
