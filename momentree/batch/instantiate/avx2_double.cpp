#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx2_double(const Tree& tree) {
  return new PackMomentaStepper<Pack<double, 4, Isa::avx2>>(tree, StepWidth::double_4);
}
}  // namespace momentree::batch
