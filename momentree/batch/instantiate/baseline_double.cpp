#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_baseline_double(const Tree& tree) {
  return new PackMomentaStepper<Pack<double, 2, Isa::baseline>>(tree, StepWidth::double_2);
}
}  // namespace momentree::batch
