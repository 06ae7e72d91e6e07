#include <momentree/base/units.hpp>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <momentree/base/error.hpp>

namespace momentree {

namespace {

using namespace dimension;

// factor · 10^decade: powers of ten are kept separate, so that they are applied once and rounded exactly.
struct Unit {
  const char* name;
  Dimension dimension;
  double factor;
  int decade;
};

constexpr double pi = 3.14159265358979323846;
constexpr Unit units[] = {
    {"m", length, 1, 0},
    {"km", length, 1, 3},
    {"cm", length, 1, -2},
    {"mm", length, 1, -3},
    {"dm", length, 1, -1},
    {"um", length, 1, -6},
    {"µm", length, 1, -6},
    {"nm", length, 1, -9},
    {"in", length, 254, -4},
    {"ft", length, 3048, -4},
    {"kg", mass, 1, 0},
    {"g", mass, 1, -3},
    {"mg", mass, 1, -6},
    {"t", mass, 1, 3},
    {"lb", mass, 45359237, -8},
    {"s", time, 1, 0},
    {"ms", time, 1, -3},
    {"us", time, 1, -6},
    {"µs", time, 1, -6},
    {"ns", time, 1, -9},
    {"min", time, 60, 0},
    {"h", time, 3600, 0},
    {"rad", angle, 1, 0},
    {"mrad", angle, 1, -3},
    {"deg", angle, pi / 180, 0},
    {"rev", angle, 2 * pi, 0},
    {"N", force, 1, 0},
    {"mN", force, 1, -3},
    {"uN", force, 1, -6},
    {"kN", force, 1, 3},
    {"MN", force, 1, 6},
    {"J", torque, 1, 0},
    {"mJ", torque, 1, -3},
    {"kJ", torque, 1, 3},
    {"W", torque / time, 1, 0},
    {"kW", torque / time, 1, 3},
    {"Pa", force / (length * length), 1, 0},
    {"rpm", angular_speed, 2 * pi / 60, 0},
    {"Hz", frequency, 1, 0},
    {"kHz", frequency, 1, 3},
};

// Common spellings of units that an edit distance would not find.
struct Habit {
  const char *written, *meant;
};
constexpr Habit habits[] = {
    {"°", "deg"},     {"degree", "deg"},  {"degrees", "deg"},  {"º", "deg"},     {"radian", "rad"}, {"radians", "rad"},
    {"meter", "m"},   {"meters", "m"},    {"metre", "m"},      {"metres", "m"},  {"M", "m"},        {"second", "s"},
    {"seconds", "s"}, {"sec", "s"},       {"S", "s"},          {"gram", "g"},    {"grams", "g"},    {"G", "g"},
    {"gr", "g"},      {"kilogram", "kg"}, {"kilograms", "kg"}, {"KG", "kg"},     {"Kg", "kg"},      {"newton", "N"},
    {"n", "N"},       {"Newton", "N"},    {"Nm", "N m"},       {"Nms", "N m s"}, {"Nmm", "N mm"},   {"mNm", "mN m"},
    {"kgm", "kg m"},  {"kgm2", "kg m^2"}, {"gcm2", "g cm^2"},  {"hr", "h"},      {"hours", "h"},    {"minutes", "min"},
    {"inch", "in"},   {"inches", "in"},   {"hz", "Hz"},        {"turn", "rev"},  {"turns", "rev"},  {"lbs", "lb"},
    {"m2", "m^2"},    {"cm2", "cm^2"},    {"mm2", "mm^2"},     {"s2", "s^2"},    {"m²", "m^2"},     {"s²", "s^2"},
};

const Unit* find_unit(std::string_view name) {
  for (const Unit& unit : units)
    if (name == unit.name) return &unit;
  return nullptr;
}

std::string_view meant_by(std::string_view written) {
  for (const Habit& habit : habits)
    if (written == habit.written) return habit.meant;
  return written;
}

std::string suggestion(std::string_view name) {
  if (const std::string_view meant = meant_by(name); meant != name) return "write " + std::string(meant);
  const std::size_t digit = name.find_first_of("0123456789");
  if (digit != std::string_view::npos && digit > 0 && find_unit(name.substr(0, digit)))
    return "powers are written with ^: " + std::string(name.substr(0, digit)) + "^" + std::string(name.substr(digit));
  std::vector<std::string> known;
  for (const Unit& unit : units) known.emplace_back(unit.name);
  // Nearly every unit is close to a name of one or two letters.
  const std::string best = name.size() > 2 ? nearest(name, known) : std::string{};
  return best.empty() ? "units are SI and its multiples: m, cm, mm, kg, g, s, ms, rad, deg, N, J …"
                      : "did you mean '" + best + "'?";
}

class Parser {
 public:
  explicit Parser(std::string_view text) : rest_(text) { skip_space(); }

