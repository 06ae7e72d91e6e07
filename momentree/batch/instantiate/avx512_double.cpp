#include <momentree/batch/stepper.ipp>

namespace momentree::batch {
Stepper* make_avx512_double(const Tree& tree) { return new PackStepper<Pack<double, 8, Isa::avx512>>(tree); }
}  // namespace momentree::batch
