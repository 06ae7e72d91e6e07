#pragma once
// Checks of TOML text before and after the parser: invalid bytes, nesting depth, and hints for common slips.
#include <optional>
#include <string>
#include <string_view>

#include <momentree/text/toml.hpp>

namespace momentree::io {

/// Invalid UTF-8, a zero byte, the last plane of Unicode, nesting deeper than any scenario needs (tables by dotted keys: the
/// parser does not bound them), or characters beyond ASCII outside of strings and comments.
std::optional<SyntaxError> check_toml_text(std::string_view text);

/// The text with every character from U+0080 to U+FFFF moved to the private plane from U+100000, and back. toml++ 3.3 tests
/// whether such characters are white space, even within strings, and for some of them the result is undefined. One character
/// stays one character, so that columns are preserved. Valid UTF-8 only.
std::string escape_unsupported(std::string_view text);
std::string unshielded(std::string_view text);

/// Line number `line`, counted from 1, without its line end.
std::string_view line_of(std::string_view text, int line);

/// Rewrites the parser's message in plainer words if possible, and returns a hint for fixing `line`; empty if there is none.
std::string explain_syntax(std::string& what, std::string_view line, int column);

}  // namespace momentree::io
