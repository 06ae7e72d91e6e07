#include <momentree/dynamics/pair_sweep.ipp>

namespace momentree {

namespace {

/// Calls f(tag of the kernels, std::bool_constant<has gravity>).
template <class F>
void dispatch_revolutes(const KernelRun& run, bool has_gravity, F&& f) {
  const auto with = [&](auto gravity) {
    if (run.variant == Variant::armature)
      f(std::type_identity<ArmatureKernels>{}, gravity);
    else
      f(std::type_identity<RevoluteKernels>{}, gravity);
  };
  if (has_gravity)
    with(std::true_type{});
  else
    with(std::false_type{});
}

}  // namespace

template <bool Keep>
void pairs_inboard(const Tree& tree, const KernelRun& second, bool has_gravity, const double* p,
                   Workspace<double>& workspace) noexcept {
  if constexpr (has_pair_lanes) {
    const PairSweep sweep{tree, p, workspace, pair_of(second), second};
    if (second.kind == Kind::weld)
      sweep.welds_inboard<Keep>();
    else
      dispatch_revolutes(second, has_gravity, [&](auto tag, auto gravity) {
        sweep.revolutes_inboard<typename decltype(tag)::type, gravity(), Keep>();
      });
  }
}
template <bool Keep>
void pairs_outboard(const Tree& tree, const KernelRun& first, bool has_gravity, const Outboard<double>& base, const double* p,
                    Workspace<double>& workspace) noexcept {
  if constexpr (has_pair_lanes) {
    const PairSweep sweep{tree, p, workspace, first, pair_of(first)};
    if (first.kind == Kind::weld)
      sweep.welds_outboard<Keep>(base);
    else
      dispatch_revolutes(first, has_gravity, [&](auto tag, auto gravity) {
        sweep.revolutes_outboard<typename decltype(tag)::type, gravity(), Keep>(base);
      });
  }
}

template void pairs_inboard<false>(const Tree&, const KernelRun&, bool, const double*, Workspace<double>&) noexcept;
template void pairs_inboard<true>(const Tree&, const KernelRun&, bool, const double*, Workspace<double>&) noexcept;
template void pairs_outboard<false>(const Tree&, const KernelRun&, bool, const Outboard<double>&, const double*,
                                    Workspace<double>&) noexcept;
template void pairs_outboard<true>(const Tree&, const KernelRun&, bool, const Outboard<double>&, const double*,
                                   Workspace<double>&) noexcept;

}  // namespace momentree
