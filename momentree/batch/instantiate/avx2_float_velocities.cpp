#include <momentree/batch/velocity_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx2_float_velocities(const Tree& tree) {
  return new PackVelocityStepper<Pack<float, 8, Isa::avx2>>(tree, StepWidth::float_8);
}
}  // namespace momentree::batch
