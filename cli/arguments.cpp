#include <cli/arguments.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/base/units.hpp>
#include <momentree/io/number_text.hpp>

namespace momentree::cli {

namespace {

std::string place(const char* option, const std::string& text) {
  return std::string(option) + " " + (text.find(' ') == std::string::npos ? text : "\"" + text + "\"");
}

template <class Number>
bool read(const std::string& text, Number& number) {
  const std::size_t plus = text.starts_with('+') ? 1 : 0;
  const auto [end, failed] = std::from_chars(text.data() + plus, text.data() + text.size(), number);
  return failed == std::errc() && end == text.data() + text.size();
}

}  // namespace

double seconds_argument(const char* option, const std::string& text) {
  const std::string example = std::string("for example ") + option + " 2, or " + option + " \"2 s\"";
  double seconds = 0;
  if (!read(text, seconds)) {
    QuantityProblem problem;
    const auto time = parse_quantity(text, dimension::time, problem);
    if (!time) {
      const bool number = text.find_first_of("0123456789") != std::string::npos;  // then only the unit is wrong
      throw_error(
          {number ? problem.what : "expected a time, not '" + text + "'", place(option, text), number ? problem.hint : example});
    }
    seconds = *time;
  }
  if (!std::isfinite(seconds)) throw_error({"expected a time", place(option, text), example});
  if (seconds < 0) throw_error({"a time must not be negative", place(option, text), example});
  return seconds;
}

std::string time_argument(const char* option, const std::string& text) { return io::number_text(seconds_argument(option, text)); }

int number_argument(const char* option, const std::string& text, int least, int most) {
  int number = 0;
  if (!read(text, number) || number < least || number > most)
    throw_error({format("expected a whole number from %d to %d", least, most), place(option, text), ""});
  return number;
}

std::string choice_argument(const char* option, const std::string& text, const std::vector<std::string>& choices) {
  if (std::ranges::count(choices, text) == 1) return text;
  std::string known;
  for (const std::string& choice : choices) known += (known.empty() ? "one of: " : ", ") + choice;
  const std::string guess = did_you_mean(text, choices);
  throw_error({"there is no '" + text + "'", place(option, text), guess.empty() ? known : guess});
}

}  // namespace momentree::cli
