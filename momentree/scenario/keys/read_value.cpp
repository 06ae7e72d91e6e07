// Numbers with units, vectors, placements and inertias.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <momentree/math/unit.hpp>
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/scenario/mistakes/shapes.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

constexpr Key placement_entries[] = {
    {"xyz", type::vector(dimension::length), "Position", "[0, 0, 0]"},
    {"rpy", type::vector(dimension::angle), "Rotations about the fixed x, y and z axes, in this order", "[0, 0, 0]"},
    {"quat", type::other(R"({"type": "array", "items": {"type": ["number", "string"]}, "minItems": 4, "maxItems": 4})"),
     "Unit quaternion w, x, y, z"},
};

std::string no_cure() { return {}; }

std::string labelled(std::string_view label, std::string_view what) { return std::string(label) + ": " + std::string(what); }

// The entries of a list that has one of the allowed lengths. `cure`: returns the hint for any other value.
template <class Cure>
const Value::Array* list_of(const Value& value, std::string_view label, std::string_view expected,
                            std::initializer_list<std::size_t> lengths, Diagnostics& out, Cure cure) {
  const Value::Array* entries = value.array();
  if (!entries) {
    out.error(value.place, labelled(label, "expected ") + std::string(expected) + ", found " + value.type_name(), cure());
    return nullptr;
  }
  for (const std::size_t length : lengths)
    if (entries->size() == length) return entries;
  out.error(value.place,
            labelled(label, "expected ") + std::string(expected) + ", found a list of " + std::to_string(entries->size()),
            cure());
  return nullptr;
}

}  // namespace

constinit const KeyTable placement_table{"placement",
                                         "placement",
                                         "A placement: a position, and a rotation as rpy or as a quaternion",
                                         placement_entries,
                                         {{KeyRule::How::not_two, "rpy quat"}}};

std::optional<double> read_number(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out) {
  const std::optional<double> number = read_plain_number(value, expected, label, out);
  // Slightly more than one turn: limits of one turn are written with different roundings.
  constexpr double turn = 6.283185307179586, suspicious = 1.001 * turn, of_degrees = 1e5;
  if (!number || !(expected == dimension::angle) || value.string()) return number;
  if (std::fabs(*number) <= suspicious || std::fabs(*number) > of_degrees) return number;
  const std::string turns = rounded_text(std::fabs(*number) / turn, 3);
  const std::string given = as_written(value);
  out.warning(value.place, labelled(label, given) + " is read as radians, " + turns + " turns",
              "write \"" + given + " deg\" for degrees, or \"" + given + " rad\" if that is what you mean");
  return number;
}

std::optional<double> read_plain_number(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out) {
  if (const auto number = value.number()) {
    if (std::isfinite(*number)) return *number;
    out.error(value.place, labelled(label, "must be finite"));
    return {};
  }
  if (const std::string* text = value.string()) {
    QuantityProblem problem;
    const auto number = parse_quantity(*text, expected, problem);
    if (!number) out.error(value.place, labelled(label, problem.what), std::move(problem.hint));
    return number;
  }
  out.error(value.place, labelled(label, "expected ") + name_of(expected) + ", found " + value.type_name(),
            "for example " + example_of(expected));
  return {};
}

std::optional<std::int64_t> read_whole(const Value& value, std::string_view label, std::int64_t least, std::int64_t most,
                                       Diagnostics& out) {
  const std::int64_t* const whole = value.integer();
  if (whole != nullptr && *whole >= least && *whole <= most) return *whole;
  const bool bounded = most < std::numeric_limits<std::int64_t>::max();
  const double x = value.number().value_or(std::nan(""));
  const bool decimal = whole == nullptr && x == std::floor(x) && x >= static_cast<double>(least) &&
                       x <= static_cast<double>(most) && std::fabs(x) < 1e15;
  const std::string range =
      bounded ? " from " + std::to_string(least) + " to " + std::to_string(most) : " of at least " + std::to_string(least);
  const std::string found = value.number() || value.string() ? as_written(value) : "";
  out.error(value.place,
            labelled(label, "expected a whole number") + range + ", found " + (found.empty() ? value.type_name() : found),
            decimal ? "write " + std::to_string(static_cast<std::int64_t>(x)) : "");
  return {};
}

std::optional<double> read_real(const Value& value, std::string_view label, Diagnostics& out) {
  const std::optional<double> number = value.number();
  if (!number) out.error(value.place, labelled(label, "expected a number, found ") + value.type_name());
  return number;
}

