#include <momentree/dynamics/loops/loop_place.ipp>

namespace momentree::detail {
template void place_closures<double>(const Tree&, const double*, Workspace<double>&, LoopSystem<double>&, bool,
                                     LoopRows) noexcept;
template void place_other_rows<double>(const Tree&, const double*, const Workspace<double>&, LoopSystem<double>&, bool) noexcept;
template void soften<double>(LoopSystem<double>&) noexcept;
template void scale_rows<double>(const Tree&, const Workspace<double>&, LoopSystem<double>&) noexcept;
template void gather_loops<double>(const Tree&, const double*, Workspace<double>&, LoopSystem<double>&, const Motion<double>&,
                                   bool) noexcept;
template void factorise_loops<double>(LoopSystem<double>&) noexcept;
template void apply_multipliers<double>(const Tree&, const double*, Workspace<double>&, LoopSystem<double>&) noexcept;
template void add_loop_forces<double>(const Tree&, const double*, Workspace<double>&, LoopSystem<double>&, Power*,
                                      const double*) noexcept;
}  // namespace momentree::detail
