#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/loop_momenta.hpp>

namespace momentree::detail {

namespace {
struct SolveLoops {
  static constexpr bool in_pairs = false;
  static void act(const Tree& tree, const double* q, Workspace<double>& workspace) { solve_momenta_of_loops(tree, q, workspace); }
};
}  // namespace

void sweep_momenta(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace) noexcept {
  sweep_rates<double, true, SolveLoops>(tree, q, p, workspace);
}

}  // namespace momentree::detail
