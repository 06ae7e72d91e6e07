#pragma once
// What is looked at in a TOML text before and after the parser: bytes that no text has, depth, and hints for common slips.
#include <optional>
#include <string>
#include <string_view>

#include <momentree/io/toml.hpp>

namespace momentree::io {

/// Invalid UTF-8, a zero byte, the last plane of Unicode, nesting that no scenario has (tables by dotted keys: the parser does
/// not bound them), or characters beyond ASCII outside of strings and comments.
std::optional<SyntaxError> check_toml_text(std::string_view text);

/// The text with every character from U+0080 to U+FFFF moved to the private plane from U+100000, and back: toml++ 3.3 asks of
/// such characters, even within strings, whether they are white space, and for some of them its answer is undefined. One
/// character stays one, so that columns do. Valid UTF-8 only.
std::string escape_unsupported(std::string_view text);
std::string unshielded(std::string_view text);

/// The line-th line, from 1, without its end.
std::string_view line_of(std::string_view text, int line);

/// Makes the parser's message plainer where it can be, and says how to mend what it did not understand in `line`; empty if there
/// is nothing to guess.
std::string explain_syntax(std::string& what, std::string_view line, int column);

}  // namespace momentree::io
