#pragma once
// Start values that loops and couplings changed.
#include <optional>
#include <span>
#include <string>

#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// Given start values that a world does not have.
struct ChangedStart {
  std::string what;  ///< "…: 'm/crank' starts at 48.2 rad/s, not at 40 rad/s"
  std::string hint;
  JointId joint;  ///< the first one
};

/// Compares what was given, apart from momenta, with the start of a world; nothing if they differ by round-off.
std::optional<ChangedStart> changed_start(const World& world, std::span<const JointStart> given);
/// The same with the start values of its model.
std::optional<ChangedStart> changed_start(const World& world);

}  // namespace momentree::io
