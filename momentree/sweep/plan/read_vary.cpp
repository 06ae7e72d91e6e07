// [vary] and [[correlated]].
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include <momentree/base/error.hpp>
#include <momentree/base/units.hpp>
#include <momentree/scenario/convert/toml_writer.hpp>
#include <momentree/sweep/plan/sweep_keys.hpp>
#include <momentree/sweep/plan/sweep_reading.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::sweep {

namespace {

using io::Fields;

constexpr std::size_t most_components = 1000;
constexpr std::size_t most_values = 1'000'000;

/// Reads the numbers of one parameter, which share a unit.
class Arguments {
 public:
  Arguments(std::string key, Parameter& parameter, io::Diagnostics& out)
      : key_(std::move(key)), parameter_(parameter), out_(out) {}

  /// The entries of a list of so many arguments, each with a number per component; empty, with a report, if something is wrong.
  /// `with_unit`: which of them have the unit of the parameter, one letter each: u or n (a plain number).
  std::vector<std::vector<double>> read(const Value& value, const char* what, std::string_view with_unit, const char* example) {
    std::vector<std::vector<double>> all;
    const Value::Array* entries = value.array();
    if (with_unit.size() == 1 && (entries == nullptr || !parameter_.vector)) {
      all.push_back(numbers(value, what, with_unit[0] == 'u'));
    } else if (entries == nullptr || entries->size() != with_unit.size()) {
      out_.error(value.place, std::string(what) + ": expected a list of " + std::to_string(with_unit.size()) + " entries",
                 std::string("for example ") + example);
      return {};
    } else {
      for (std::size_t i = 0; i < entries->size(); ++i) all.push_back(numbers((*entries)[i], what, with_unit[i] == 'u'));
    }
    for (const std::vector<double>& each : all)
      if (each.empty()) return {};
    for (std::vector<double>& each : all) {
      if (each.size() == 1) each.resize(parameter_.components, each.front());
      if (each.size() != parameter_.components) {
        out_.error(value.place, std::string(what) + ": vectors of different lengths", "give each the same number of components");
        return {};
      }
    }
    return all;
  }

 private:
  std::vector<double> numbers(const Value& value, const char* what, bool with_unit) {
    std::vector<double> all;
    if (const Value::Array* entries = value.array()) {
      if (entries->empty() || entries->size() > most_components) {
        out_.error(value.place, std::string(what) + ": a vector of " + std::to_string(entries->size()) + " components");
        return {};
      }
      for (const Value& entry : *entries) {
        const std::optional<double> x = number(entry, what, with_unit);
        if (!x) return {};
        all.push_back(*x);
      }
      parameter_.vector = true;
      if (all.size() > 1) parameter_.components = all.size();
      return all;
    }
    if (const std::optional<double> x = number(value, what, with_unit)) all.push_back(*x);
    return all;
  }

  std::optional<double> number(const Value& value, const char* what, bool with_unit) {
    std::optional<double> found = value.number();
    std::string unit;
    if (const std::string* text = value.string()) {
      double x = 0;
      const char* const end = text->data() + text->size();
      const auto read = std::from_chars(text->data() + (text->starts_with('+') ? 1 : 0), end, x);
      if (read.ec == std::errc{}) {
        const char* rest = read.ptr;
        while (rest != end && *rest == ' ') ++rest;
        unit.assign(rest, end);
        while (unit.ends_with(' ')) unit.pop_back();
        found = x;
      }
    }
    if (!found) {
      out_.error(value.place, std::string(what) + ": expected a number, not " + value.type_name(),
                 "a number, or a string with a unit such as \"30 deg\"");
      return std::nullopt;
    }
    if (!std::isfinite(*found)) {
      out_.error(value.place, std::string(what) + ": expected a finite number");
      return std::nullopt;
    }
    if (!with_unit) {
      if (unit.empty()) return found;
      out_.error(value.place, std::string(what) + ": this number has no unit");
      return std::nullopt;
    }
    if (seen_ && unit != parameter_.unit && !(*found == 0 && value.number())) {
      out_.error(value.place,
                 std::string(what) + ": two units, " + io::in_quotes(parameter_.unit) + " and " + io::in_quotes(unit),
                 "give all numbers of a parameter the same unit");
      return std::nullopt;
    }
    if (!seen_ && !(*found == 0 && value.number())) parameter_.unit = unit, seen_ = true;
    return found;
  }

