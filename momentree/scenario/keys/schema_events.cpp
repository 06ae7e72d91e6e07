// Actions and quantities, as their own visitors describe them.
#include <momentree/scenario/events/read_action.hpp>
#include <momentree/scenario/keys/schema_parts.hpp>

namespace momentree::io::schema {

namespace {

// The fields of an action, as properties of its table.
class FieldsOfAction final : public ActionFields {
 public:
  explicit FieldsOfAction(Schema& schema) : schema_(schema) {}

  void joint(const char* key, std::string&) override { name(key, "Full name of a joint; * matches within a name", true); }
  void made_joint(const char* key, std::string&) override {
    name(key, "Full name of the joint that this makes; default: that of the event, or else \"<to>+<body>\"", false);
  }
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
  void solid(int number, std::string&) override {
    const char* const about =
        "Name of a mechanism, which stands for any of its bodies, full name of a body, \"ground\" or \"floor\"; * matches within "
        "the name of a body";
    if (number == 0) value = list_of({{"description", about}, {"type", "string"}}, 2, 2);
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

}  // namespace

void Schema::add_actions(Json& properties) {
  for (const std::string& key : scenario_actions()) {
    const std::shared_ptr<ActionBase> action = make_action(key);
    FieldsOfAction fields(*this);
    action->fields(fields);
    Json& definition = definitions_[key + "_action"];
    definition = table_of(action->summary(), std::move(fields.properties), fields.required);
    const Json reference{{"$ref", "#/definitions/" + key + "_action"}};
    const Json one = action->plain_field() != nullptr ? either(a_name(), reference) : reference;
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

}  // namespace momentree::io::schema
