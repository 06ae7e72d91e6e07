#pragma once
#include <cstdint>
#include <string_view>

namespace momentree::sweep {

/// CRC-32C (Castagnoli) of `bytes`, continued from `crc`.
std::uint32_t crc32c(std::string_view bytes, std::uint32_t crc = 0);

}  // namespace momentree::sweep
