#include <momentree/derive/symbolic.hpp>
#include <momentree/dynamics/derived_velocity.ipp>

namespace momentree {
template void sweep_velocities<Symbolic<false>, false>(const Tree&, const Symbolic<false>*, const Symbolic<false>*,
                                                       Workspace<Symbolic<false>>&) noexcept;
template void sweep_velocities<Symbolic<true>, false>(const Tree&, const Symbolic<true>*, const Symbolic<true>*,
                                                      Workspace<Symbolic<true>>&) noexcept;
template void solve_accelerations<Symbolic<false>, false>(const Tree&, const Symbolic<false>*, Workspace<Symbolic<false>>&,
                                                          const Motion<Symbolic<false>>&) noexcept;
template void solve_accelerations<Symbolic<true>, false>(const Tree&, const Symbolic<true>*, Workspace<Symbolic<true>>&,
                                                         const Motion<Symbolic<true>>&) noexcept;
}  // namespace momentree
