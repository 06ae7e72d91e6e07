#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
Stepper* make_avx512_float(const Tree& tree) { return new PackMomentaStepper<Pack<float, 16, Isa::avx512>>(tree); }
}  // namespace momentree::batch
