#include <momentree/batch/stepper.ipp>

namespace momentree::batch {
Stepper* make_avx2_double(const Tree& tree) { return new PackStepper<Pack<double, 4, Isa::avx2>>(tree); }
}  // namespace momentree::batch
