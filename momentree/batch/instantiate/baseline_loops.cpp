#include <momentree/batch/loop_lanes.ipp>

namespace momentree::batch {
LoopLanes* make_baseline_loops(const Tree& tree) {
  return new PackLoopLanes<Pack<double, 2, Isa::baseline>>(tree, StepWidth::double_2);
}
}  // namespace momentree::batch
