#include <momentree/batch/loop_lanes.ipp>

namespace momentree::batch {
Stepper* make_avx2_loops(const Tree& tree) { return new PackLoopStepper<Pack<double, 4, Isa::avx2>>(tree); }
}  // namespace momentree::batch
