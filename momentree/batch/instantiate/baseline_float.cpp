#include <momentree/batch/stepper.ipp>

namespace momentree::batch {
Stepper* make_baseline_float(const Tree& tree) { return new PackStepper<Pack<float, 4, Isa::baseline>>(tree); }
}  // namespace momentree::batch
