#include <momentree/sweep/sweep.hpp>

#include <charconv>
#include <cmath>
#include <limits>

#include <momentree/io/number_text.hpp>
#include <momentree/io/toml.hpp>

namespace momentree::sweep {

namespace {

// A number as TOML: with its unit, if it has one, as a string.
std::string toml_number(double value, const std::string& unit) {
  if (!std::isfinite(value)) return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
  const std::string text = io::number_text(value);
  return unit.empty() ? text : '"' + text + ' ' + unit + '"';
}

std::size_t index_of(double choice) { return static_cast<std::size_t>(choice); }

// The text of a string, without its quotes; other values as they are written.
std::string without_quotes(const std::string& toml) {
  const std::optional<Value> value = io::parse_toml_value(toml, {});
  return value && value->string() ? *value->string() : toml;
}

}  // namespace

std::vector<std::string> Sweep::overrides(std::uint64_t world) const {
  std::vector<double> values(plan->size());
  plan->values(world, values);
  std::vector<std::string> all;
  std::size_t at = 0;
  for (const Parameter& parameter : parameters) {
    std::string text = parameter.key + '=';
    if (!parameter.choices.empty()) {
      text += parameter.choices[index_of(values[at])];
    } else if (parameter.vector) {
      text += '[';
      for (std::size_t c = 0; c < parameter.components; ++c)
        text += (c > 0 ? ", " : "") + toml_number(values[at + c], parameter.unit);
      text += ']';
    } else {
      text += toml_number(values[at], parameter.unit);
    }
    at += parameter.components;
    all.push_back(std::move(text));
  }
  return all;
}

double number_of_choice(const std::string& choice) {
  const std::optional<Value> value = io::parse_toml_value(choice, {});
  const std::optional<double> number = value ? value->number() : std::nullopt;
  return number.value_or(std::numeric_limits<double>::quiet_NaN());
}

std::vector<ParameterColumn> parameter_columns(const Sweep& sweep) {
  std::vector<ParameterColumn> all;
  std::size_t at = 0;
  for (std::size_t p = 0; p < sweep.parameters.size(); ++p) {
    const Parameter& parameter = sweep.parameters[p];
    for (std::size_t c = 0; c < parameter.components; ++c) {
      ParameterColumn column{parameter.key, p, at + c, false};
      if (parameter.vector) column.name += '.' + std::to_string(c);
      for (const std::string& choice : parameter.choices) column.is_text = column.is_text || std::isnan(number_of_choice(choice));
      all.push_back(std::move(column));
    }
    at += parameter.components;
  }
  return all;
}

std::string parameter_text(const Sweep& sweep, const ParameterColumn& column, std::span<const double> values) {
  const Parameter& parameter = sweep.parameters[column.parameter];
  const double value = values[column.component];
  if (parameter.choices.empty()) return io::number_text(value);
  const std::string& choice = parameter.choices[index_of(value)];
  return column.is_text ? without_quotes(choice) : io::number_text(number_of_choice(choice));
}

double parameter_number(const Sweep& sweep, const ParameterColumn& column, std::span<const double> values) {
  const Parameter& parameter = sweep.parameters[column.parameter];
  const double value = values[column.component];
  if (parameter.choices.empty()) return value;
  return column.is_text ? std::numeric_limits<double>::quiet_NaN() : number_of_choice(parameter.choices[index_of(value)]);
}

}  // namespace momentree::sweep
