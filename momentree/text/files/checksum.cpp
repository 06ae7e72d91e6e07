#include <momentree/text/files/checksum.hpp>

#include <array>

namespace momentree::io {

namespace {

using CrcTables = std::array<std::array<std::uint64_t, 256>, 8>;

// Entry [k][b]: the checksum of the byte b followed by k zeros.
constexpr CrcTables make_crc_tables() {
  constexpr std::uint64_t polynomial = 0xc96c5795d7870f42u;  // bits in reverse order
  CrcTables crc_tables{};
  for (std::size_t b = 0; b < 256; ++b) {
    std::uint64_t crc = b;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? polynomial : 0);
    crc_tables[0][b] = crc;
  }
  for (std::size_t k = 1; k < 8; ++k)
    for (std::size_t b = 0; b < 256; ++b)
      crc_tables[k][b] = (crc_tables[k - 1][b] >> 8) ^ crc_tables[0][crc_tables[k - 1][b] & 255];
  return crc_tables;
}

constexpr CrcTables crc_tables = make_crc_tables();

}  // namespace

void Checksum::add(std::string_view bytes) {
  const auto* at = reinterpret_cast<const unsigned char*>(bytes.data());
  std::size_t left = bytes.size();
  std::uint64_t crc = state_;
  for (; left >= 8; left -= 8, at += 8) {  // eight bytes at once
    for (std::size_t i = 0; i < 8; ++i) crc ^= std::uint64_t{at[i]} << (8 * i);
    std::uint64_t next = 0;
    for (std::size_t i = 0; i < 8; ++i) next ^= crc_tables[7 - i][(crc >> (8 * i)) & 255];
    crc = next;
  }
  for (; left > 0; --left, ++at) crc = (crc >> 8) ^ crc_tables[0][(crc ^ *at) & 255];
  state_ = crc;
}

}  // namespace momentree::io
