#include <momentree/batch/momenta_stepper.ipp>

namespace momentree::batch {
Stepper* make_avx512_double(const Tree& tree) { return new PackMomentaStepper<Pack<double, 8, Isa::avx512>>(tree); }
}  // namespace momentree::batch
