#pragma once
// Numbers as text that a page reads back by its own means: little-endian IEEE 754, in base64 (RFC 4648).
#include <span>
#include <string>

namespace momentree::io {

void append_base64(std::string& text, std::span<const unsigned char> bytes);
void append_doubles(std::string& text, std::span<const double> numbers);
/// Rounded to single precision: six digits and more, half the size.
void append_floats(std::string& text, std::span<const double> numbers);

}  // namespace momentree::io
