#include <momentree/scenario/mistakes/shapes.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

constexpr std::size_t longest = 70;

bool is_number(const Value& value) { return value.number().has_value(); }
bool is_scalar(const Value& value) { return is_number(value) || value.string(); }
double number(const Value& value) { return *value.number(); }

std::string list(const std::vector<std::string>& entries) {
  std::string text = "[";
  for (const std::string& entry : entries) text += (text.size() > 1 ? ", " : "") + entry;
  return text + "]";
}

bool are_scalars(const Value::Array& entries) { return std::all_of(entries.begin(), entries.end(), is_scalar); }

std::vector<std::string> written(const Value::Array& entries, std::size_t begin, std::size_t count) {
  std::vector<std::string> all;
  for (std::size_t i = begin; i < begin + count; ++i) all.push_back(as_written(entries[i]));
  return all;
}

std::string write(std::string_view key, const std::string& value) {
  return value.empty() || value.size() > longest ? "" : "write " + std::string(key) + " = " + value;
}

// The numbers in "0 0 1" or "0, 0, 1".
std::vector<std::string> numbers_in(std::string_view text) {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" ,;\t", i), text.size());
    if (end > i) found.emplace_back(text.substr(i, end - i));
    i = end + 1;
  }
  const auto plain = [](const std::string& word) {
    return word.find_first_not_of("+-.0123456789eE") == std::string::npos &&
           word.find_first_of("0123456789") != std::string::npos;
  };
  if (found.size() < 2 || !std::all_of(found.begin(), found.end(), plain)) found.clear();
  return found;
}

// "z", "-y": a direction given where an axis is expected.
std::optional<std::string> direction(std::string_view text) {
  if (text.empty() || text.size() > 2) return {};
  const char letter = static_cast<char>(text.back() | 0x20);
  if (letter < 'x' || letter > 'z' || (text.size() == 2 && text[0] != '-' && text[0] != '+')) return {};
  std::vector<std::string> entries(3, "0");
  entries[static_cast<std::size_t>(letter - 'x')] = text[0] == '-' ? "-1" : "1";
  return list(entries);
}

// The entries x, y, z of a table, or those of its xyz.
std::string list_in(const Value& value) {
  if (const Value::Entry* xyz = value.find("xyz")) return as_written(xyz->value);
  std::vector<std::string> entries(3, "0");
  bool any = false;
  for (const Value::Entry& entry : *value.table()) {
    if (entry.key.size() != 1 || entry.key[0] < 'x' || entry.key[0] > 'z' || !is_scalar(entry.value)) return "";
    entries[static_cast<std::size_t>(entry.key[0] - 'x')] = as_written(entry.value);
    any = true;
  }
  return any ? list(entries) : "";
}

std::string downwards(const Value& value) {
  if (const bool* on = value.boolean()) return *on ? "[0, 0, -9.81]" : "[0, 0, 0]";
  if (is_number(value)) return "[0, 0, " + number_text(-std::fabs(number(value))) + "]";
  if (!value.string()) return "";
  const std::string& text = *value.string();
  return "[0, 0, \"-" + text.substr(text.find_first_not_of("+- ") == std::string::npos ? 0 : text.find_first_not_of("+- ")) +
         "\"]";
}

std::string of_moments(std::vector<std::string> six, bool diagonal) {
  const char* const order = "xx, yy, zz, xy, xz, yz";
  if (diagonal) six.resize(3);
  const std::string cure = write("inertia", list(six));
  if (cure.empty()) return "write its 6 numbers " + std::string(order) + " in one list";
  return cure + ": " + (diagonal ? "xx, yy, zz; with products of inertia 6 numbers, " : "") + order;
}

// xx, yy, zz, xy, xz, yz of a matrix given by rows.
std::string of_matrix(const std::array<const Value*, 9>& m) {
  static constexpr std::size_t entries[] = {0, 4, 8, 1, 2, 5}, mirrored[] = {0, 4, 8, 3, 6, 7};
  std::vector<std::string> six;
  bool diagonal = true;
  for (std::size_t i = 0; i < 6; ++i) {
    six.push_back(as_written(*m[entries[i]]));
    if (six.back() != as_written(*m[mirrored[i]])) return "an inertia is symmetric: 6 numbers, xx, yy, zz, xy, xz, yz";
    diagonal = diagonal && (i < 3 || (is_number(*m[entries[i]]) && number(*m[entries[i]]) == 0));
  }
  return of_moments(std::move(six), diagonal);
}

