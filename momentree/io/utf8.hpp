#pragma once
// Texts by their characters: what every reader of a file asks before its parser does.
#include <cstddef>
#include <optional>
#include <string_view>

#include <momentree/base/characters.hpp>
#include <momentree/io/syntax_error.hpp>

namespace momentree::io {

/// Line and column, in characters, of the byte text[end].
Place place_at(std::string_view text, std::size_t end);

/// The first byte that is no UTF-8, or zero.
std::optional<SyntaxError> check_utf8(std::string_view text);

}  // namespace momentree::io
