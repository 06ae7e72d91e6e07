#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
Stepper* make_avx2_float(const Tree& tree) { return new PackMomentaStepper<Pack<float, 8, Isa::avx2>>(tree); }
}  // namespace momentree::batch
