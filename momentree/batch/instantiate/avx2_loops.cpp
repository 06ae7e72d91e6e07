#include <momentree/batch/loop_lanes.ipp>

namespace momentree::batch {
LoopLanes* make_avx2_loops(const Tree& tree) { return new PackLoopLanes<Pack<double, 4, Isa::avx2>>(tree, StepWidth::double_4); }
}  // namespace momentree::batch
