#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace momentree::io {

/// FNV-1a, 64 bits: the same on every machine; identifies an input, protects nothing.
class Hash {
 public:
  void add(std::string_view part) {
    for (const char c : part) hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  /// 16 hexadecimal digits.
  std::string digits() const {
    std::uint64_t hash = hash_;
    std::string digits(16, '0');
    for (std::size_t i = 16; i-- > 0; hash >>= 4) digits[i] = "0123456789abcdef"[hash & 15];
    return digits;
  }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

}  // namespace momentree::io
