#pragma once
// TOML 1.0 text as values with their lines and columns. The parser itself is in toml.cpp alone.
#include <optional>
#include <string>
#include <string_view>

#include <momentree/base/value.hpp>
#include <momentree/text/syntax_error.hpp>

namespace momentree::io {

/// The document as a table; nothing, with `error` set, if it is not TOML. A byte order mark and CRLF are accepted. In addition
/// to invalid TOML, nesting deeper than any scenario needs is refused, so that no text can exhaust the stack.
std::optional<Value> parse_toml(std::string_view text, SyntaxError& error);

/// One value as it would be written after `key = `, with every place in it set to `place`; nothing if it is not a value: `error`
/// then says why, if the parser does.
std::optional<Value> parse_toml_value(std::string_view text, Place place, SyntaxError* error = nullptr);

}  // namespace momentree::io
