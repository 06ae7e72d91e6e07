// The parameters of joints, and signals.
#include <cmath>

#include <momentree/scenario/keys/schema_parts.hpp>

namespace momentree::io::schema {

namespace {

// ". In N m s/rad (N s/m along an axis), or a string with units"
std::string in_unit(Quantity quantity) {
  const std::string turning = unit_of(dimension_of(quantity, 'r')), sliding = unit_of(dimension_of(quantity, 'm'));
  if (turning.empty()) return "";
  return ". In " + turning + (sliding == turning ? "" : " (" + sliding + " along an axis)") + ", or a string with units";
}

}  // namespace

void Schema::add(std::span<const JointKey> keys, Json& properties) {
  for (const JointKey& key : keys) {
    if (key.documents) continue;
    Json& property = properties[key.key];
    if (const auto* table = std::get_if<JointGroup>(&key.value)) {
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
    Json one = a_number();
    bound(key.range, one);
    const int most = static_cast<int>(Values::capacity);
    if (std::holds_alternative<JointKey::Signals>(key.value)) {
      one = either(a_number(), signal());
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
    properties[key.key].update(a_number());
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
    properties["table"].update(Json{{"type", "array"}, {"items", list_of(a_number(), 2, 2)}, {"minItems", 1}});
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

}  // namespace momentree::io::schema
