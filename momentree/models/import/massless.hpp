#pragma once
// Finds moving bodies without mass between two bodies with mass: legal, but seldom intended. For models and scenarios.
#include <span>
#include <string>
#include <vector>

#include <momentree/model/model.hpp>

namespace momentree::io {

/// The indices of such bodies in `bodies`, in which parents come before their children. Carriers named `body.joint`, which have
/// no mass on purpose, are not reported.
std::vector<int> massless_links(std::span<const BodySpec* const> bodies);
std::string massless_link(const std::string& name);  ///< the message for one of them
inline constexpr const char* massless_hint = "is its inertia missing?";

}  // namespace momentree::io
