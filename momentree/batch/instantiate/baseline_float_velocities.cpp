#include <momentree/batch/velocity_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_baseline_float_velocities(const Tree& tree) {
  return new PackVelocityStepper<Pack<float, 4, Isa::baseline>>(tree, StepWidth::float_4);
}
}  // namespace momentree::batch
