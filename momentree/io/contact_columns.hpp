#pragma once
// The rows of contacts.csv, which runs with reactions have if bodies can touch.
#include <string>

#include <momentree/simulate/world.hpp>

namespace momentree::io {

/// `time` (s), the names of both bodies, then point (m), normal, force on the first body (N) and speed of slip (m/s); world axes.
void contact_header(std::string& text);
/// A row for each point at which bodies touch; none if none do.
void contact_rows(std::string& text, const World& world);

}  // namespace momentree::io
