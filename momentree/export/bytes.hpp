#pragma once
// Numbers as bytes, the least significant first.
#include <concepts>
#include <string>

namespace momentree::io {

template <std::unsigned_integral Number>
void append_little_endian(std::string& bytes, Number number) {
  for (unsigned shift = 0; shift < 8 * sizeof(Number); shift += 8) bytes += static_cast<char>((number >> shift) & 0xffu);
}

}  // namespace momentree::io
