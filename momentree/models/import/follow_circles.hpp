#pragma once
// Finds cycles among joints that follow others, in models (mimic) and in scenarios ([[coupling]]).
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace momentree::io {

/// Cycles among pairs of (follower, leader), each listed from one of its joints back to itself; at most the first twenty. Empty
/// only if there is no cycle.
std::vector<std::vector<int>> circles_of(const std::vector<std::pair<int, int>>& pairs);

/// "joint 'a' follows 'b', which follows 'a'"; the middle of a long cycle is omitted.
std::string circle_text(const std::vector<int>& circle, const std::function<std::string(int)>& name);

}  // namespace momentree::io
