#pragma once
// Numbers as base64 text (RFC 4648) that a page can decode itself: little-endian IEEE 754.
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace momentree::io {

void append_base64(std::string& text, std::span<const unsigned char> bytes);
void append_doubles(std::string& text, std::span<const double> numbers);
/// Rounded to single precision: at least six digits at half the size.
void append_floats(std::string& text, std::span<const double> numbers);
/// The bytes of a text; nothing if it has another character than the 64 and blanks, or a wrong length. `=` at the end is
/// optional.
std::optional<std::string> from_base64(std::string_view text);

}  // namespace momentree::io
