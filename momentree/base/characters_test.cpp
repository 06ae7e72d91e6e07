#include <doctest/doctest.h>

#include <string>

#include <momentree/base/characters.hpp>
#include <momentree/base/error.hpp>

using namespace momentree;

namespace {

std::string encoded(char32_t c) {
  const auto byte = [](char32_t value) { return static_cast<char>(static_cast<unsigned char>(value)); };
  if (c < 0x80) return {byte(c)};
  if (c < 0x800) return {byte(0xc0 | c >> 6), byte(0x80 | (c & 63))};
  if (c < 0x10000) return {byte(0xe0 | c >> 12), byte(0x80 | (c >> 6 & 63)), byte(0x80 | (c & 63))};
  return {byte(0xf0 | c >> 18), byte(0x80 | (c >> 12 & 63)), byte(0x80 | (c >> 6 & 63)), byte(0x80 | (c & 63))};
}

}  // namespace

TEST_CASE("terminal control sequences are shown as escapes") {
  CHECK(printable("\x1b[31mred\x07") == "\\x1b[31mred\\x07");
  CHECK(printable(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(printable("a\nb\r\tc\x7f") == "a\\nb\\r\tc\\x7f");
  CHECK(printable("\xC2\x9B"
                  "31m\xC2\x85") == "\\u009b31m\\u0085");
  CHECK(printable(encoded(0x202e) + encoded(0x2066) + encoded(0x200b) + encoded(0x2028)) == "\\u202e\\u2066\\u200b\\u2028");
  CHECK(printable(encoded(0xfeff) + encoded(0xe0041) + encoded(0x1fffe)) == "\\ufeff\\U000e0041\\U0001fffe");
}

TEST_CASE("a byte that is not UTF-8 is shown as the replacement character") {
  const std::string replacement = encoded(0xfffd);
  CHECK(printable("a\xFF\x80z") == "a" + replacement + replacement + "z");
  CHECK(printable("\xC3") == replacement);
  CHECK(printable("\xE2\x80") == replacement + replacement);
  CHECK(printable("\xED\xA0\x80") == replacement + replacement + replacement);  // a surrogate
  CHECK(printable("\xC0\xAF") == replacement + replacement);                    // overlong
}

TEST_CASE("ordinary text is unchanged") {
  for (const char* text : {"", "left arm #1 \\ ~", "Gelenk für Öl", "関節 1", "مفصل", "рука", "🦾", "👩‍🔧", "1️⃣",
                           "é", "a\u00a0b", "می‌خواهم"}) {
    CAPTURE(text);
    CHECK(printable(text) == text);
    CHECK(first_invisible(text) == std::string::npos);
  }
}

TEST_CASE("joiners are allowed between letters that they shape, and nowhere else") {
  CHECK(printable("arm" + encoded(0x200d) + "1") == "arm\\u200d1");
  CHECK(printable(encoded(0x200d)) == "\\u200d");
  CHECK(printable("é" + encoded(0x200c)) == "é\\u200c");
}

TEST_CASE("the first invisible character is found, of every class") {
  CHECK(first_invisible("ab\x1b") == 2);
  CHECK(first_invisible("é\xFF") == 2);
  for (const char32_t c : {U'\0', U'\x1f', U'\x7f', U'\x80', U'\x9f', U'\xad', U'\u061c', U'\u200b', U'\u200e', U'\u2028',
                           U'\u202e', U'\u2060', U'\u2069', U'\u206f', U'\ufeff', U'\ufff9', U'\uffff', U'\U000e007f'})
    CHECK_MESSAGE(!is_visible(c), static_cast<unsigned long>(c));
  for (const char32_t c : {U' ', U'~', U'\xa0', U'\xac', U'\xae', U'\u2010', U'\u2027', U'\u202f', U'\u205f', U'\u2070',
                           U'\ufe0f', U'\ufffc', U'\ufffd', U'\U0001f9be', U'\U000e0100'})
    CHECK_MESSAGE(is_visible(c), static_cast<unsigned long>(c));
}

TEST_CASE("an error's message is one line without control characters") {
  const Error error{"no body 'a\x1b]0;x\x07'", "r\xFF.toml", "did you mean\n'b'?"};
  CHECK(error.message() == "r\xEF\xBF\xBD.toml: error: no body 'a\\x1b]0;x\\x07'; did you mean\\n'b'?");
}
