#include <momentree/batch/velocity_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx512_double_velocities(const Tree& tree) {
  return new PackVelocityStepper<Pack<double, 8, Isa::avx512>>(tree, StepWidth::double_8);
}
}  // namespace momentree::batch
