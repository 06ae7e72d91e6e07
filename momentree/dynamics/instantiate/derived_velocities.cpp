#include <momentree/dynamics/derived_velocity.ipp>

namespace momentree {
#define MOMENTREE_INSTANTIATE_KERNELS(K)                                                     \
  template void VelocitySweep<double, false>::velocities_derived<K>(const KernelRun&) const; \
  template void VelocitySweep<double, false>::inboard_derived<K>(const KernelRun&) const;    \
  template void VelocitySweep<double, false>::outboard_derived<K>(const KernelRun&, const Motion<double>&) const;
#define MOMENTREE_INSTANTIATE(name, Type) MOMENTREE_INSTANTIATE_KERNELS(typename Type::Kernels)
MOMENTREE_VELOCITY_DERIVED(MOMENTREE_INSTANTIATE)
MOMENTREE_INSTANTIATE_KERNELS(ArmatureKernels)
#undef MOMENTREE_INSTANTIATE
#undef MOMENTREE_INSTANTIATE_KERNELS
}  // namespace momentree
