#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/loop_momenta.hpp>

namespace momentree::detail {

namespace {
struct SolveLoops {
  static void act(const Tree& tree, const double* q, Workspace<double>& workspace) { solve_momenta_of_loops(tree, q, workspace); }
};
}  // namespace

void sweep_momenta(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace) noexcept {
  sweep_motions<double, SolveLoops>(tree, q, p, workspace);
}

}  // namespace momentree::detail
