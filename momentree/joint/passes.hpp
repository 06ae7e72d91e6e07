#pragma once
#include <cstddef>

namespace momentree {

/// Passes over the bodies of a tree. Those of stages store only what they need themselves. The others keep what others read of
/// each body: records in the layout of the kind's kernels, and the quantities of PassBody.
enum class Passes : unsigned char {
  stage_momenta,     ///< inward, outward
  stage_velocities,  ///< outward, inward, outward
  momenta,
  velocities,
  rates,     ///< inward, outward: accelerations after `momenta`
  solutions  ///< inward, outward: further right-hand sides
};
inline constexpr std::size_t kinds_of_passes = 6;
constexpr const char* name_of(Passes passes) {
  constexpr const char* names[] = {"stage in momenta", "stage in velocities", "momenta", "velocities", "rates", "solutions"};
  return names[static_cast<std::size_t>(passes)];
}
constexpr bool in_velocities(Passes passes) { return passes == Passes::stage_velocities || passes == Passes::velocities; }
constexpr bool in_momenta(Passes passes) { return passes == Passes::stage_momenta || passes == Passes::momenta; }
constexpr bool keeps_results(Passes passes) { return passes >= Passes::momenta; }
constexpr std::size_t count_of(Passes passes) { return in_velocities(passes) ? 3 : 2; }
/// Of what a body contributes to its parent, an Inboard or a Force; and of what it hands to its children, an Outboard or a
/// Motion.
constexpr int numbers_of_sum(Passes passes) { return passes >= Passes::rates ? 6 : 30; }
constexpr int numbers_of_motion(Passes passes) { return in_momenta(passes) ? 9 : 6; }

}  // namespace momentree
