#include <momentree/dynamics/derived_sweep.ipp>

namespace momentree {
#define MOMENTREE_INSTANTIATE(name, Type)                                                       \
  template void Sweep<double>::inboard_derived<typename Type::Kernels>(const KernelRun&) const; \
  template void Sweep<double>::outboard_derived<typename Type::Kernels>(const KernelRun&, const Outboard<double>&) const;
MOMENTREE_DERIVED(MOMENTREE_INSTANTIATE)
#undef MOMENTREE_INSTANTIATE
}  // namespace momentree
