#include <momentree/io/schema.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <momentree/io/joint_keys.hpp>
#include <momentree/io/read_action.hpp>

namespace momentree::io {

namespace {

using Json = nlohmann::ordered_json;

const Json a_number{{"type", {"number", "string"}}};  // or a number with a unit
const Json a_name{{"type", "string"}};

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

// "m/s^2"; empty for a number without a unit.
std::string unit_of(const Dimension& dimension) {
  const std::string name = name_of(dimension);
  const std::size_t open = name.find('(');
  return open == std::string::npos ? "" : name.substr(open + 1, name.find(')') - open - 1);
}

Json list_of(const Json& items, int least, int most) {
  return {{"type", "array"}, {"items", items}, {"minItems", least}, {"maxItems", most}};
}

Json either(Json one, Json other) { return {{"anyOf", {std::move(one), std::move(other)}}}; }

// The schema of a table without the rules that `table` adds.
Json table_of(std::string about, Json properties, const std::vector<std::string>& required) {
  Json json{{"description", std::move(about)}, {"type", "object"}, {"properties", std::move(properties)}};
  json["additionalProperties"] = false;
  if (!required.empty()) json["required"] = required;
  return json;
}

// Bounds for numbers; they do not apply to strings.
void bound(Range range, Json& number) {
  if (range == Range::positive) number["exclusiveMinimum"] = 0;
  if (range != Range::positive && range != Range::any) number["minimum"] = 0;
  if (range == Range::fraction) number["maximum"] = 1;
}

class Schema {
 public:
  Json whole() {
    Json all{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "momentree scenario"}};
    all.update(in_place(scenario_table));
    all["definitions"] = definitions_;
    return all;
  }

  /// A table, or a reference to its definition.
  Json table(const KeyTable& keys);
  /// Add a key, or the parameters of a joint, to the properties of a table.
  void add(const Key& key, Json& properties);
  void add_parameters(Json& properties) { add(joint_keys(), properties); }
  Json point() { return either(a_name, table(point_table)); }

 private:
  Json in_place(const KeyTable& keys);
  static Json rule(const KeyRule& rule);
  void add_actions(Json& properties);
  void add_quantities(Json& properties);
  Json of_type(const Type& type, std::string& about);
  void add(std::span<const JointKey> keys, Json& properties);
  Json group(const JointGroup& group, const std::string& about);
  Json signal();
  void add_numbers(std::span<const SignalKey> keys, bool defaults, Json& properties);

  Json definitions_ = Json::object();
};

// The fields of an action, as properties of its table.
class FieldsOfAction final : public ActionFields {
 public:
  explicit FieldsOfAction(Schema& schema) : schema_(schema) {}

  void joint(const char* key, std::string&) override { name(key, "Full name of a joint; * matches within a name", true); }
  void body(const char* key, std::string&, bool ground_too) override {
    name(key, ground_too ? "Full name of a body, or \"ground\", the default" : "Full name of a body", !ground_too);
  }
  void dofs(const char* key, const std::string&, std::vector<int>&) override {
    const Json number{{"type", "integer"}, {"minimum", 0}, {"maximum", 5}};
    properties[key] = {{"description", "DoFs, numbered from 0 in the order of v; default: all of them"}};
    properties[key].update(Json{{"type", "array"}, {"items", number}, {"minItems", 1}});
  }
  void vector(const char* key, Vec3&, const Dimension& dimension, const char* about) override {
    schema_.add({key, type::vector(dimension), about, "[0, 0, 0]"}, properties);
  }
  void placement(const char* key, std::optional<Pose>&, const char* about) override {
    schema_.add({key, type::table(placement_table), about}, properties);
  }
  void description(JointDescription&, bool) override {
    for (const Key& key : joint_geometry) {
      schema_.add(key, properties);
      if (key.required != nullptr) required.emplace_back(key.name);
    }
    schema_.add_parameters(properties);
  }
  void parameters(const std::string&, JointParameters&) override { schema_.add_parameters(properties); }

  Json properties = Json::object();
  std::vector<std::string> required;

