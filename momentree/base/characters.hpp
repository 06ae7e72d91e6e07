#pragma once
// UTF-8 characters, and the display of texts from files, names and command lines.
#include <cstddef>
#include <string>
#include <string_view>

namespace momentree {

/// Length (bytes) of the UTF-8 character at text[i]; 0 if there is no valid character.
std::size_t character_length(std::string_view text, std::size_t i);

/// The code point of one valid UTF-8 character.
char32_t code_point(std::string_view character);

/// False for characters that control a terminal or are not visible to a reader: control characters, line and paragraph
/// separators, directional marks, and others without a shape.
bool is_visible(char32_t c);

/// Index of the first byte of `text` that is not part of a visible character, or npos. Joiners (U+200C, U+200D) count as visible
/// between non-ASCII letters, because scripts and emoji need them there.
std::size_t first_invisible(std::string_view text);

/// Appends the displayed form of the character at text[i], and returns the character's length in bytes: invisible characters
/// appear as \n, \x1b or \u202e, a byte that is not UTF-8 as U+FFFD.
std::size_t append_printable(std::string& out, std::string_view text, std::size_t i);

/// `text` as displayed on one line; tabs are kept. Every message is passed through this, so that no external text can control a
/// terminal.
std::string printable(std::string_view text);

}  // namespace momentree
