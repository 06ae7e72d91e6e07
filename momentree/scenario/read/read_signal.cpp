// Values that change with time: a number, a table, a sine, a ramp.
#include <momentree/scenario/keys/dof_values.hpp>

namespace momentree::io {

namespace {

std::string at(std::string_view label, std::string_view what) { return std::string(label) + ": " + std::string(what); }

class Reader {
 public:
  Reader(const SignalRules& rules, std::string_view label, Diagnostics& out) : rules_(rules), label_(label), out_(out) {}

  std::optional<Signal> read(const Value& value) {
    if (!value.table()) {
      const auto constant = number(value, rules_.expected, label_);
      return constant ? std::optional<Signal>(*constant) : std::nullopt;
    }
    const std::size_t errors = out_.errors();
    Fields fields(value, std::string(label_), out_, rules_.document ? "" : "signal");
    const Value *table = fields.find("table"), *sine = fields.find("sine"), *ends = fields.find("ends");
    const bool ramp = fields.has("rate"), offset = fields.has("offset");
    for (const SignalKey& key : ramp_keys()) read(fields, key);
    if (rules_.document)
      parts_.from_here = fields.boolean("from_here").value_or(false);
    else
      parts_.from_here = rules_.motion && !offset;
    fields.finish();
    if (errors != out_.errors()) return {};
    if ((table != nullptr) + (sine != nullptr) + ramp != 1) {
      out_.error(value.place,
                 at(label_, table || sine || ramp ? "is one of 'table', 'sine' and 'rate', not several"
                                                  : "expected a number, { table = … }, { sine = … } or { rate = … }"),
                 hint("for example { table = [[0, 1], [2, 5]] } or { sine = { amplitude = 2, frequency = \"0.5 Hz\" } }"));
    } else if (offset && !ramp) {
      out_.error(fields.place_of("offset"), "offset: belongs to a 'rate'", sine ? "put it into the sine's own table" : "");
    } else if (ends != nullptr && table == nullptr) {
      out_.error(ends->place, "ends: belongs to a 'table'");
    } else if (sine) {
      read_sine(*sine);
    } else if (ramp) {
      parts_.form = SignalParts::Form::ramp;
    } else {
      if (ends) read_ends(*ends);
      if (errors == out_.errors()) read_table(*table);
    }
    if (errors != out_.errors()) return {};
    return parts_.signal();
  }

 private:
  // Hints are in the syntax of scenarios.
  const char* hint(const char* text) const { return rules_.document ? "" : text; }

  std::optional<double> number(const Value& value, const Dimension& expected, std::string_view label) {
    return rules_.document ? read_real(value, label, out_) : read_number(value, expected, label, out_);
  }

  void read(Fields& fields, const SignalKey& key) {
    const Value* value = fields.find(key.key);
    const auto given = value ? number(*value, key.dimension(rules_.expected), key.key) : std::nullopt;
    if (!given) return;
    if (key.range == Range::not_negative && *given < 0 && !rules_.document)
      out_.error(value->place, at(key.key, "must not be negative"));
    parts_.*key.number = *given;
  }

  void read_sine(const Value& value) {
    Fields fields(value, "sine", out_, rules_.document ? "" : nullptr);
    if (!value.table()) return;
    for (const SignalKey& key : sine_keys()) {
      if (key.required) fields.require(key.key, hint(key.required));
      read(fields, key);
    }
    fields.finish();
    parts_.form = SignalParts::Form::sine;
  }

  // The behaviour of a motion's table before its first and after its last entry.
  void read_ends(const Value& value) {
    const std::string* const ends = value.string();
    if (!rules_.motion && !rules_.document)
      out_.error(value.place, "ends: this key is for tables that are motions; others are linear between their entries",
                 "leave 'ends' out");
    else if (ends == nullptr || (*ends != "rest" && *ends != "free"))
      out_.error(value.place, "ends: expected \"rest\" or \"free\"",
                 "at rest at both ends, or at a constant rate before the first entry and after the last one");
    else
      parts_.ends = *ends == "free" ? Signal::Ends::free : Signal::Ends::rest;
  }

  void read_table(const Value& value) {
    const Value::Array* entries = value.array();
    const char* const example = hint("for example table = [[0, 1], [\"2 s\", 5]]");
    if (!entries || entries->empty())
      return out_.error(value.place,
                        at(label_, entries ? "the table is empty" : "expected a list of [time, value], found ") +
                            (entries ? "" : value.type_name()),
                        example);
    bool good = true;
    for (const Value& entry : *entries) {
      if (!entry.array() || entry.array()->size() != 2)
        return out_.error(entry.place,
                          at(label_, "expected [time, value], found ") +
                              (entry.array() ? "a list of " + std::to_string(entry.array()->size()) : entry.type_name()),
                          example);
      const Value &first = (*entry.array())[0], &second = (*entry.array())[1];
      const auto time = number(first, dimension::time, label_);
      const auto y = rules_.document ? read_real(second, label_, out_) : read_plain_number(second, rules_.expected, label_, out_);
      good = good && time && y;
      if (!good) continue;
      if (!parts_.table.empty() && !(*time > parts_.table.back().time))
        return out_.error(entry.place, at(label_, "the table's times must increase: this entry is not after the one before it"),
                          "sort the entries; for a jump, let the value change within a short time");
      parts_.table.push_back({*time, *y});
    }
    if (good && parts_.table.size() == 1 && parts_.ends == Signal::Ends::free)
      out_.error(value.place, at(label_, "a table with free ends needs two entries"), example);
    parts_.form = SignalParts::Form::table;
  }

  const SignalRules& rules_;
  const std::string_view label_;
  Diagnostics& out_;
  SignalParts parts_;
};

}  // namespace

std::optional<Signal> read_signal(const Value& value, const SignalRules& rules, std::string_view label, Diagnostics& out) {
  return Reader(rules, label, out).read(value);
}

}  // namespace momentree::io
