#include <cli/arguments.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

#include <cli/text.hpp>
#include <momentree/base/error.hpp>
#include <momentree/base/units.hpp>
#include <momentree/text/number_text.hpp>

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

// "60s" as "60 s": without quotes, a value on a command line has no space.
std::string apart(const std::string& text) {
  double number = 0;
  const char* const end = std::from_chars(text.data(), text.data() + text.size(), number).ptr;
  const auto at = static_cast<std::size_t>(end - text.data());
  return at > 0 && at < text.size() && text[at] != ' ' ? text.substr(0, at) + ' ' + text.substr(at) : text;
}

}  // namespace

double seconds_argument(const char* option, const std::string& text) {
  const std::string example = std::string("for example ") + option + " 2, or " + option + " \"2 s\"";
  double seconds = 0;
  if (!read(text, seconds)) {
    QuantityProblem problem;
    const auto time = parse_quantity(apart(text), dimension::time, problem);
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

double interval_argument(const char* option, const std::string& text) {
  const double seconds = seconds_argument(option, text);
  if (seconds == 0)
    throw_error(
        {"a time between checkpoints must be more than 0", place(option, text), std::string("for example ") + option + " 60s"});
  return seconds;
}

std::string time_argument(const char* option, const std::string& text) { return io::number_text(seconds_argument(option, text)); }

double tolerance_argument(const char* option, const std::string& text) {
  double number = 0;
  if (!read(text, number) || !std::isfinite(number) || number < 0)
    throw_error({"expected a number of at least 0", place(option, text), std::string("for example ") + option + " 1e-9"});
  return number;
}

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
