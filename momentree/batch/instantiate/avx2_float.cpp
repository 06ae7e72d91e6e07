#include <momentree/batch/stepper.ipp>

namespace momentree::batch {
Stepper* make_avx2_float(const Tree& tree) { return new PackStepper<Pack<float, 8, Isa::avx2>>(tree); }
}  // namespace momentree::batch
