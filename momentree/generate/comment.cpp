#include <momentree/generate/comment.hpp>

#include <algorithm>
#include <cstddef>

namespace momentree {

namespace {

std::string hexadecimal(unsigned value, std::size_t digits) {
  std::string text;
  for (; value != 0 || text.size() < digits; value /= 16) text.insert(text.begin(), "0123456789ABCDEF"[value % 16]);
  return text;
}

struct Character {
  unsigned code = 0;
  std::size_t length = 0;  // 0: not UTF-8
};

// The first character of a nonempty text.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(text[i])); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t length = lead < 0xc2 || lead > 0xf4 ? 0 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
  if (length == 0 || length > text.size()) return {};
  unsigned code = lead & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0u) != 0x80u) return {};
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const bool shortest = code >= (length == 2 ? 0x80u : length == 3 ? 0x800u : 0x10000u);
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  return shortest && !surrogate && code <= 0x10ffff ? Character{code, length} : Character{};
}

bool harmless(unsigned code, char before) {
  if (code < ' ' || code > '~' || code == '\\') return false;
  return !(code == '?' && before == '?') && !(code == '*' && before == '/') && !(code == '/' && before == '*');
}

}  // namespace

std::string comment_text(std::string_view line) {
  std::string all;
  for (std::size_t i = 0; i < line.size();) {
    const Character c = first_character(line.substr(i));
    if (c.length == 0)
      all += "<0x" + hexadecimal(static_cast<unsigned char>(line[i]), 2) + '>';
    else if (harmless(c.code, all.empty() ? ' ' : all.back()))
      all += static_cast<char>(c.code);
    else
      all += "<U+" + hexadecimal(c.code, 4) + '>';
    i += c.length == 0 ? 1 : c.length;
  }
  return all;
}

std::string comment(std::string_view lines) {
  std::string all;
  for (std::size_t begin = 0; begin < lines.size();) {
    const std::size_t end = std::min(lines.find('\n', begin), lines.size());
    const std::string text = comment_text(lines.substr(begin, end - begin));
    all += text.empty() ? "//\n" : "// " + text + '\n';
    begin = end + 1;
  }
  return all;
}

}  // namespace momentree
