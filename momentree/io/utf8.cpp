#include <momentree/io/utf8.hpp>

namespace momentree::io {

std::size_t character_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u; };
  const auto continues = [&](std::size_t k) { return (byte(k) & 0xc0) == 0x80; };
  const unsigned a = byte(i), b = byte(i + 1);
  if (a < 0x80) return 1;
  if (a >= 0xc2 && a < 0xe0) return continues(i + 1) ? 2 : 0;
  if (a >= 0xe0 && a < 0xf0) {
    const bool overlong = a == 0xe0 && b < 0xa0, surrogate = a == 0xed && b >= 0xa0;
    return continues(i + 1) && continues(i + 2) && !overlong && !surrogate ? 3 : 0;
  }
  if (a >= 0xf0 && a < 0xf5) {
    const bool overlong = a == 0xf0 && b < 0x90, beyond = a == 0xf4 && b >= 0x90;
    return continues(i + 1) && continues(i + 2) && continues(i + 3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

Place place_at(std::string_view text, std::size_t end) {
  Place place{1, 1, 0};
  for (std::size_t i = 0; i < end; ++i) {
    if (text[i] == '\n')
      ++place.line, place.column = 1;
    else if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80)
      ++place.column;
  }
  return place;
}

std::optional<SyntaxError> check_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    if (length == 0) return SyntaxError{place_at(text, i), "the text is not UTF-8", "save the file with the encoding UTF-8"};
    if (text[i] == '\0') return SyntaxError{place_at(text, i), "a zero byte: this is no text", ""};
    i += length;
  }
  return {};
}

}  // namespace momentree::io
