#pragma once
// Numbers as base64 text (RFC 4648) that a page can decode itself: little-endian IEEE 754.
#include <span>
#include <string>

namespace momentree::io {

void append_base64(std::string& text, std::span<const unsigned char> bytes);
void append_doubles(std::string& text, std::span<const double> numbers);
/// Rounded to single precision: at least six digits at half the size.
void append_floats(std::string& text, std::span<const double> numbers);

}  // namespace momentree::io
