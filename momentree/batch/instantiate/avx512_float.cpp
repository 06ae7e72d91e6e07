#include <momentree/batch/stepper.ipp>

namespace momentree::batch {
Stepper* make_avx512_float(const Tree& tree) { return new PackStepper<Pack<float, 16, Isa::avx512>>(tree); }
}  // namespace momentree::batch
