#include <momentree/scenario/override.hpp>

#include <charconv>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/text/toml_text.hpp>

namespace momentree::io {

namespace {

constexpr std::size_t deepest = 16;

// The parts of a dotted key and the text after the '='; nothing if the argument has another form.
struct Assignment {
  std::vector<std::string> path;
  std::string_view value;
};

std::optional<Assignment> parsed(std::string_view text) {
  Assignment assignment;
  std::string part;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        part += c;
    } else if ((c == '"' || c == '\'') && part.empty()) {
      quote = c;
    } else if (c == '.' || c == '=') {
      if (part.empty()) return {};
      assignment.path.push_back(std::exchange(part, {}));
      if (c == '=') {
        assignment.value = text.substr(i + 1);
        return assignment;
      }
    } else if (c != ' ') {
      part += c;
    } else if (!part.empty() && i + 1 < text.size() && text[i + 1] != ' ' && text[i + 1] != '=' && text[i + 1] != '.') {
      part += c;  // part of a name
    }
  }
  return {};
}

// Digits that are no value of TOML because the number is beyond 64 bits.
bool is_large_number(std::string_view text) {
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) text.remove_prefix(1);
  return text.size() > 18 && text[0] != '0' && text.find_first_not_of("0123456789") == std::string_view::npos;
}

std::string name_in(const Value& table) {
  const Value::Entry* entry = table.find("name");
  return entry && entry->value.string() ? *entry->value.string() : std::string{};
}

// The entry of an array that `part` names; null, with a report, if there is none.
Value* entry_of(Value& array, const std::string& part, Place place, Diagnostics& out) {
  Value::Array& entries = *array.array();
  std::vector<std::string> names;
  for (Value& entry : entries) {
    const std::string name = name_in(entry);
    if (!name.empty() && name == part) return &entry;
    if (!name.empty() && names.size() < 1000) names.push_back(name);
  }
  const bool by_place = part.front() == '#';
  std::size_t number = 0;
  const char* end = part.data() + part.size();
  const auto read = std::from_chars(part.data() + (by_place ? 1 : 0), end, number);
  if (read.ec == std::errc{} && read.ptr == end) {
    if (by_place && number > 0) --number;
    if (number < entries.size()) return &entries[number];
    out.error(place, "there is no entry " + in_quotes(part) + " in a list of " + std::to_string(entries.size()),
              by_place ? "the first is #1" : "the first is 0");
    return nullptr;
  }
  out.error(place, "no entry of the list is named " + in_quotes(part), did_you_mean(part, names));
  return nullptr;
}

void apply(Value& document, const Assignment& assignment, Place place, Diagnostics& out) {
  Value* at = &document;
  for (std::size_t i = 0; i < assignment.path.size(); ++i) {
    const std::string& part = assignment.path[i];
    if (at->array()) {
      at = entry_of(*at, part, place, out);
      if (!at) return;
    } else if (Value::Table* table = at->table()) {
      Value::Entry* entry = at->find(part);
      if (!entry) {
        table->push_back({part, place, Value(Value::Table{}, place)});
        entry = &table->back();
      }
      at = &entry->value;
    } else {
      out.error(place, in_quotes(assignment.path[i - 1]) + " is " + at->type_name() + ": it has no " + in_quotes(part));
      return;
    }
  }
  SyntaxError error;
  if (std::optional<Value> value = parse_toml_value(assignment.value, place, &error))
    *at = std::move(*value);
  else if (is_large_number(assignment.value))
    *at = Value(std::strtod(std::string(assignment.value).c_str(), nullptr), place);
  else if (!assignment.value.empty() && (assignment.value[0] == '[' || assignment.value[0] == '{'))
    out.error(place, error.what.empty() ? "the value can't be read" : error.what, error.hint);
  else  // a string needs no quotes
    *at = Value(std::string(assignment.value), place);
}

}  // namespace

std::vector<std::string> place_of_key(const Value& document, const std::string& key) {
  const std::optional<Assignment> assignment = parsed(key + "=");
  if (!assignment) return {};
  std::vector<std::string> place;
  Diagnostics unheard("", "");
  const Value* at = &document;
  for (const std::string& part : assignment->path) {
    if (at != nullptr && at->array() != nullptr) {
      // Only found, not changed.
      const Value* const entry = entry_of(const_cast<Value&>(*at), part, {}, unheard);  // NOLINT
      if (entry == nullptr) return {};
      place.push_back(std::to_string(entry - at->array()->data()));
      at = entry;
    } else {
      place.push_back(part);
      const Value::Entry* const entry = at != nullptr && at->table() != nullptr ? at->find(part) : nullptr;
      at = entry != nullptr ? &entry->value : nullptr;
    }
  }
  return place;
}

void apply_overrides(Value& document, const std::vector<std::string>& overrides, Diagnostics& out) {
  int option = 0;
  for (const std::string& text : overrides) {
    const Place place{0, 0, ++option};
    const auto assignment = parsed(text);
    if (!check_toml_text(text) && assignment && assignment->path.size() <= deepest)
      apply(document, *assignment, place, out);
    else
      out.error(place, "expected KEY=VALUE", "for example integrate.step=1e-4 or mechanism.tug.pose.xyz=[0,0,1]");
  }
}

}  // namespace momentree::io
