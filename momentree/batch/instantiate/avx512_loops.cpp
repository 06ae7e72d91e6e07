#include <momentree/batch/loop_lanes.ipp>

namespace momentree::batch {
LoopLanes* make_avx512_loops(const Tree& tree) {
  return new PackLoopLanes<Pack<double, 8, Isa::avx512>>(tree, StepWidth::double_8);
}
}  // namespace momentree::batch