  std::string key_;
  Parameter& parameter_;
  io::Diagnostics& out_;
  bool seen_ = false;  ///< the parameter's unit is known
};

// A distribution that a sweep file can name.
struct Family {
  const char* key;
  std::string_view arguments;  ///< u: in the unit of the parameter, n: a plain number
  const char* example;
  Distribution::Kind (*make)(const std::vector<double>& x);
};

constexpr Family families[] = {
    {"uniform", "uu", "uniform = [0.2, 0.4]",
     [](const auto& x) -> Distribution::Kind {
       return Uniform{x[0], x[1]};
     }},
    {"latin", "uu", "latin = [0.2, 0.4]",
     [](const auto& x) -> Distribution::Kind {
       return Uniform{x[0], x[1]};
     }},
    {"sobol", "uu", "sobol = [0.2, 0.4]",
     [](const auto& x) -> Distribution::Kind {
       return Uniform{x[0], x[1]};
     }},
    {"normal", "uu", "normal = [1.0, 0.1]",
     [](const auto& x) -> Distribution::Kind {
       return Normal{x[0], x[1]};
     }},
    {"lognormal", "nn", "lognormal = [0.0, 0.1]",
     [](const auto& x) -> Distribution::Kind {
       return Lognormal{x[0], x[1]};
     }},
    {"exponential", "u", "exponential = 2.0", [](const auto& x) -> Distribution::Kind { return Exponential{x[0]}; }},
    {"weibull", "un", "weibull = [\"20 N\", 5]",
     [](const auto& x) -> Distribution::Kind {
       return Weibull{x[0], x[1]};
     }},
    {"triangular", "uuu", "triangular = [1, 2, 4]",
     [](const auto& x) -> Distribution::Kind {
       return Triangular{x[0], x[1], x[2]};
     }},
    {"beta", "nn", "beta = [2, 3]",
     [](const auto& x) -> Distribution::Kind {
       return Beta{x[0], x[1]};
     }},
};

// Reports the error of a distribution, a range or a plan at its place.
template <class Make>
bool attempt(Place place, const char* what, io::Diagnostics& out, const Make& make) {
  try {
    make();
    return true;
  } catch (const Error& error) {
    const bool named = error.problem.starts_with(what);
    out.error(place, (named ? "" : std::string(what) + ": ") + error.problem, error.hint);
    return false;
  }
}

class Vary {
 public:
  Vary(const Value::Entry& entry, SweepReading& reading) : entry_(entry), reading_(reading), out_(reading.out) {
    parameter_.key = entry.key;
    parameter_.place = entry.place;
  }

  void read() {
    if (entry_.key.empty() || entry_.key.find('=') != std::string::npos)
      return out_.error(entry_.place, "[vary]: " + io::in_quotes(entry_.key) + " is not a key of the scenario",
                        "a dotted path as in --set: \"event.grasp.when.below\"");
    if (const Value::Array* values = entry_.value.array()) {
      if (list(*values, entry_.value.place)) add(ListValues{values->size()});
      return;
    }
    if (!entry_.value.table())
      return out_.error(entry_.value.place, entry_.key + ": this is one value, which does not vary",
                        "give a list or a distribution: { uniform = [0.2, 0.4] }");
    Fields fields(entry_.value, vary_table, out_, entry_.key);
    const std::size_t errors = out_.errors();
    const Value* chosen = nullptr;
    const char* key = nullptr;
    const auto find = [&](const char* name) {
      const Value* value = fields.find(name);
      if (value == nullptr) return;
      if (chosen != nullptr)
        out_.error(value->place, entry_.key + ": both '" + key + "' and '" + name + "'", "a value is varied in one way");
      else
        chosen = value, key = name;
    };
    find("list");
    find("range");
    for (const Family& family : families) find(family.key);
    const Value *weights = fields.find("weights"), *within = fields.find("within");
    const auto sampling = fields.string("sampling");
    const Place sampling_place = fields.place_of("sampling");
    fields.finish();
    if (out_.errors() > errors) return;
    if (chosen == nullptr)
      return out_.error(entry_.value.place, entry_.key + ": does not say how it varies",
                        "for example { uniform = [0.2, 0.4] } or { range = [0, 1, 11] }");
    const std::string_view form = key;
    if (weights != nullptr && form != "list") return out_.error(weights->place, "weights: goes with list");
    if (within != nullptr && form != "normal" && form != "beta")
      return out_.error(within->place, "within: goes with normal and beta");
    std::optional<Sampling> how = read_sampling(sampling, sampling_place);
    if (!how) return;
    if (sampling && (form == "range" || form == "latin" || form == "sobol" || (form == "list" && weights == nullptr)))
      return out_.error(sampling_place, "sampling: goes with a distribution");
    if (form == "latin") how = Sampling::latin;
    if (form == "sobol") how = Sampling::sobol;
    if (form == "list")
      weighted_list(*chosen, weights, *how);
    else if (form == "range")
      range(*chosen);
    else
      distribution(*std::find_if(std::begin(families), std::end(families), [&](const Family& f) { return form == f.key; }),
                   *chosen, within, *how);
  }

