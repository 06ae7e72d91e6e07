#include <momentree/dynamics/generic_steps.ipp>
#include <momentree/dynamics/velocity.hpp>

namespace momentree {
template void sweep_velocities<double, false>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void sweep_velocities<double, true>(const Tree&, const double*, const double*, Workspace<double>&) noexcept;
template void reduce_accelerations<double, true>(const Tree&, const double*, Workspace<double>&) noexcept;
template void resolve_accelerations<double, true>(const Tree&, const double*, Workspace<double>&, const Motion<double>&) noexcept;
template void solve_accelerations<double, false>(const Tree&, const double*, Workspace<double>&, const Motion<double>&) noexcept;
template void solve_accelerations<double, true>(const Tree&, const double*, Workspace<double>&, const Motion<double>&) noexcept;

std::array<StepFunction, derive::Step::passes> generic_steps(Kind kind, Variant variant, bool adds) noexcept {
  return dispatch_kernels(kind, variant, [adds](auto tag) -> std::array<StepFunction, derive::Step::passes> {
    using K = typename decltype(tag)::type;
    if constexpr (K::rigid || requires { typename K::Steps; }) {
      return {};  // welds are part of other bodies, and these kernels have machine code
    } else {
      using Steps = GenericSteps<K>;
      return {Steps::velocities, adds ? Steps::template inboard<true> : Steps::template inboard<false>, Steps::outboard};
    }
  });
}
}  // namespace momentree