  bool number(double& value, QuantityProblem& problem);
  bool unit_product(Dimension& dimension, double& factor, int& decade, bool& any, QuantityProblem& problem);
  /// What has not been read.
  std::string_view rest() const { return rest_; }

 private:
  void skip_space() {
    while (!rest_.empty() && (rest_.front() == ' ' || rest_.front() == '\t')) rest_.remove_prefix(1);
  }
  static bool ends_unit(char c) { return c == ' ' || c == '\t' || c == '*' || c == '/' || c == '^'; }
  bool power(int& n, QuantityProblem& problem);

  std::string_view rest_;
};

// Independent of the locale.
std::from_chars_result read_number(std::string_view text, double& value) {
#if defined(__cpp_lib_to_chars)
  return std::from_chars(text.data(), text.data() + text.size(), value);
#else  // in WebAssembly, which has a single locale; no hexadecimal digits
  const std::string number(text.substr(0, text.find_first_not_of("+-.0123456789eE")));
  char* end = nullptr;
  errno = 0;
  const double found = std::strtod(number.c_str(), &end);
  const std::ptrdiff_t length = end - number.c_str();
  if (length == 0) return {text.data(), std::errc::invalid_argument};
  if (errno == ERANGE && (found == 0 || !std::isfinite(found))) return {text.data() + length, std::errc::result_out_of_range};
  value = found;
  return {text.data() + length, std::errc{}};
#endif
}

bool Parser::number(double& value, QuantityProblem& problem) {
  const std::string_view all = rest_;
  const bool plus = !rest_.empty() && rest_.front() == '+';
  if (plus) rest_.remove_prefix(1);
  const std::size_t first = !rest_.empty() && rest_.front() == '-' && !plus ? 1 : 0;
  const bool digits = rest_.size() > first && ((rest_[first] >= '0' && rest_[first] <= '9') || rest_[first] == '.');
  std::from_chars_result read{};
  if (digits) read = read_number(rest_, value);
  if (!digits || read.ec == std::errc::invalid_argument) {
    problem = {"'" + std::string(all) + "' does not begin with a number", ""};
    return false;
  }
  if (read.ec == std::errc::result_out_of_range) {
    problem = {"'" + std::string(all) + "' is outside the range of numbers", "they go up to 1.8e308"};
    return false;
  }
  rest_.remove_prefix(static_cast<std::size_t>(read.ptr - rest_.data()));
  if (rest_.empty() || rest_.front() == ' ' || rest_.front() == '\t') {
    skip_space();
    return true;
  }
  const std::string written(all.substr(0, all.size() - rest_.size()));
  if (rest_.front() == ',')
    problem = {"'" + std::string(all) + "' has a comma in its number", "the decimal sign is a point"};
  else
    problem = {"'" + std::string(all) + "' runs number and unit together",
               "write \"" + written + " " + std::string(meant_by(rest_)) + "\""};
  return false;
}

bool Parser::power(int& n, QuantityProblem& problem) {
  n = 1;
  if (rest_.empty() || rest_.front() != '^') return true;
  rest_.remove_prefix(1);
  const auto read = std::from_chars(rest_.data(), rest_.data() + rest_.size(), n);
  const std::size_t length_read = static_cast<std::size_t>(read.ptr - rest_.data());
  if (read.ec != std::errc{} || n == 0 || n < -9 || n > 9 || (length_read < rest_.size() && !ends_unit(rest_[length_read]))) {
    problem = {"a power is a whole number from -9 to 9", "for example \"cm^2\""};
    return false;
  }
  rest_.remove_prefix(length_read);
  return true;
}

bool Parser::unit_product(Dimension& dimension, double& factor, int& decade, bool& any, QuantityProblem& problem) {
  int side = 1;
  bool expects_unit = false;
  while (true) {
    skip_space();
    if (rest_.empty()) break;
    if (rest_.front() == '*' || rest_.front() == '/') {
      if (rest_.front() == '/' && side < 0) {
        problem = {"more than one '/' in a unit", "use one '/': everything after it divides, as in \"kg/m s^2\""};
        return false;
      }
      if (expects_unit || (rest_.front() == '*' && !any)) break;
      if (rest_.front() == '/') side = -1;
      rest_.remove_prefix(1);
      expects_unit = true;
      continue;
    }
    std::size_t end = 0;
    while (end < rest_.size() && !ends_unit(rest_[end])) ++end;
    const std::string_view name = rest_.substr(0, end);
    if (name.empty()) break;
    rest_.remove_prefix(end);
    int n = 1;
    if (!power(n, problem)) return false;
    if (name == "1" && !any && side > 0) continue;  // "1/s"
    const Unit* unit = find_unit(name);
    if (!unit) {
      problem = {"unknown unit '" + std::string(name) + "'", suggestion(name)};
      return false;
    }
    n *= side;
    for (int i = 0; i < std::abs(n); ++i) dimension = n > 0 ? dimension * unit->dimension : dimension / unit->dimension;
    factor *= std::pow(unit->factor, n);
    decade += n * unit->decade;
    any = true;
    expects_unit = false;
    if (std::abs(decade) > 200 || std::abs(dimension.m) + std::abs(dimension.kg) + std::abs(dimension.s) > 90) {
      problem = {"the unit's powers are too large", ""};
      return false;
    }
  }
  if (rest_.empty() && !expects_unit) return true;
  problem = {"a unit is missing", "units are joined by a space, '*' or one '/', as in \"N m s\" or \"m/s^2\""};
  return false;
}

// x · 10^n, rounded only once if 10^|n| is exact.
double scaled(double x, int n) {
  constexpr int exact = 22;
  for (; n > exact; n -= exact) x *= 1e22;
  for (; n < -exact; n += exact) x /= 1e22;
  static constexpr double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                      1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  return n < 0 ? x / powers[-n] : x * powers[n];
}

bool agrees(const Dimension& given, const Dimension& expected) {
  if (given == expected) return true;
  Dimension without_radians = expected;
  without_radians.rad = 0;
  return expected.kg != 0 && given == without_radians;
}

void append_power(std::string& text, const char* unit, int n) {
  if (n == 0) return;
  if (!text.empty()) text += ' ';
  text += unit;
  if (n != 1) text += "^" + std::to_string(n);
}

}  // namespace

namespace {

struct NamedDimension {
  Dimension dimension;
  const char *name, *plain, *with_unit;  // the same value in SI and with a unit
};
constexpr NamedDimension named_dimensions[] = {
    {number, "a number without unit", "1.5", ""},
    {length, "a length (m)", "0.5", "50 cm"},
    {mass, "a mass (kg)", "0.2", "200 g"},
    {time, "a time (s)", "2", "2 s"},
    {angle, "an angle (rad)", "0.5236", "30 deg"},
    {speed, "a speed (m/s)", "0.5", "50 cm/s"},
    {angular_speed, "an angular speed (rad/s)", "0.5236", "30 deg/s"},
    {acceleration, "an acceleration (m/s^2)", "9.81", "9.81 m/s^2"},
    {inertia, "a moment of inertia (kg m^2)", "2e-5", "200 g cm^2"},
    {force, "a force (N)", "4000", "4 kN"},
    {torque, "a torque (N m)", "2", "2 N m"},
    {torque / angular_speed, "a rotational damping (N m s/rad)", "0.1", "0.1 N m s"},
    {force / speed, "a damping (N s/m)", "20", "20 N s/m"},
    {torque / angle, "a rotational stiffness (N m/rad)", "3", "3 N m"},
    {force / length, "a stiffness (N/m)", "2000", "2 kN/m"},
    {torque * time, "an angular momentum (N m s)", "0.1", "0.1 N m s"},
    {force * time, "a momentum (N s)", "2", "2 N s"},
    {length * length, "an area (m^2)", "0.5", "0.5 m^2"},
    {frequency, "a frequency (Hz)", "0.5", "0.5 Hz"},
    {force / (speed * speed), "a quadratic drag (N s^2/m^2)", "0.3", "0.3 N s^2/m^2"},
    {mass / (length * length * length), "a density (kg/m^3)", "0.6", "0.6 kg/m^3"},
};

}  // namespace

std::string name_of(const Dimension& d) {
  for (const NamedDimension& n : named_dimensions)
    if (n.dimension == d) return n.name;
  std::string text;
  append_power(text, "kg", d.kg);
  append_power(text, "m", d.m);
  append_power(text, "s", d.s);
  append_power(text, "rad", d.rad);
  return "a quantity in " + text;
}

std::string unit_of(const Dimension& dimension) {
  const std::string name = name_of(dimension);
  const std::size_t open = name.find('(');
  return open == std::string::npos ? "" : name.substr(open + 1, name.find(')') - open - 1);
}

std::string example_of(const Dimension& d) {
  for (const NamedDimension& n : named_dimensions)
    if (n.dimension == d) return *n.with_unit == '\0' ? n.plain : std::string(n.plain) + ", or \"" + n.with_unit + "\"";
  return "2, in SI units";
}

std::optional<WrittenQuantity> split_quantity(std::string_view text) {
  while (text.ends_with(' ')) text.remove_suffix(1);
  if (text.size() > 200) return std::nullopt;
  Parser parser(text);
  WrittenQuantity found;
  Dimension dimension;
  QuantityProblem problem;
  double factor = 1;
  int decade = 0;
  bool any = false;
  if (!parser.number(found.number, problem)) return std::nullopt;
  found.unit = parser.rest();
  if (!parser.unit_product(dimension, factor, decade, any, problem) || !any) return std::nullopt;
  return found;
}

std::optional<double> parse_quantity(std::string_view text, const Dimension& expected, QuantityProblem& problem) {
  if (text.size() > 200) {
    problem = {"a number with a unit has at most 200 characters", ""};
    return {};
  }
  Parser parser(text);
  Dimension dimension;
  double value = 0, factor = 1;
  int decade = 0;
  bool any = false;
  const std::string given(text);
  if (!parser.number(value, problem)) {
    if (problem.hint.empty()) problem.hint = "expected " + name_of(expected) + ", for example " + example_of(expected);
    if (expected == angle && text.find("pi") != std::string_view::npos)
      problem.hint = "a value can't be a formula: write degrees, as in \"90 deg\", or the number itself";
    return {};
  }
  if (!parser.unit_product(dimension, factor, decade, any, problem)) return {};
  if (!any) {
    const std::string name = name_of(expected);
    const std::size_t from = name.find('(') + 1;  // past the end if the name has no unit
    problem = {"'" + given + "' has no unit", "expected " + name + ": write " + given + " without quotes"};
    if (from > 0)
      problem.hint = "write " + given + " without quotes, or \"" + given + " " + name.substr(from, name.find(')') - from) + "\"";
    if (expected == number) problem = {"'" + given + "' is in quotes", "write " + given + " without them"};
    if (expected == angle) problem.hint = "write \"" + given + " deg\", or \"" + given + " rad\"";
    return {};
  }
  if (!agrees(dimension, expected)) {
    problem = {"'" + given + "' is " + name_of(dimension) + ", not " + name_of(expected), "for example " + example_of(expected)};
    return {};
  }
  value = scaled(value * factor, decade);
  if (!std::isfinite(value)) {
    problem = {"'" + std::string(text) + "' is outside the range of numbers", ""};
    return {};
  }
  return value;
}

}  // namespace momentree
