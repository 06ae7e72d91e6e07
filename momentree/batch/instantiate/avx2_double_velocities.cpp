#include <momentree/batch/velocity_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx2_double_velocities(const Tree& tree) {
  return new PackVelocityStepper<Pack<double, 4, Isa::avx2>>(tree, StepWidth::double_4);
}
}  // namespace momentree::batch
