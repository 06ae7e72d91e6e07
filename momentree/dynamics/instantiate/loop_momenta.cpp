#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/loop_momenta.hpp>

namespace momentree::detail {

namespace {
struct SolveLoops {
  static constexpr bool in_pairs = false;
  const Tree& tree;
  const double* q;
  Workspace<double>& workspace;
  LoopRows rows;
  void operator()() const { solve_momenta_of_loops(tree, q, workspace, rows); }
};
}  // namespace

void sweep_momenta(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace, LoopRows rows) noexcept {
  sweep_rates<double, true>(tree, q, p, workspace, SolveLoops{tree, q, workspace, rows});
}

}  // namespace momentree::detail
