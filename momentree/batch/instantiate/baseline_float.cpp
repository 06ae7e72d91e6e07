#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_baseline_float(const Tree& tree) {
  return new PackMomentaStepper<Pack<float, 4, Isa::baseline>>(tree, StepWidth::float_4);
}
}  // namespace momentree::batch
