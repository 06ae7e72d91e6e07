#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx2_float(const Tree& tree) {
  return new PackMomentaStepper<Pack<float, 8, Isa::avx2>>(tree, StepWidth::float_8);
}
}  // namespace momentree::batch