 private:
  void name(const char* key, const char* about, bool needed) {
    properties[key] = {{"description", about}, {"type", "string"}};
    if (needed) required.emplace_back(key);
  }
  Schema& schema_;
};

// The value of a quantity in `when`.
class FieldsOfQuantity final : public QuantityFields {
 public:
  explicit FieldsOfQuantity(Schema& schema) : schema_(schema) {}

  void joint(std::string&) override { value = {{"type", "string"}}; }
  void mechanism(std::string&) override { value = {{"type", "string"}}; }
  void point(int number, int count, std::string&, Vec3&) override {
    if (number == 0) value = count == 1 ? schema_.point() : list_of(schema_.point(), count, count);
  }
  void component(std::string&) override {
    const Json joint{{"description", "Full name of a joint; * matches within a name"}, {"type", "string"}};
    const Json component{{"description", "Component"}, {"enum", {"fx", "fy", "fz", "mx", "my", "mz"}}};
    value = table_of("", {{"joint", joint}, {"component", component}}, {"joint", "component"});
    value.erase("description");
  }

  Json value;

 private:
  Schema& schema_;
};

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
    if (each.how != KeyRule::How::none) rules.push_back(rule(each));
  if (rules.size() == 1) json.update(rules[0]);
  if (rules.size() > 1) json["allOf"] = rules;
  return json;
}