 private:
  // The unit of all entries; a plain 0 goes with any. Empty: there is no common one.
  static std::string unit_of(const Value::Array& values) {
    std::string unit;
    for (const Value& value : values) {
      if (value.number() == 0.0) continue;
      const std::optional<WrittenQuantity> quantity = value.string() ? split_quantity(*value.string()) : std::nullopt;
      if (!quantity || (!unit.empty() && quantity->unit != unit)) return "";
      unit = quantity->unit;
    }
    return unit;
  }

  std::optional<Sampling> read_sampling(const std::optional<std::string>& word, Place place) {
    if (!word || *word == "random") return Sampling::random;
    if (*word == "latin") return Sampling::latin;
    if (*word == "sobol") return Sampling::sobol;
    out_.error(place, "sampling: there is no " + io::in_quotes(*word), "\"random\", \"latin\" or \"sobol\"");
    return std::nullopt;
  }

  bool list(const Value::Array& values, Place place) {
    if (values.empty()) {
      out_.error(place, entry_.key + ": the list is empty", "give at least one value");
      return false;
    }
    if (values.size() > most_values) {
      out_.error(place, entry_.key + ": a list of more than " + std::to_string(most_values) + " values", "use range");
      return false;
    }
    for (const Value& value : values) {
      std::string& text = parameter_.choices.emplace_back(io::toml_value_text(value));
      std::replace(text.begin(), text.end(), '\n', ' ');  // long values have several lines; within strings they are escaped
    }
    parameter_.unit = unit_of(values);
    parameter_.about = std::to_string(values.size()) + (values.size() == 1 ? " value" : " values");
    return true;
  }

  void weighted_list(const Value& value, const Value* weights, Sampling how) {
    const Value::Array& values = io::read_list(value, "list", out_);
    if (!value.array() || !list(values, value.place)) return;
    if (weights == nullptr) return add(ListValues{values.size()});
    Choice choice;
    const Value::Array& numbers = io::read_list(*weights, "weights", out_);
    for (const Value& each : numbers) {
      const std::optional<double> weight = each.number();
      if (!weight) return out_.error(each.place, "weights: expected numbers");
      choice.weights.push_back(*weight);
    }
    if (choice.weights.size() != values.size())
      return out_.error(weights->place, "weights: expected " + std::to_string(values.size()) + " numbers, one per value");
    attempt(weights->place, "weights", out_, [&] { add(Sampled{how, {Distribution(std::move(choice))}}); });
  }

  void range(const Value& value) {
    const Value::Array* entries = value.array();
    if (entries == nullptr || entries->size() != 3)
      return out_.error(value.place, "range: expected [from, to, count]", "for example range = [0.0, 0.4, 5]");
    const Value ends(Value::Array{(*entries)[0], (*entries)[1]}, value.place);
    Arguments arguments(entry_.key, parameter_, out_);
    const std::vector<std::vector<double>> x = arguments.read(ends, "range", "uu", "range = [0.0, 0.4, 5]");
    if (x.empty()) return;
    if (parameter_.vector) return out_.error(value.place, "range: expected numbers", "vary one component, as in \"….angular.0\"");
    const auto count =
        io::read_whole((*entries)[2], "range: the count of values", 1, std::numeric_limits<std::int64_t>::max(), out_);
    if (!count) return;
    parameter_.about =
        "from " + io::number_text(x[0][0]) + " to " + io::number_text(x[1][0]) + ", " + std::to_string(*count) + " values";
    add(RangeValues{x[0][0], x[1][0], static_cast<std::size_t>(*count)});
  }

