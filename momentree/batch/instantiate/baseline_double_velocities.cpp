#include <momentree/batch/velocity_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_baseline_double_velocities(const Tree& tree) {
  return new PackVelocityStepper<Pack<double, 2, Isa::baseline>>(tree, StepWidth::double_2);
}
}  // namespace momentree::batch
