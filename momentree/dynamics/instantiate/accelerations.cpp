#include <momentree/dynamics/acceleration.ipp>

namespace momentree {
template void evaluate_accelerations<double>(const Tree&, const double*, Workspace<double>&) noexcept;
}  // namespace momentree
