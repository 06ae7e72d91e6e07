#include <momentree/text/base64.hpp>

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

std::optional<std::string> from_base64(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t group = 0, digits = 0;
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  for (const char c : text) {
    const int digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (digit < 0) {
      if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
      return {};
    }
    group = group << 6 | static_cast<std::uint32_t>(digit);
    if (++digits % 4 != 0) continue;
    for (const int shift : {16, 8, 0}) bytes += static_cast<char>(group >> shift & 255);
    group = 0;
  }
  if (digits % 4 == 1) return {};
  if (digits % 4 == 2) bytes += static_cast<char>(group >> 4 & 255);
  if (digits % 4 == 3) bytes += static_cast<char>(group >> 10 & 255), bytes += static_cast<char>(group >> 2 & 255);
  return bytes;
}

void append_doubles(std::string& text, std::span<const double> numbers) { append<std::uint64_t, double>(text, numbers); }
void append_floats(std::string& text, std::span<const double> numbers) { append<std::uint32_t, float>(text, numbers); }

}  // namespace momentree::io
