#include <momentree/text/utf8.hpp>

namespace momentree::io {

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
    if (length == 0)
      return SyntaxError{place_at(text, i), "the text is not UTF-8", "save the file with the encoding UTF-8", false};
    if (text[i] == '\0') return SyntaxError{place_at(text, i), "a zero byte: this is not text", "", false};
    i += length;
  }
  return {};
}

}  // namespace momentree::io
