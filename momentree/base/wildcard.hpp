#pragma once
// Names with `*`.
#include <string_view>

namespace momentree {

/// `*` matches any sequence of characters except '/'.
bool matches_wildcard(std::string_view pattern, std::string_view name);

/// True if the name, which may contain `*`, is that of a body or of its mechanism: the part of the body's name before a '/'.
bool names_body(std::string_view name, std::string_view body);

}  // namespace momentree