Json Schema::rule(const KeyRule& rule) {
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

Json Schema::of_type(const Type& type, std::string& about) {
  using Form = Type::Form;
  switch (type.form) {
    case Form::text: return a_name;
    case Form::boolean: return {{"type", "boolean"}};
    case Form::number: {
      const std::string unit = type.unit != nullptr ? type.unit : unit_of(type.dimension);
      if (!unit.empty()) about += ". In " + unit + ", or a string with units";
      Json number = a_number;
      bound(type.range, number);
      return number;
    }
    case Form::vector: {
      const std::string unit = unit_of(type.dimension);
      about += ". Three numbers" + (unit.empty() ? "" : ", in " + unit + ", or strings with units");
      return list_of(a_number, 3, 3);
    }
    case Form::signals:
      about += ". In " + unit_of(type.dimension) + ": numbers, strings with units or signals";
      return list_of(either(a_number, signal()), 3, 3);
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
  Json value = of_type(key.type, about);
  if (key.of_kinds != nullptr) {
    std::vector<std::string> kinds;
    for (const KindInfo& kind : all_kinds())
      if (kind.*key.of_kinds) kinds.emplace_back(kind.name);
    about += ". For " + joined(kinds) + " joints";
  }
  if (key.type.registry == &integration_methods) {
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

// ". In N m s/rad (N s/m along an axis), or a string with units"
std::string in_unit(Quantity quantity) {
  const std::string turning = unit_of(dimension_of(quantity, 'r')), sliding = unit_of(dimension_of(quantity, 'm'));
  if (turning.empty()) return "";
  return ". In " + turning + (sliding == turning ? "" : " (" + sliding + " along an axis)") + ", or a string with units";
}

void Schema::add(std::span<const JointKey> keys, Json& properties) {
  for (const JointKey& key : keys) {
    if (key.documents) continue;
    Json& property = properties[key.key];
    if (const JointGroup* table = key.group()) {
      // a reference is for all tables with these keys, which are defined on first use
      if (!definitions_.contains(key.key)) {
        definitions_[key.key] = nullptr;
        Json made = group(*table, key.about);
        definitions_[key.key] = std::move(made);
      }
      property = {{"$ref", std::string("#/definitions/") + key.key}};
      continue;
    }
    std::string about = key.about + in_unit(key.quantity);
    Json one = a_number;
    bound(key.range, one);
    const int most = static_cast<int>(Values::capacity);
    if (std::holds_alternative<JointKey::Signals>(key.value)) {
      one = either(a_number, signal());
      about += key.one_dof ? ". A number or a signal" : ". A number or a signal, or a list with one for each DoF";
    } else if (std::holds_alternative<JointKey::PerDof>(key.value)) {
      about += key.each ? ". A list in the order of q; a number for one DoF" : ". One number for all DoFs, or a list";
    }
    property = {{"description", about}};
    const bool single = key.one_dof || std::holds_alternative<JointKey::Number>(key.value);
    property.update(single ? one : either(one, list_of(one, 1, most)));
    JointSettings standard;
    if (const auto* number = std::get_if<JointKey::Number>(&key.value); number != nullptr && std::isfinite((*number)(standard)))
      property["default"] = (*number)(standard);
  }
}

Json Schema::group(const JointGroup& group, const std::string& about) {
  Json properties = Json::object();
  std::vector<std::string> required;
  add(group.keys, properties);
  for (const JointKey& key : group.keys)
    if (key.required != nullptr) required.emplace_back(key.key);
  Json json = table_of(about, std::move(properties), required);
  if (group.either[0] != nullptr)
    json["anyOf"] = {{{"required", Json::array({group.either[0]})}}, {{"required", Json::array({group.either[1]})}}};
  else if (required.empty())
    json["minProperties"] = 1;
  return json;
}

void Schema::add_numbers(std::span<const SignalKey> keys, bool defaults, Json& properties) {
  for (const SignalKey& key : keys) {
    using Unit = SignalKey::Unit;
    const std::string unit = key.unit == Unit::value            ? "the unit of the value"
                             : key.unit == Unit::value_per_time ? "the unit of the value per second"
                                                                : unit_of(key.dimension({}));
    properties[key.key] = {{"description", std::string(key.about) + ". In " + unit + ", or a string with units"}};
    properties[key.key].update(a_number);
    bound(key.range, properties[key.key]);
    if (defaults && key.required == nullptr) properties[key.key]["default"] = SignalParts().*key.number;
  }
}

Json Schema::signal() {
  if (!definitions_.contains("signal")) {
    definitions_["signal"] = nullptr;
    Json properties = Json::object(), sine = Json::object();
    properties["table"] = {
        {"description",
         "Entries [time in s, value] with increasing times: linear interpolation, or for a motion a smooth curve"}};
    properties["table"].update(Json{{"type", "array"}, {"items", list_of(a_number, 2, 2)}, {"minItems", 1}});
    properties["ends"] = {{"description",
                           "For the table of a motion: at rest at both ends, or at a constant rate before the first entry and "
                           "after the last one"},
                          {"enum", {"rest", "free"}},
                          {"default", "rest"}};
    std::vector<std::string> required;
    add_numbers(sine_keys(), true, sine);
    for (const SignalKey& key : sine_keys())
      if (key.required != nullptr) required.emplace_back(key.key);
    properties["sine"] = table_of("offset + amplitude·sin(2π·frequency·t + phase)", std::move(sine), required);
    add_numbers(ramp_keys(), false, properties);
    Json json = table_of("A value that changes with time", std::move(properties), {});
    json["oneOf"] = Json::array();
    for (const char* form : {"table", "sine", "rate"}) json["oneOf"].push_back({{"required", Json::array({form})}});
    definitions_["signal"] = std::move(json);
  }
  return {{"$ref", "#/definitions/signal"}};
}

void Schema::add_actions(Json& properties) {
  for (const std::string& key : scenario_actions()) {
    const std::shared_ptr<ActionBase> action = make_action(key);
    FieldsOfAction fields(*this);
    action->fields(fields);
    Json& definition = definitions_[key + "_action"];
    definition = table_of(action->summary(), std::move(fields.properties), fields.required);
    const Json reference{{"$ref", "#/definitions/" + key + "_action"}};
    const Json one = action->plain_field() != nullptr ? either(a_name, reference) : reference;
    properties[key] = either(one, {{"type", "array"}, {"items", one}, {"minItems", 1}});
    properties[key]["description"] = action->summary();
  }
}

void Schema::add_quantities(Json& properties) {
  for (const std::string& key : quantity_keys()) {
    const std::shared_ptr<momentree::Quantity> quantity = make_quantity(key);
    FieldsOfQuantity fields(*this);
    quantity->fields(fields);
    properties[key] = {{"description", quantity->summary()}};
    properties[key].update(fields.value);
  }
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

}  // namespace

std::string scenario_schema() { return text_of(Schema().whole(), 0, false) + '\n'; }

}  // namespace momentree::io
