// The kinds of joints, actions and quantities as data, from which tools/python_vocabulary writes the package's functions.
#include <momentree/base/units.hpp>
#include <momentree/model/spring.hpp>
#include <momentree/scenario/keys/keys.hpp>
#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/events/condition.hpp>

#include "binding.hpp"

namespace momentree::python {

namespace {

struct ActionProbe final : ActionFields {
  nb::list fields;
  void add(const char* what, const char* key, const char* about) { fields.append(nb::make_tuple(what, key, about)); }
  void joint(const char* key, std::string&) override { add("joint", key, ""); }
  void made_joint(const char* key, std::string&) override { add("made joint", key, ""); }
  void body(const char* key, std::string&, bool ground_too) override { add(ground_too ? "body or ground" : "body", key, ""); }
  void dofs(const char* key, const std::string&, std::vector<int>&) override { add("dofs", key, ""); }
  void vector(const char* key, Vec3&, const Dimension&, const char* about) override { add("vector", key, about); }
  void placement(const char* key, std::optional<Pose>&, const char* about) override { add("placement", key, about); }
  void description(JointDescription&, bool) override { add("description", "to", ""); }
  void parameters(const std::string&, JointParameters&) override { add("parameters", "parameters", ""); }
};

struct QuantityProbe final : QuantityFields {
  nb::list fields;
  void joint(std::string&) override { fields.append("joint"); }
  void mechanism(std::string&) override { fields.append("mechanism"); }
  void point(int, int count, std::string&, Vec3&) override { fields.append(count == 1 ? "point" : "points"); }
  void component(std::string&) override { fields.append("component"); }
  void solid(int, std::string&) override { fields.append("solid"); }
};

}  // namespace

void register_vocabulary(nb::module_& m) {
  m.def("_vocabulary", [] {
    nb::list kinds, actions, quantities, parameters;
    for (const KindInfo& kind : all_kinds())
      kinds.append(nb::make_tuple(kind.name, kind.q_units, kind.v_units, kind.axis, kind.axis2, kind.pitch));
    for (const std::string& key : action_keys()) {
      const auto action = make_action(key);
      ActionProbe probe;
      action->fields(probe);
      actions.append(nb::make_tuple(key, action->summary(), action->plain_field() != nullptr, probe.fields));
    }
    for (const std::string& key : quantity_keys()) {
      const auto quantity = make_quantity(key);
      QuantityProbe probe;
      quantity->fields(probe);
      const bool threshold = quantity->has_threshold();
      quantities.append(
          nb::make_tuple(key, quantity->summary(), probe.fields, threshold, threshold && quantity->drop_threshold()));
    }
    for (const io::JointKey& key : io::joint_keys())
      if (!key.documents) parameters.append(nb::make_tuple(key.key, key.about));
    nb::list elements;
    for (const io::ElementTable& element : io::element_tables()) {
      nb::list fields;
      element.keys->each([&](const io::Key& key) {
        const char* const what = key.type.form == io::Type::Form::boolean  ? "flag"
                                 : key.type.form == io::Type::Form::number ? "number"
                                 : key.type.form == io::Type::Form::text
                                     ? (key.name == std::string_view("name") ? "name" : "joint")
                                 : key.type.keys != nullptr ? "end"
                                                            : "numbers";
        fields.append(nb::make_tuple(key.name, what, key.about,
                                     key.type.unit != nullptr ? key.type.unit : unit_of(key.type.dimension),
                                     key.required != nullptr, key.absent != nullptr ? key.absent : ""));
      });
      elements.append(nb::make_tuple(element.keys->definition, element.keys->about, element.keys->details, fields));
    }
    nb::list members;
    const auto add = [&](const char* key, const auto& member, const Field&) {
      members.append(nb::make_tuple(key, Like<std::decay_t<decltype(member)>, bool> ? "bool" : "float"));
    };
    const SpringLaw law;
    describe(add, law);
    nb::dict all;
    all["elements"] = elements, all["spring"] = members;
    all["kinds"] = kinds, all["actions"] = actions, all["quantities"] = quantities, all["parameters"] = parameters;
    return all;
  });
}

}  // namespace momentree::python
