#include <momentree/dynamics/solve.ipp>

namespace momentree {
template void solve_with_factors<double>(const Tree&, const double*, Workspace<double>&, double*, int, int) noexcept;
}  // namespace momentree
