#include <momentree/text/toml_text.hpp>

#include <algorithm>
#include <utility>

#include <momentree/text/utf8.hpp>

namespace momentree::io {

namespace {

constexpr int deepest_key = 16;

// The position after the string that opens at text[i], or the end if it is unterminated: the parser reports that.
std::size_t past_string(std::string_view text, std::size_t i) {
  const char quote = text[i];
  const bool multiline = text.substr(i, 3) == std::string(3, quote);
  const std::string closing(multiline ? 3 : 1, quote);
  for (i += closing.size(); i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      ++i;
    } else if (text[i] == '\n' && !multiline) {
      return i;
    } else if (text.substr(i, closing.size()) == closing) {
      // one or two quotes may precede the closing three
      for (i += closing.size(); multiline && i < text.size() && text[i] == quote;) ++i;
      return i;
    }
  }
  return text.size();
}

enum class Oddity { none, deep, foreign, quote };

// The first place outside of strings and comments that the parser must not see: a dotted key with more parts than any scenario
// needs (a number or a date has at most one dot), a character that TOML does not allow there, or a quotation mark where no
// string can begin, after which this scanner and the parser would disagree about what is in a string.
std::pair<Oddity, std::size_t> first_oddity(std::string_view text) {
  int dots = 0;
  char before = '\n';  // the last non-blank character
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      if (std::string_view("\n=[{,.").find(before) == std::string_view::npos) return {Oddity::quote, i};
      before = c;
      i = past_string(text, i);
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    if (static_cast<unsigned char>(c) >= 0x80) return {Oddity::foreign, i};
    if (c == '.' && ++dots > deepest_key) return {Oddity::deep, i};
    if (c == '\n' || c == '=' || c == ',' || c == '{' || c == '[') dots = 0;
    if (c != ' ' && c != '\t' && c != '\r') before = c;
    ++i;
  }
  return {Oddity::none, 0};
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

}  // namespace

std::optional<SyntaxError> check_toml_text(std::string_view text) {
  if (auto problem = check_utf8(text)) return problem;
  // U+100000 and beyond: escape_unsupported() needs that plane.
  if (const std::size_t i = text.find('\xf4'); i != std::string_view::npos)
    return SyntaxError{place_at(text, i), "a character for private use", ""};
  const auto [oddity, at] = first_oddity(text);
  if (oddity == Oddity::none) return {};
  if (oddity == Oddity::deep)
    return SyntaxError{place_at(text, at), "a key of more than " + std::to_string(deepest_key + 1) + " parts", ""};
  if (oddity == Oddity::quote)
    return SyntaxError{place_at(text, at), "there is a quotation mark where no string can begin",
                       "strings are quoted as a whole"};
  const std::string character(text.substr(at, character_length(text, at)));
  const bool quote = character == "“" || character == "”" || character == "„" || character == "‘" || character == "’";
  return SyntaxError{
      place_at(text, at), "the character '" + character + "' is outside of a string",
      quote ? "quotation marks are straight: \"" : "keys and values have plain letters; others must be in strings"};
}

namespace {

constexpr char32_t plane = 0x100000;

void append_encoded(std::string& text, char32_t c) {
  const auto tail = [&](int shift) { text += static_cast<char>(0x80u | (c >> shift & 0x3fu)); };
  if (c < 0x800) {
    text += static_cast<char>(0xc0u | c >> 6);
  } else if (c < 0x10000) {
    text += static_cast<char>(0xe0u | c >> 12);
    tail(6);
  } else {
    text += static_cast<char>(0xf0u | c >> 18);
    tail(12);
    tail(6);
  }
  tail(0);
}

template <class Moved>
std::string with_moved(std::string_view text, Moved moved) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = std::max<std::size_t>(character_length(text, i), 1);
    const char32_t c = code_point(text.substr(i, length)), to = moved(c);
    if (to == c)
      result += text.substr(i, length);
    else
      append_encoded(result, to);
    i += length;
  }
  return result;
}

}  // namespace

std::string escape_unsupported(std::string_view text) {
  return with_moved(text, [](char32_t c) { return c >= 0x80 && c < 0x10000 ? c + plane : c; });
}

std::string unshielded(std::string_view text) {
  return with_moved(text, [](char32_t c) {
    const bool surrogate = c >= plane + 0xd800 && c < plane + 0xe000;  // only an escape can produce it
    return c >= plane + 0x80 && c < plane + 0x10000 && !surrogate ? c - plane : c;
  });
}

std::string_view line_of(std::string_view text, int line) {
  for (int k = 1; k < line; ++k) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  text = text.substr(0, text.find('\n'));
  if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
  return text;
}

std::string explain_syntax(std::string& what, std::string_view line, int column) {
  const auto says = [&](std::string_view part) { return what.find(part) != std::string::npos; };
  const auto at = [&](std::size_t i) { return i < line.size() ? line[i] : '\0'; };
  for (const std::string_view end : {"'\\n'", "'\\r'"})
    if (const std::size_t i = what.find(end); i != std::string::npos) what.replace(i, end.size(), "the end of the line");
  if (says("redefine")) return "it is given twice";
  if (says("string") && says("unescaped control") && static_cast<std::size_t>(column) > line.size()) {
    what = "cannot read this string: it does not end on its line";
    return "a closing quotation mark is missing";
  }
  if (says("end-of-file"))
    return says("array") ? "a closing ] is missing" : says("string") ? "closing quotation marks are missing" : "";
  if (says("could not be interpreted as a value")) {
    what = "cannot read this number: it is out of range";
    return {};
  }
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return {};
  const std::size_t first = line.find_first_not_of(" \t", equals + 1);
  if (first == std::string_view::npos) return "a value is missing after '='";
  const std::size_t sign = at(first) == '-' || at(first) == '+' ? 1 : 0;
  if (is_digit(at(first + sign))) {
    std::size_t end = first + sign;
    while (is_digit(at(end)) || at(end) == '.' || at(end) == '_') ++end;
    if (at(end) == ',' && is_digit(at(end + 1))) return "use a point as the decimal sign";
    const std::size_t unit = line.find_first_not_of(' ', end);
    if (unit != std::string_view::npos && is_letter(at(unit))) {
      const std::string_view rest = line.substr(unit, line.find('#', unit) - unit);
      return "a number with a unit is a string: \"" + std::string(line.substr(first, end - first)) + " " +
             std::string(rest.substr(0, rest.find_last_not_of(" \t,]}") + 1)) + "\"";
    }
  }
  if (is_letter(at(first)) && static_cast<std::size_t>(column) >= first + 1) return "a word is a string: write it in quotes";
  return {};
}

}  // namespace momentree::io
