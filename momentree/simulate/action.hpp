#pragma once
// Actions by name, for Simulation and scenario files. Each stands in its own file in actions/.
#include <string>
#include <string_view>
#include <vector>

namespace momentree {

/// One action of an event. `key` is the scenario key ("break"); `targets` the joints or bodies it names.
struct Action {
  std::string key;
  std::vector<std::string> targets;
};
/// Removes a joint: the child's subtree becomes a mechanism of its own.
inline Action break_joint(std::string joint) { return {"break", {std::move(joint)}}; }

}  // namespace momentree
