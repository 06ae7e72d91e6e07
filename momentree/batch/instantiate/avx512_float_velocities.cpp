#include <momentree/batch/velocity_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx512_float_velocities(const Tree& tree) {
  return new PackVelocityStepper<Pack<float, 16, Isa::avx512>>(tree, StepWidth::float_16);
}
}  // namespace momentree::batch
