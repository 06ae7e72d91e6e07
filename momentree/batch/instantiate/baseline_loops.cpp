#include <momentree/batch/loop_lanes.ipp>

namespace momentree::batch {
Stepper* make_baseline_loops(const Tree& tree) { return new PackLoopStepper<Pack<double, 2, Isa::baseline>>(tree); }
}  // namespace momentree::batch
