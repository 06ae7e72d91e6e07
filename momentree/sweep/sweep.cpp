#include <momentree/sweep/sweep.hpp>

#include <charconv>
#include <cmath>
#include <limits>

#include <momentree/base/units.hpp>
#include <momentree/text/number_text.hpp>
#include <momentree/text/toml.hpp>

namespace momentree::sweep {

namespace {

// A number as TOML: with its unit, if it has one, as a string.
std::string toml_number(double value, const std::string& unit) {
  if (!std::isfinite(value)) return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
  const std::string text = io::number_text(value);
  return unit.empty() ? text : '"' + text + ' ' + unit + '"';
}

std::size_t index_of(double choice) { return static_cast<std::size_t>(choice); }

}  // namespace

std::string override_text(const Parameter& parameter, std::span<const double> components) {
  std::string text = parameter.key + '=';
  if (!parameter.choices.empty()) return text + parameter.choices[index_of(components[0])];
  if (!parameter.vector) return text + toml_number(components[0], parameter.unit);
  text += '[';
  for (std::size_t c = 0; c < components.size(); ++c) text += (c > 0 ? ", " : "") + toml_number(components[c], parameter.unit);
  return text + ']';
}

std::vector<std::string> Sweep::overrides(std::uint64_t world) const {
  std::vector<double> values(plan->size());
  plan->values(world, values);
  std::vector<std::string> all;
  std::span<const double> rest = values;
  for (const Parameter& parameter : parameters) {
    all.push_back(override_text(parameter, rest.first(parameter.components)));
    rest = rest.subspan(parameter.components);
  }
  return all;
}

std::vector<ParameterColumn> parameter_columns(const Sweep& sweep) {
  std::vector<ParameterColumn> all;
  std::size_t at = 0;
  for (std::size_t p = 0; p < sweep.parameters.size(); ++p) {
    const Parameter& parameter = sweep.parameters[p];
    for (std::size_t c = 0; c < parameter.components; ++c) {
      ParameterColumn column{.name = parameter.key, .parameter = p, .component = at + c};
      if (parameter.vector) column.name += '.' + std::to_string(c);
      for (const std::string& choice : parameter.choices) {
        const std::optional<Value> value = io::parse_toml_value(choice, {});
        std::optional<double> number = value ? value->number() : std::nullopt;
        if (value && value->string() && !parameter.unit.empty())
          if (const std::optional<WrittenQuantity> quantity = split_quantity(*value->string())) number = quantity->number;
        column.is_text = column.is_text || !number;
        column.numbers.push_back(number.value_or(std::numeric_limits<double>::quiet_NaN()));
        column.texts.push_back(value && value->string() ? *value->string() : choice);
      }
      all.push_back(std::move(column));
    }
    at += parameter.components;
  }
  return all;
}

std::string parameter_text(const ParameterColumn& column, std::span<const double> values) {
  const double value = values[column.component];
  return column.is_text ? column.texts[index_of(value)] : io::number_text(parameter_number(column, values));
}

double parameter_number(const ParameterColumn& column, std::span<const double> values) {
  const double value = values[column.component];
  if (column.is_text) return std::numeric_limits<double>::quiet_NaN();
  return column.numbers.empty() ? value : column.numbers[index_of(value)];
}

}  // namespace momentree::sweep
