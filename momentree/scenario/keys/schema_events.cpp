// Actions and quantities, as their arguments describe them.
#include <momentree/scenario/events/argument_kinds.hpp>
#include <momentree/scenario/keys/schema_parts.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io::schema {

Json Schema::table_of_arguments(WithArguments& what) {
  Json properties = Json::object();
  std::vector<std::string> required;
  what.arguments([&](const Argument& argument) {
    const ArgumentDescription described = kind_of(argument).described(argument);
    for (const Key& key : described.keys) {
      add(key, properties);
      if (key.required != nullptr) required.emplace_back(key.name);
    }
    if (described.parameters) add_parameters(properties);
  });
  return table_of(what.summary(), std::move(properties), required);
}

void Schema::add_actions(Json& properties) {
  for (const std::string& key : scenario_actions()) {
    const std::shared_ptr<ActionBase> action = make_action(key);
    Json definition = table_of_arguments(*action);
    definitions_[key + "_action"] = std::move(definition);
    const Json reference{{"$ref", "#/definitions/" + key + "_action"}};
    const Json one = action->plain_argument() != nullptr ? either(a_name(), reference) : reference;
    properties[key] = either(one, {{"type", "array"}, {"items", one}, {"minItems", 1}});
    properties[key]["description"] = action->summary();
  }
}

void Schema::add_quantities(Json& properties) {
  for (const std::string& key : quantity_keys()) {
    const std::shared_ptr<momentree::Quantity> quantity = make_quantity(key);
    Json value = table_of_arguments(*quantity);
    if (value["properties"].size() == 1) value = *value["properties"].begin();  // without a table
    properties[key] = {{"description", quantity->summary()}};
    for (const auto& [name, part] : value.items())
      if (name != "description") properties[key][name] = part;
  }
}

}  // namespace momentree::io::schema
