#pragma once
// Characters of UTF-8, and how texts from files, names and command lines are shown to people.
#include <cstddef>
#include <string>
#include <string_view>

namespace momentree {

/// Length of the UTF-8 character at text[i]; 0 if there is no valid character.
std::size_t character_length(std::string_view text, std::size_t i);

/// The code point of one valid UTF-8 character.
char32_t code_point(std::string_view character);

/// False for characters that a terminal would obey or a reader would not see: control characters, line and paragraph separators,
/// marks of direction, and whatever else has no shape of its own.
bool is_visible(char32_t c);

/// The first byte of `text` that belongs to no visible character, or npos. Joiners (U+200C, U+200D) count as visible between
/// letters beyond ASCII, where scripts and emoji need them.
std::size_t first_invisible(std::string_view text);

/// Appends the character at text[i] as it is shown, and returns its length in bytes: invisible ones as \n, \x1b or \u202e, a byte
/// that is not UTF-8 as U+FFFD.
std::size_t append_printable(std::string& out, std::string_view text, std::size_t i);

/// `text` as it is shown on one line; tabs stay. Every message goes through this: no text from outside commands a terminal.
std::string printable(std::string_view text);

}  // namespace momentree
