#include <momentree/dynamics/twin_sweep.ipp>

namespace momentree {

namespace {

/// Calls f(tag of the kernels, std::bool_constant<falls>).
template <class F>
void dispatch_pins(const Segment& pins, bool falls, F&& f) {
  const auto with = [&](auto gravity) {
    if (pins.variant == Variant::rotor)
      f(std::type_identity<RotorKernels>{}, gravity);
    else
      f(std::type_identity<RevoluteKernels>{}, gravity);
  };
  if (falls)
    with(std::true_type{});
  else
    with(std::false_type{});
}

}  // namespace

template <bool Keep>
void twins_inboard(const Tree& tree, const Segment& second, bool falls, const double* p, Work<double>& work) noexcept {
  if constexpr (has_twin_lanes) {
    const TwinSweep sweep{tree, p, work, twin_of(second), second};
    if (second.kind == Kind::weld)
      sweep.welds_inboard<Keep>();
    else
      dispatch_pins(second, falls,
                    [&](auto tag, auto gravity) { sweep.pins_inboard<typename decltype(tag)::type, gravity(), Keep>(); });
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
      dispatch_pins(first, falls,
                    [&](auto tag, auto gravity) { sweep.pins_outboard<typename decltype(tag)::type, gravity(), Keep>(base); });
  }
}

template void twins_inboard<false>(const Tree&, const Segment&, bool, const double*, Work<double>&) noexcept;
template void twins_inboard<true>(const Tree&, const Segment&, bool, const double*, Work<double>&) noexcept;
template void twins_outboard<false>(const Tree&, const Segment&, bool, const Outboard<double>&, const double*,
                                    Work<double>&) noexcept;
template void twins_outboard<true>(const Tree&, const Segment&, bool, const Outboard<double>&, const double*,
                                   Work<double>&) noexcept;

}  // namespace momentree