std::string of_pairs(const Value::Array& entries) {
  std::vector<std::string> lower, upper;
  for (const Value& each : entries) {
    if (!each.array() || each.array()->size() != 2 || !are_scalars(*each.array())) return "";
    lower.push_back(as_written((*each.array())[0])), upper.push_back(as_written((*each.array())[1]));
  }
  return lower.empty() ? "" : "{ lower = " + list(lower) + ", upper = " + list(upper) + " }";
}

std::string limits_of(const Value& value) {
  const Value::Array* entries = value.array();
  if (entries && entries->size() == 2 && are_scalars(*entries))
    return "{ lower = " + as_written((*entries)[0]) + ", upper = " + as_written((*entries)[1]) + " }";
  if (entries) return of_pairs(*entries);
  if (!is_number(value)) return "";
  const double size = std::fabs(number(value));
  return "{ lower = " + number_text(-size) + ", upper = " + number_text(size) + " }";
}

}  // namespace

std::string as_written(const Value& value) {
  std::string text;
  if (const std::string* s = value.string()) {
    const bool plain = s->find_first_of("\"\\") == std::string::npos &&
                       std::none_of(s->begin(), s->end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
    text = plain ? "\"" + *s + "\"" : "";
  } else if (const bool* b = value.boolean()) {
    text = *b ? "true" : "false";
  } else if (value.integer()) {
    text = std::to_string(*value.integer());
  } else if (value.real()) {
    text = number_text(*value.real());
  } else if (value.array() && value.array()->size() <= 9 && are_scalars(*value.array())) {
    text = list(written(*value.array(), 0, value.array()->size()));
  }
  return text.size() > longest ? "" : text;
}

std::string cure_of_vector(std::string_view key, const Value& value) {
  if (key == "gravity" && !value.array() && !value.table()) return write(key, downwards(value));
  if (value.table()) {
    const std::string cure = write(key, list_in(value));
    return cure.empty() ? "write " + std::string(key) + " = [x, y, z]" : cure;
  }
  if (const std::string* text = value.string()) {
    if (const auto axis = direction(*text)) return write(key, *axis);
    if (const auto numbers = numbers_in(*text); numbers.size() == 3) return write(key, list(numbers));
  }
  if (const Value::Array* entries = value.array()) {
    if (entries->empty() || entries->size() > 2 || !are_scalars(*entries)) return "";
    std::vector<std::string> three = written(*entries, 0, entries->size());
    three.resize(3, "0");
    return "write x, y and z, as in " + std::string(key) + " = " + list(three);
  }
  if (key == "scale" || key == "box") return write(key, list(std::vector<std::string>(3, as_written(value))));
  if (!is_scalar(value)) return "";
  return "write x, y and z, as in " + std::string(key) + " = [" + (is_number(value) ? as_written(value) : "1") + ", 0, 0]";
}

std::string cure_of_placement(std::string_view key, const Value& value) {
  const std::string usual = "write " + std::string(key) + " = { xyz = [x, y, z] }, with rpy = [r, p, y] or quat = [w, x, y, z]";
  const Value::Array* entries = value.array();
  if (value.string())
    if (const auto numbers = numbers_in(*value.string()); numbers.size() == 3)
      return write(key, "{ xyz = " + list(numbers) + " }");
  if (!entries || !are_scalars(*entries)) return usual;
  std::string cure;
  if (entries->size() == 3) cure = "{ xyz = " + as_written(value) + " }";
  if (entries->size() == 6) cure = "{ xyz = " + list(written(*entries, 0, 3)) + ", rpy = " + list(written(*entries, 3, 3)) + " }";
  cure = write(key, cure);
  return cure.empty() ? usual : cure;
}

std::string cure_of_inertia(const Value& value) {
  const char* const usual = "1 number for all, 3 for xx, yy, zz, or 6 for xx, yy, zz, xy, xz, yz";
  std::array<const Value*, 9> matrix{};
  std::size_t count = 0;
  if (const Value::Array* rows = value.array()) {
    for (const Value& row : *rows) {
      const Value::Array single{};
      if (is_scalar(row)) {
        if (count < 9) matrix[count] = &row;
        ++count;
      } else if (row.array()) {
        for (const Value& entry : *row.array()) {
          if (count < 9 && is_scalar(entry)) matrix[count] = &entry;
          ++count;
        }
      }
    }
    const bool whole = count == 9 && std::none_of(matrix.begin(), matrix.end(), [](const Value* v) { return v == nullptr; });
    return whole ? of_matrix(matrix) : usual;
  }
  if (!value.table()) return usual;
  std::vector<std::string> six;
  for (const char* key : {"xx", "yy", "zz", "xy", "xz", "yz"}) {
    const Value::Entry *short_one = value.find(key), *long_one = value.find("i" + std::string(key));
    const Value::Entry* entry = short_one ? short_one : long_one;
    six.push_back(entry && is_scalar(entry->value) ? as_written(entry->value) : "0");
  }
  const bool diagonal = std::all_of(six.begin() + 3, six.end(), [](const std::string& s) { return s == "0" || s == "0.0"; });
  if (std::all_of(six.begin(), six.end(), [](const std::string& s) { return s == "0"; })) return usual;
  return of_moments(std::move(six), diagonal);
}

std::string cure_of_table(std::string_view where, const Value& value) {
  const std::string given = is_scalar(value) ? as_written(value) : "";
  if (where == "limits") {
    if (value.boolean())
      return "`true` is for a mechanism with a model; a joint has limits = { lower = \"-90 deg\", upper = \"90 deg\" }";
    const std::string cure = write("limits", limits_of(value));
    return cure.empty() ? "write limits = { lower = \"-90 deg\", upper = \"90 deg\" }" : cure;
  }
  struct Form {
    // the value goes between `before` and `after`; `usual`: the hint if it is not a number
    const char *where, *before, *after, *usual;
  };
  static constexpr Form forms[] = {
      {"friction", "friction = { coulomb = ", ", speed = 0.01 }", "friction = { coulomb = \"2 N m\", speed = \"0.01 rad/s\" }"},
      {"strength", "strength = { force = ", " }, or { torque = … }", "strength = { force = \"4 kN\" }"},
      {"drive", "drive = { effort = ", " }", "drive = { effort = \"5 N m\" }, or { pd = … }, or { motion = … }"},
      {"pd", "", "", "pd = { kp = 100, kd = 10, target = \"30 deg\" }"},
      {"sine", "", "", "sine = { amplitude = 2, frequency = \"0.5 Hz\" }"},
      {"drag", "drag = { linear = ", " }", "drag = { quadratic = \"0.6 kg/m^3\", area = \"0.5 m^2\" }"},
      {"when", "", "", "when = { reaction_force = \"arm/elbow\", exceeds = \"4 kN\" }"},
      {"velocity", "", "", "velocity = { linear = [1, 0, 0], angular = [0, 0, 0.5] }"},
      {"mimic", "mimic = { stiffness = ", " }", "mimic = { stiffness = 100, damping = 1 }"},
      {"cylinder", "", "", "cylinder = { radius = 0.1, length = 1 }"},
      {"capsule", "", "", "capsule = { radius = 0.1, length = 1 }"},
      {"shape", "", "", "shape = { box = [1, 0.1, 0.1] }"},
      {"[world]", "", "", "[world] with gravity = [0, 0, -9.81]"},
      {"[integrate]", "", "", "[integrate] with step = \"1 ms\" and until = \"3 s\""},
      {"[output]", "[output] with every = ", "", "[output] with every = \"10 ms\""},
      {"[mechanism.chain]", "", "", "[mechanism.chain] with links = 10, length = \"5 cm\" and mass = \"10 g\""},
  };
  for (const Form& form : forms) {
    if (where != form.where) continue;
    const bool fits = *form.before != '\0' && !given.empty() && !(value.string() && where == "drive");
    return "write " + (fits ? form.before + given + form.after : std::string(form.usual));
  }
  return "";
}

std::string cure_of_zero(std::string_view where, std::string_view key) {
  if (key != "length") return "";
  return where == "capsule"    ? "without a length it is a sphere"
         : where == "cylinder" ? "a disc is a thin { ellipsoid = [0.3, 0.3, 1e-3] }"
                               : "";
}

}  // namespace momentree::io
