#pragma once
// Character-level checks of text, used by every file reader before parsing.
#include <cstddef>
#include <optional>
#include <string_view>

#include <momentree/base/characters.hpp>
#include <momentree/text/syntax_error.hpp>

namespace momentree::io {

/// Line and column, in characters, of the byte text[end].
Place place_at(std::string_view text, std::size_t end);

/// The first byte that is not valid UTF-8, or a zero byte.
std::optional<SyntaxError> check_utf8(std::string_view text);

}  // namespace momentree::io
