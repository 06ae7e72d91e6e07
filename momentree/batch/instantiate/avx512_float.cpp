#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx512_float(const Tree& tree) {
  return new PackMomentaStepper<Pack<float, 16, Isa::avx512>>(tree, StepWidth::float_16);
}
}  // namespace momentree::batch
