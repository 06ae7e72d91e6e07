#pragma once
// A checksum of bytes that are read or written in pieces.
#include <cstdint>
#include <string_view>

namespace momentree::io {

/// CRC-64/XZ (ECMA-182, reflected): finds every change of up to 64 neighbouring bits. Protects against damage, not against
/// forgery.
class Checksum {
 public:
  Checksum() = default;
  /// Continues one that had this value.
  explicit Checksum(std::uint64_t value) : state_(~value) {}
  void add(std::string_view bytes);
  /// Of all bytes so far.
  std::uint64_t value() const { return ~state_; }

 private:
  std::uint64_t state_ = ~std::uint64_t{0};
};

}  // namespace momentree::io
