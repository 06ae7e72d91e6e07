#include <momentree/dynamics/twin_sweep.ipp>

namespace momentree {

template <bool Keep>
void twins_inboard(const Tree& tree, const Segment& second, bool falls, const double* p, Work<double>& work) noexcept {
  if constexpr (has_twin_lanes) {
    const TwinSweep sweep{tree, p, work, twin_of(second), second};
    if (second.kind == Kind::weld)
      sweep.welds_inboard<Keep>();
    else
      falls ? sweep.pins_inboard<true, Keep>() : sweep.pins_inboard<false, Keep>();
  }
}
template <bool Keep>
void twins_outboard(const Tree& tree, const Segment& first, bool falls, const Outboard<double>& base, const double* p,
                    Work<double>& work) noexcept {
  if constexpr (has_twin_lanes) {
    const TwinSweep sweep{tree, p, work, first, twin_of(first)};
    if (first.kind == Kind::weld)
      sweep.welds_outboard<Keep>(base);
    else
      falls ? sweep.pins_outboard<true, Keep>(base) : sweep.pins_outboard<false, Keep>(base);
  }
}

template void twins_inboard<false>(const Tree&, const Segment&, bool, const double*, Work<double>&) noexcept;
template void twins_inboard<true>(const Tree&, const Segment&, bool, const double*, Work<double>&) noexcept;
template void twins_outboard<false>(const Tree&, const Segment&, bool, const Outboard<double>&, const double*,
                                    Work<double>&) noexcept;
template void twins_outboard<true>(const Tree&, const Segment&, bool, const Outboard<double>&, const double*,
                                   Work<double>&) noexcept;

}  // namespace momentree
