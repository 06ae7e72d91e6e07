#pragma once
// The tables behind mistakes.hpp. Internal to it.
#include <span>

#include <momentree/scenario/mistakes/mistakes.hpp>

namespace momentree::io::mistakes {

std::span<const Mistake> of_runs();    ///< the whole scenario, [world], [integrate], [output]
std::span<const Mistake> of_models();  ///< mechanisms, bodies, joints and what they have
std::span<const Mistake> of_events();  ///< events, conditions, actions, forces, springs, couplings

}  // namespace momentree::io::mistakes
