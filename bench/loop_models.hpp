#pragma once
// Mechanisms with closed loops for the benchmarks: gravity, no damping.
#include <momentree/model/model.hpp>

namespace momentree::bench {

/// Crank, coupler and rocker; all axes parallel, not along an axis of the world.
Model four_bar(int bodies = 3);
/// Windows in a row, as in the IFToMM benchmark A02: 2 n + 1 rods of 1 m, n + 1 of them on revolute joints to the ground.
Model four_bars(int windows);
/// A chain of ball joints between two points of the ground.
Model suspended_chain(int bodies);
/// A free ring: a chain of revolute joints in general position whose last body is joined to the first by a ball joint.
Model ring(int bodies);
/// Two arms of 7 revolute joints that hold one bar by both hands.
Model two_arms(int bodies = 15);
/// The humanoid with both feet welded to the ground.
Model standing_humanoid(int bodies = 31);

}  // namespace momentree::bench
