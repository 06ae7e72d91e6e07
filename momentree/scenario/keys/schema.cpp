#include <momentree/scenario/keys/schema.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/keys/schema_parts.hpp>

namespace momentree::io::schema {

namespace {

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> words;
  std::istringstream stream{std::string(text)};
  for (std::string word; std::getline(stream, word, separator);) words.push_back(word);
  return words;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// Writes a value, on one line if it fits, else with one line for each of its parts.
std::string text_of(const Json& json, std::size_t indent, bool one_line) {
  if (!json.is_structured()) return json.dump();
  if (!one_line) {
    std::string line = text_of(json, indent, true);
    if (indent + line.size() <= 120) return line;
  }
  const std::string separator = one_line ? ", " : ",\n" + std::string(indent + 1, ' ');
  std::string text;
  for (const auto& [key, value] : json.items()) {
    if (!text.empty()) text += separator;
    if (json.is_object()) text += Json(key).dump() + ": ";
    text += text_of(value, indent + 1, one_line);
  }
  if (!one_line) text = separator.substr(1) + text + '\n' + std::string(indent, ' ');
  return json.is_array() ? '[' + text + ']' : '{' + text + '}';
}

Json rule_of(const KeyRule& rule) {
  const std::vector<std::string> names = split(rule.keys, ' ');
  Json all = Json::array();
  if (rule.how == KeyRule::How::not_two) {
    for (std::size_t i = 0; i < names.size(); ++i)
      for (std::size_t j = i + 1; j < names.size(); ++j) all.push_back({{"required", Json::array({names[i], names[j]})}});
    return {{"not", {{"anyOf", all}}}};
  }
  for (const std::string& name : names) all.push_back({{"required", Json::array({name})}});
  return {{rule.how == KeyRule::How::one ? "oneOf" : "anyOf", all}};
}

}  // namespace

Json list_of(const Json& items, int least, int most) {
  return {{"type", "array"}, {"items", items}, {"minItems", least}, {"maxItems", most}};
}

Json either(Json one, Json other) { return {{"anyOf", {std::move(one), std::move(other)}}}; }

Json table_of(std::string about, Json properties, const std::vector<std::string>& required) {
  Json json{{"description", std::move(about)}, {"type", "object"}, {"properties", std::move(properties)}};
  json["additionalProperties"] = false;
  if (!required.empty()) json["required"] = required;
  return json;
}

void bound(Range range, Json& number) {
  if (range == Range::positive) number["exclusiveMinimum"] = 0;
  if (range != Range::positive && range != Range::any) number["minimum"] = 0;
  if (range == Range::fraction) number["maximum"] = 1;
}

std::string document(const char* title, const KeyTable& keys) { return text_of(Schema().whole(title, keys), 0, false) + '\n'; }

Json Schema::table(const KeyTable& keys) {
  const std::string name = keys.definition;
  if (name.empty()) return in_place(keys);
  if (!definitions_.contains(name)) {
    definitions_[name] = nullptr;  // its place, before those of its parts
    Json made = in_place(keys);
    definitions_[name] = std::move(made);
  }
  return {{"$ref", "#/definitions/" + name}};
}

Json Schema::in_place(const KeyTable& keys) {
  Json properties = Json::object();
  std::vector<std::string> required;
  keys.each([&](const Key& key) {
    add(key, properties);
    if (key.required != nullptr) required.emplace_back(key.name);
  });
  if (keys.parameters) add_parameters(properties);
  if (&keys == &event_table) add_actions(properties);
  if (&keys == &condition_table) add_quantities(properties);
  Json json = table_of(keys.about, std::move(properties), required);
  Json rules = Json::array();
  for (const KeyRule& each : keys.rules)
    if (each.how != KeyRule::How::none) rules.push_back(rule_of(each));
  if (rules.size() == 1) json.update(rules[0]);
  if (rules.size() > 1) json["allOf"] = rules;
  return json;
}

Json Schema::of_type(const Type& type, std::string& about) {
  using Form = Type::Form;
  switch (type.form) {
    case Form::text: return a_name();
    case Form::boolean: return {{"type", "boolean"}};
    case Form::number: {
      const std::string unit = type.unit != nullptr ? type.unit : unit_of(type.dimension);
      if (!unit.empty()) about += ". In " + unit + ", or a string with units";
      Json number = a_number();
      bound(type.range, number);
      return number;
    }
    case Form::vector: {
      const std::string unit = unit_of(type.dimension);
      about += ". Three numbers" + (unit.empty() ? "" : ", in " + unit + ", or strings with units");
      return list_of(a_number(), 3, 3);
    }
    case Form::signals:
      about += ". In " + unit_of(type.dimension) + ": numbers, strings with units or signals";
      return list_of(either(a_number(), signal()), 3, 3);
    case Form::choice: return {{"enum", type.registry != nullptr ? type.registry() : split(type.words, '|')}};
    case Form::table: return table(*type.keys);
    case Form::other: {
      std::string text = type.schema;
      if (type.keys != nullptr) {
        const std::string part = table(*type.keys).dump();
        for (std::size_t at = 0; (at = text.find('@', at)) != std::string::npos; at += part.size()) text.replace(at, 1, part);
      }
      return Json::parse(text);
    }
  }
  return {};
}

void Schema::add(const Key& key, Json& properties) {
  std::string about = key.about;
  if (key.absent != nullptr) about += std::string("; default: ") + key.absent;
  Json value = of_type(key.type, about);
  if (key.of_kinds != nullptr) {
    std::vector<std::string> kinds;
    for (const KindInfo& kind : all_kinds())
      if (kind.*key.of_kinds) kinds.emplace_back(kind.name);
    about += ". For " + joined(kinds) + " joints";
  }
  if (key.type.registry == &method_names) {
    std::vector<std::string> fixed, adaptive;
    for (const std::string& name : integration_methods()) (is_adaptive(name) ? adaptive : fixed).push_back(name);
    about += ". Fixed steps: " + joined(fixed) + "; adaptive steps: " + joined(adaptive);
  }
  Json& property = properties[key.name];
  property = Json::object();
  if (!about.empty()) property["description"] = about;
  if (value.contains("$ref") && !about.empty())
    property["allOf"] = Json::array({value});  // next to a reference, everything else is ignored
  else
    property.update(value);
  if (key.standard != nullptr) property["default"] = Json::parse(key.standard);
}

}  // namespace momentree::io::schema

std::string momentree::io::scenario_schema() { return schema::document("momentree scenario", scenario_table); }
