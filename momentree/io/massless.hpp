#pragma once
// A body that moves between two masses and has none: legal, but seldom meant. Of models and of scenarios.
#include <span>
#include <string>
#include <vector>

#include <momentree/tree/model.hpp>

namespace momentree::io {

/// Their numbers; parents stand before their children. Names of carriers, `body.joint`, are meant.
std::vector<int> massless_links(std::span<const BodySpec* const> bodies);
std::string massless_link(const std::string& name);  ///< what is said of one
inline constexpr const char* massless_hint = "is its inertia missing?";

}  // namespace momentree::io
