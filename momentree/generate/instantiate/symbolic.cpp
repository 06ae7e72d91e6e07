#include <momentree/derive/symbolic.hpp>
#include <momentree/dynamics/derived_sweep.ipp>

namespace momentree {
template void evaluate_rates<Symbolic<false>>(const Tree&, const Symbolic<false>*, const Symbolic<false>*,
                                              Workspace<Symbolic<false>>&) noexcept;
template void evaluate_rates<Symbolic<true>>(const Tree&, const Symbolic<true>*, const Symbolic<true>*,
                                             Workspace<Symbolic<true>>&) noexcept;
}  // namespace momentree
