#include <momentree/io/number_text.hpp>

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

}  // namespace momentree::io
