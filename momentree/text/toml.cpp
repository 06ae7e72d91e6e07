#include <momentree/text/toml.hpp>

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

#include <momentree/text/toml_text.hpp>

// Header in this translation unit only, without exceptions (the browser build has none), and only the parser.
#define TOML_EXCEPTIONS 0
#define TOML_ENABLE_FORMATTERS 0
#define TOML_ENABLE_WINDOWS_COMPAT 0
#define TOML_MAX_NESTED_VALUES 32
#include <toml++/toml.h>

namespace momentree::io {

namespace {

Place place_of(const toml::source_region& region) {
  return {static_cast<int>(region.begin.line), static_cast<int>(region.begin.column), 0};
}

// Depth is bounded by toml_text and TOML_MAX_NESTED_VALUES.
Value converted(const toml::node& node, const Place* fixed) {
  const Place place = fixed ? *fixed : place_of(node.source());
  switch (node.type()) {
    case toml::node_type::boolean: return {node.as_boolean()->get(), place};
    case toml::node_type::integer: return {std::int64_t{node.as_integer()->get()}, place};
    case toml::node_type::floating_point: return {node.as_floating_point()->get(), place};
    case toml::node_type::string: return {unshielded(node.as_string()->get()), place};
    case toml::node_type::array: {
      Value::Array entries;
      entries.reserve(node.as_array()->size());
      for (const toml::node& entry : *node.as_array()) entries.push_back(converted(entry, fixed));
      return {std::move(entries), place};
    }
    case toml::node_type::table: {
      Value::Table entries;
      entries.reserve(node.as_table()->size());
      for (const auto& [key, value] : *node.as_table())
        entries.push_back({unshielded(key.str()), fixed ? *fixed : place_of(key.source()), converted(value, fixed)});
      // The parser sorts them by name.
      const auto position = [](const Value::Entry& e) { return std::tuple(e.place.line, e.place.column); };
      std::stable_sort(entries.begin(), entries.end(), [&](const auto& a, const auto& b) { return position(a) < position(b); });
      return {std::move(entries), place};
    }
    default: return {Value::Time{}, place};
  }
}

SyntaxError syntax_error(const toml::parse_error& error, std::string_view text) {
  std::string what = unshielded(error.description());
  constexpr std::string_view opening = "Error while parsing ";
  if (what.rfind(opening, 0) == 0) what = "cannot read this " + what.substr(opening.size());
  const Place place = place_of(error.source());
  std::string hint = explain_syntax(what, line_of(text, place.line), place.column);
  return {place, std::move(what), std::move(hint)};
}

}  // namespace

std::optional<Value> parse_toml(std::string_view text, SyntaxError& error) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  if (auto problem = check_toml_text(text)) {
    error = std::move(*problem);
    return {};
  }
  const toml::parse_result result = toml::parse(escape_unsupported(text));
  if (!result) {
    error = syntax_error(result.error(), text);
    return {};
  }
  return converted(result.table(), nullptr);
}

std::optional<Value> parse_toml_value(std::string_view text, Place place, SyntaxError* error) {
  const std::string line = "value = " + std::string(text);
  if (text.find('\n') != std::string_view::npos || check_toml_text(line)) return {};
  const toml::parse_result result = toml::parse(escape_unsupported(line));
  if (!result && error != nullptr) *error = syntax_error(result.error(), line);
  if (!result || result.table().size() != 1) return {};
  const toml::node* value = result.table().get("value");
  if (!value) return {};
  return converted(*value, &place);
}

}  // namespace momentree::io
