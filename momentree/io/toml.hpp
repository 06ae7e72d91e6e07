#pragma once
// TOML 1.0 texts as values that know their line and column. The parser itself is in toml.cpp alone.
#include <optional>
#include <string>
#include <string_view>

#include <momentree/base/value.hpp>
#include <momentree/io/syntax_error.hpp>

namespace momentree::io {

/// The document as a table; nothing where it is no TOML, with `error` set. A byte order mark and CRLF are fine. Refused besides
/// what TOML refuses: nesting deeper than any scenario, so that no text can exhaust the stack.
std::optional<Value> parse_toml(std::string_view text, SyntaxError& error);

/// One value as it would stand after `key = `, every place in it being `place`; nothing if it is none.
std::optional<Value> parse_toml_value(std::string_view text, Place place);

}  // namespace momentree::io
