#include <momentree/text/number_text.hpp>

#include <charconv>
#include <cmath>

namespace momentree::io {

namespace {
template <class Number>
void append(std::string& text, Number value) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  (void)error;  // 32 characters are enough for every double and every long
  text.append(digits, end);
}
}  // namespace

void append_number(std::string& text, double value) {
  if (value == 0)
    text += std::signbit(value) ? "-0.0" : "0";
  else
    append(text, value);
}

void append_number(std::string& text, long value) { append(text, value); }

std::string number_text(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

std::string rounded_text(double value, int digits) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits);
  return error == std::errc() ? std::string(text, end) : number_text(value);
}

}  // namespace momentree::io
