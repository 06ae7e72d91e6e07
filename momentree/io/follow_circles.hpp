#pragma once
// Joints that follow others, in models (mimic) and in scenarios ([[coupling]]): who follows itself by way of others.
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace momentree::io {

/// Circles among pairs of a follower and its leader, each from one of its joints round to it again; the first twenty that are
/// found; empty only if there is none.
std::vector<std::vector<int>> circles_of(const std::vector<std::pair<int, int>>& pairs);

/// "joint 'a' follows 'b', which follows 'a'"; a long one without its middle.
std::string circle_text(const std::vector<int>& circle, const std::function<std::string(int)>& name);

}  // namespace momentree::io
