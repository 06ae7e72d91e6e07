// Values that change with time: a number, a table, a sine, a ramp.
#include <cmath>

#include <momentree/io/dof_values.hpp>

namespace momentree::io {

namespace {

std::string at(std::string_view label, std::string_view what) { return std::string(label) + ": " + std::string(what); }

std::optional<Signal> read_table(const Value& value, const Dimension& expected, std::string_view label, Signal::Ends ends,
                                 Diagnostics& out) {
  const Value::Array* entries = value.array();
  const char* const example = "for example table = [[0, 1], [\"2 s\", 5]]";
  if (!entries || entries->empty()) {
    out.error(value.place,
              at(label, entries ? "the table is empty" : "expected a list of [time, value], found ") +
                  (entries ? "" : value.type_name()),
              example);
    return {};
  }
  std::vector<Signal::Knot> knots;
  bool good = true;
  for (const Value& entry : *entries) {
    if (!entry.array() || entry.array()->size() != 2) {
      out.error(entry.place,
                at(label, "expected [time, value], found ") +
                    (entry.array() ? "a list of " + std::to_string(entry.array()->size()) : entry.type_name()),
                example);
      return {};
    }
    const auto time = read_number((*entry.array())[0], dimension::time, label, out);
    const auto y = read_plain_number((*entry.array())[1], expected, label, out);
    good = good && time && y;
    if (!good) continue;
    if (!knots.empty() && !(*time > knots.back().time)) {
      out.error(entry.place, at(label, "the table's times must increase: this entry is not after the one before it"),
                "sort the entries; for a jump, let the value change within a short time");
      return {};
    }
    knots.push_back({*time, *y});
  }
  if (!good) return {};
  if (knots.size() == 1 && ends == Signal::Ends::free) {
    out.error(value.place, at(label, "a table with free ends needs two entries"), example);
    return {};
  }
  return Signal::table(std::move(knots), ends);
}

// The behaviour of a motion table before its first and after its last entry.
std::optional<Signal::Ends> read_ends(const Value& value, bool motion, Diagnostics& out) {
  const std::string* const ends = value.string();
  if (!motion)
    out.error(value.place, "ends: this key is for tables that are motions; others are linear between their entries",
              "leave 'ends' out");
  else if (ends == nullptr || (*ends != "rest" && *ends != "free"))
    out.error(value.place, "ends: expected \"rest\" or \"free\"",
              "at rest at both ends, or at a constant rate before the first entry and after the last one");
  else
    return *ends == "free" ? Signal::Ends::free : Signal::Ends::rest;
  return {};
}

std::optional<Signal> read_sine(const Value& value, const Dimension& expected, Diagnostics& out) {
  Fields fields(value, "sine", out);
  if (!value.table()) return {};
  const std::size_t errors = out.errors();
  fields.require("amplitude", "for example sine = { amplitude = 2, frequency = \"0.5 Hz\" }");
  fields.require("frequency", "in Hz: cycles per second");
  const double amplitude = fields.number("amplitude", expected).value_or(0);
  const double frequency = fields.not_negative("frequency", dimension::frequency).value_or(0);
  const double phase = fields.number("phase", dimension::angle).value_or(0);
  const double offset = fields.number("offset", expected).value_or(0);
  fields.finish();
  if (errors != out.errors()) return {};
  return Signal::sine(amplitude, frequency, phase, offset);
}

}  // namespace

std::optional<Signal> read_signal(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out) {
  return read_signal(value, expected, label, false, out);
}

std::optional<Signal> read_signal(const Value& value, const Dimension& expected, std::string_view label, bool motion,
                                  Diagnostics& out) {
  if (!value.table()) {
    const auto number = read_number(value, expected, label, out);
    return number ? std::optional<Signal>(*number) : std::nullopt;
  }
  const std::size_t errors = out.errors();
  Fields fields(value, std::string(label), out, "signal");
  const Value *table = fields.find("table"), *sine = fields.find("sine"), *ends = fields.find("ends");
  const Value* const ramp = fields.has("rate") ? &value : nullptr;
  const std::optional<double> rate = fields.number("rate", expected / dimension::time);
  const std::optional<double> offset = fields.number("offset", expected);
  fields.finish();
  if (errors != out.errors()) return {};
  if ((table != nullptr) + (sine != nullptr) + (ramp != nullptr) != 1) {
    out.error(value.place,
              at(label, table || sine || ramp ? "is one of 'table', 'sine' and 'rate', not several"
                                              : "expected a number, { table = … }, { sine = … } or { rate = … }"),
              "for example { table = [[0, 1], [2, 5]] } or { sine = { amplitude = 2, frequency = \"0.5 Hz\" } }");
    return {};
  }
  if (offset && !ramp) {
    out.error(fields.place_of("offset"), "offset: belongs to a 'rate'", sine ? "put it into the sine's own table" : "");
    return {};
  }
  if (ends != nullptr && table == nullptr) {
    out.error(ends->place, "ends: belongs to a 'table'");
    return {};
  }
  if (sine) return read_sine(*sine, expected, out);
  if (ramp) return motion && !offset ? Signal::ramp_from_here(*rate) : Signal::ramp(*rate, offset.value_or(0));
  const std::optional<Signal::Ends> how = ends ? read_ends(*ends, motion, out) : Signal::Ends::rest;
  return how ? read_table(*table, expected, label, *how, out) : std::nullopt;
}

}  // namespace momentree::io
