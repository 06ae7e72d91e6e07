#include <momentree/base/characters.hpp>

#include <algorithm>

namespace momentree {

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

char32_t code_point(std::string_view character) {
  char32_t c = static_cast<unsigned char>(character[0]);
  if (character.size() > 1) c &= 0x7fu >> character.size();
  for (const char byte : character.substr(1)) c = c << 6 | (static_cast<unsigned char>(byte) & 0x3fu);
  return c;
}

namespace {

struct CodeRange {
  char32_t first, last;
};

// Unicode's control characters, format characters and other default ignorable code points, except variation selectors, which
// belong to the preceding character; and noncharacters within planes. Sorted.
constexpr CodeRange invisible[] = {
    {0x0000, 0x001f},    // C0
    {0x007f, 0x009f},    // DEL, C1
    {0x00ad, 0x00ad},    // soft hyphen
    {0x034f, 0x034f},    // combining grapheme joiner
    {0x061c, 0x061c},    // Arabic letter mark
    {0x115f, 0x1160},    // Hangul fillers
    {0x17b4, 0x17b5},    // Khmer inherent vowels
    {0x180b, 0x180f},    // Mongolian selectors and separator
    {0x200b, 0x200f},    // zero-width space, joiners, directional marks
    {0x2028, 0x202e},    // line and paragraph separators, embeddings and overrides
    {0x2060, 0x206f},    // word joiner, invisible operators, isolates
    {0x3164, 0x3164},    // Hangul filler
    {0xd800, 0xdfff},    // surrogates
    {0xfdd0, 0xfdef},    // noncharacters
    {0xfeff, 0xfeff},    // byte order mark
    {0xffa0, 0xffa0},    // halfwidth Hangul filler
    {0xfff0, 0xfffb},    // interlinear annotations
    {0x13430, 0x13440},  // Egyptian hieroglyph format controls
    {0x1bca0, 0x1bca3},  // shorthand format controls
    {0x1d173, 0x1d17a},  // musical format controls
    {0xe0000, 0xe00ff},  // tags
    {0xe01f0, 0xe0fff},
};

constexpr char32_t non_joiner = 0x200c, joiner = 0x200d;

std::string_view character_at(std::string_view text, std::size_t i) { return text.substr(i, character_length(text, i)); }

// A joiner affects the shape of its neighbours; next to ASCII it can only mislead.
bool joins(std::string_view text, std::size_t i, std::size_t length) {
  const auto foreign = [&](std::size_t k) { return k < text.size() && static_cast<unsigned char>(text[k]) >= 0x80; };
  return i > 0 && foreign(i - 1) && foreign(i + length);
}

bool shows(std::string_view text, std::size_t i, std::size_t length) {
  const char32_t c = code_point(text.substr(i, length));
  return is_visible(c) || ((c == joiner || c == non_joiner) && joins(text, i, length));
}

void append_hexadecimal(std::string& out, char32_t c, int digits) {
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) out += "0123456789abcdef"[c >> shift & 15];
}

}  // namespace

bool is_visible(char32_t c) {
  if (c >= 0x20 && c < 0x7f) return true;
  if ((c & 0xfffe) == 0xfffe) return false;  // the last two code points of every plane are noncharacters
  const CodeRange* range = std::upper_bound(std::begin(invisible), std::end(invisible), c,
                                            [](char32_t value, const CodeRange& each) { return value < each.first; });
  return range == std::begin(invisible) || c > (range - 1)->last;
}

std::size_t first_invisible(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    if (length == 0 || !shows(text, i, length)) return i;
    i += length;
  }
  return std::string_view::npos;
}

std::size_t append_printable(std::string& out, std::string_view text, std::size_t i) {
  const std::string_view character = character_at(text, i);
  if (character.empty()) {
    out += "\xEF\xBF\xBD";
    return 1;
  }
  const char32_t c = code_point(character);
  if (c == '\t' || shows(text, i, character.size())) {
    out += character;
  } else if (c == '\n' || c == '\r') {
    out += c == '\n' ? "\\n" : "\\r";
  } else if (c < 0x80) {
    out += "\\x", append_hexadecimal(out, c, 2);
  } else if (c < 0x10000) {
    out += "\\u", append_hexadecimal(out, c, 4);
  } else {
    out += "\\U", append_hexadecimal(out, c, 8);
  }
  return character.size();
}

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) i += append_printable(out, text, i);
  return out;
}

}  // namespace momentree
