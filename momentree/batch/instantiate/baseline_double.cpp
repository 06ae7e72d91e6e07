#include <momentree/batch/stepper.ipp>

namespace momentree::batch {
Stepper* make_baseline_double(const Tree& tree) { return new PackStepper<Pack<double, 2, Isa::baseline>>(tree); }
}  // namespace momentree::batch
