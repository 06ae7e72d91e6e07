#include <momentree/io/report/base64.hpp>

#include <bit>
#include <cstdint>
#include <vector>

namespace momentree::io {

namespace {

template <class Bits, class Number>
void append(std::string& text, std::span<const double> numbers) {
  std::vector<unsigned char> bytes;
  bytes.reserve(numbers.size() * sizeof(Bits));
  for (const double number : numbers) {
    const Bits bits = std::bit_cast<Bits>(static_cast<Number>(number));
    for (std::size_t i = 0; i < sizeof(Bits); ++i) bytes.push_back(static_cast<unsigned char>(bits >> (8 * i)));
  }
  append_base64(text, bytes);
}

}  // namespace

void append_base64(std::string& text, std::span<const unsigned char> bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  text.reserve(text.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const std::uint32_t group = static_cast<std::uint32_t>(bytes[i]) << 16 |
                                (left > 1 ? static_cast<std::uint32_t>(bytes[i + 1]) << 8 : 0) |
                                (left > 2 ? static_cast<std::uint32_t>(bytes[i + 2]) : 0);
    text += digits[group >> 18 & 63];
    text += digits[group >> 12 & 63];
    text += left > 1 ? digits[group >> 6 & 63] : '=';
    text += left > 2 ? digits[group & 63] : '=';
  }
}

void append_doubles(std::string& text, std::span<const double> numbers) { append<std::uint64_t, double>(text, numbers); }
void append_floats(std::string& text, std::span<const double> numbers) { append<std::uint32_t, float>(text, numbers); }

}  // namespace momentree::io