std::vector<double> read_reals(const Value& value, std::size_t count, std::string_view label, Diagnostics& out) {
  const Value::Array& entries = read_list(value, label, out);
  if (value.array() && count != entries.size())
    out.error(value.place, labelled(label, "expected ") + std::to_string(count) + (count == 1 ? " number" : " numbers") +
                               ", found a list of " + std::to_string(entries.size()));
  if (count != entries.size()) return {};
  std::vector<double> all;
  for (const Value& entry : entries) {
    const auto number = read_real(entry, label, out);
    if (!number) return {};
    all.push_back(*number);
  }
  return all;
}

const Value::Array& read_list(const Value& value, std::string_view label, Diagnostics& out) {
  static const Value::Array none;
  if (value.array()) return *value.array();
  out.error(value.place, labelled(label, "expected a list, found ") + value.type_name());
  return none;
}

const Value::Table& read_table(const Value& value, std::string_view label, Diagnostics& out) {
  static const Value::Table none;
  if (value.table()) return *value.table();
  out.error(value.place, labelled(label, "expected a table, found ") + value.type_name());
  return none;
}

std::optional<std::string> read_string(const Value& value, std::string_view label, Diagnostics& out) {
  if (const std::string* text = value.string()) return *text;
  const bool number = value.integer() || value.real();
  out.error(value.place, labelled(label, "expected a string, found ") + value.type_name(),
            number ? "write \"" + as_written(value) + "\"" : "");
  return {};
}

std::optional<Vec3> read_vec3(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out) {
  const Value::Array* entries = list_of(value, label, "three numbers", {3}, out, [&] { return cure_of_vector(label, value); });
  if (!entries) return {};
  const auto x = read_number((*entries)[0], expected, label, out), y = read_number((*entries)[1], expected, label, out),
             z = read_number((*entries)[2], expected, label, out);
  if (!x || !y || !z) return {};
  return Vec3{*x, *y, *z};
}

std::optional<Pose> read_pose(const Value& value, std::string_view label, Diagnostics& out) {
  if (!value.table()) {
    out.error(value.place, labelled(label, "expected a table, found ") + value.type_name(), cure_of_placement(label, value));
    return {};
  }
  Fields fields(value, placement_table, out, in_quotes(label));
  const std::size_t errors = out.errors();
  Pose pose;
  if (const auto xyz = fields.vec3("xyz")) pose.position = *xyz;
  if (const auto rpy = fields.vec3("rpy")) pose.rotation = from_rpy(rpy->x, rpy->y, rpy->z);
  if (const Value* quat = fields.find("quat")) {
    if (fields.has("rpy")) out.error(quat->place, labelled(label, "takes 'rpy' or 'quat', not both"));
    if (const Value::Array* entries = list_of(*quat, "quat", "four numbers w, x, y, z", {4}, out, no_cure)) {
      double q[4] = {1, 0, 0, 0};
      for (std::size_t i = 0; i < 4; ++i)
        q[i] = read_number((*entries)[i], dimension::number, "quat", out).value_or(i == 0 ? 1 : 0);
      const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
      if (errors == out.errors() && !(std::fabs(length - 1) <= 1e-6))
        out.error(quat->place,
                  length == 0 ? "quat: a quaternion of zeros is not a rotation" : "quat: the length of the quaternion is not 1",
                  length == 0 ? "the identity is [1, 0, 0, 0]" : "scale it: w² + x² + y² + z² = 1");
      else if (errors == out.errors())
        pose.rotation = unit(Quat{q[0], q[1], q[2], q[3]});
    }
  }
  fields.finish();
  if (errors != out.errors()) return {};
  return pose;
}

std::optional<Sym3> read_inertia(const Value& value, std::string_view label, Diagnostics& out) {
  if (!value.array() && !value.table()) {
    const auto all = read_number(value, dimension::inertia, label, out);
    if (!all) return {};
    return diagonal(*all);
  }
  if (value.array() &&
      std::any_of(value.array()->begin(), value.array()->end(), [](const Value& v) { return v.array() != nullptr; })) {
    out.error(value.place, labelled(label, "expected 1, 3 or 6 numbers, found a list of lists"), cure_of_inertia(value));
    return {};
  }
  const Value::Array* entries =
      list_of(value, label, "1, 3 or 6 numbers", {1, 3, 6}, out, [&] { return cure_of_inertia(value); });
  if (!entries) return {};
  double i[6] = {};
  bool good = true;
  for (std::size_t k = 0; k < entries->size(); ++k) {
    const auto number = read_number((*entries)[k], dimension::inertia, label, out);
    good = good && number;
    i[k] = number.value_or(0);
  }
  if (!good) return {};
  return entries->size() == 1 ? diagonal(i[0]) : Sym3{i[0], i[1], i[2], i[3], i[4], i[5]};
}

}  // namespace momentree::io
