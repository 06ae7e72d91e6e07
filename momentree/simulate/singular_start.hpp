#pragma once
// Singular positions of closed loops.
#include <vector>

#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// The loop joints that block fewer directions in the present position than in closed positions nearby: from here the mechanism
/// can go on in different ways.
[[nodiscard]] std::vector<JointId> singular_loops(const World& world);

}  // namespace momentree