  void distribution(const Family& family, const Value& value, const Value* within, Sampling how) {
    Arguments arguments(entry_.key, parameter_, out_);
    const std::vector<std::vector<double>> x = arguments.read(value, family.key, family.arguments, family.example);
    if (x.empty()) return;
    std::vector<std::vector<double>> bounds;
    if (within != nullptr) {
      bounds = arguments.read(*within, "within", "uu", "within = [0, 2]");
      if (bounds.empty()) return;
    }
    Sampled sampled{how, {}};
    for (std::size_t c = 0; c < parameter_.components; ++c) {
      std::vector<double> numbers;
      for (const std::vector<double>& each : x) numbers.push_back(c < each.size() ? each[c] : each.front());
      const bool good = attempt(value.place, family.key, out_, [&] {
        Distribution::Kind kind = family.make(numbers);
        if (!bounds.empty()) {
          const auto bound = [&](std::size_t i) { return c < bounds[i].size() ? bounds[i][c] : bounds[i].front(); };
          if (auto* normal = std::get_if<Normal>(&kind)) normal->within = Interval{bound(0), bound(1)};
          if (auto* beta = std::get_if<Beta>(&kind)) beta->within = Interval{bound(0), bound(1)};
        }
        sampled.components.emplace_back(std::move(kind));
      });
      if (!good) return;
    }
    for (std::size_t c = 0; c < std::min<std::size_t>(sampled.components.size(), 3); ++c)
      parameter_.about += (c > 0 ? "; " : "") + sampled.components[c].text();
    if (sampled.components.size() > 3) parameter_.about += "; …";
    if (how != Sampling::random) parameter_.about += how == Sampling::latin ? " (Latin hypercube)" : " (Sobol sequence)";
    add(std::move(sampled));
  }

  void add(std::variant<ListValues, RangeValues, Sampled> values) {
    reading_.variables.push_back({entry_.key, std::move(values)});
    reading_.sweep.parameters.push_back(std::move(parameter_));
  }

  const Value::Entry& entry_;
  SweepReading& reading_;
  io::Diagnostics& out_;
  Parameter parameter_;
};

}  // namespace

void read_vary(const Value::Entry& entry, SweepReading& reading) { Vary(entry, reading).read(); }

std::vector<Correlation> read_correlations(const Value& tables, SweepReading& reading) {
  io::Diagnostics& out = reading.out;
  std::vector<Correlation> all;
  const std::vector<ParameterColumn> columns = parameter_columns(reading.sweep);
  std::vector<std::string> names;
  for (const ParameterColumn& column : columns) names.push_back(column.name);
  for (const Value* table : io::tables_of(tables, "correlated", out)) {
    Fields fields(*table, correlated_table, out);
    const Value* parameters = fields.require("parameters");
    const std::optional<double> coefficient = fields.number("coefficient");
    if (!fields.has("coefficient")) fields.require("coefficient");
    fields.finish();
    if (parameters == nullptr || !coefficient) continue;
    const Value::Array* entries = parameters->array();
    if (entries == nullptr || entries->size() != 2 || !(*entries)[0].string() || !(*entries)[1].string()) {
      out.error(parameters->place, "parameters: expected a list of two keys of [vary]");
      continue;
    }
    std::size_t found[2] = {0, 0};
    bool good = true;
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string& name = *(*entries)[i].string();
      const auto at = std::find(names.begin(), names.end(), name);
      if (at == names.end()) {
        out.error((*entries)[i].place, "[vary] has no " + io::in_quotes(name), did_you_mean(name, names));
        good = false;
      } else {
        found[i] = columns[static_cast<std::size_t>(at - names.begin())].component;
      }
    }
    if (good) all.push_back({found[0], found[1], *coefficient});
  }
  return all;
}

}  // namespace momentree::sweep
