#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
TreeStepper* make_avx512_double(const Tree& tree) {
  return new PackMomentaStepper<Pack<double, 8, Isa::avx512>>(tree, StepWidth::double_8);
}
}  // namespace momentree::batch
