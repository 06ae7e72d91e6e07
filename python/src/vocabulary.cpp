// The kinds of joints, actions and quantities as data, from which tools/python_vocabulary writes the package's functions.
#include <momentree/base/units.hpp>
#include <momentree/model/spring.hpp>
#include <momentree/scenario/events/argument_kinds.hpp>
#include <momentree/scenario/keys/keys.hpp>
#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/events/condition.hpp>

#include "binding.hpp"

namespace momentree::python {

namespace {

// Key, value in Python and parameters of each argument.
nb::list arguments_of(WithArguments& what) {
  nb::list all;
  what.arguments([&all](const Argument& argument) {
    const io::ArgumentDescription described = io::kind_of(argument).described(argument);
    nb::list parameters;
    for (const auto& [name, type, about, by_keyword] : described.python)
      parameters.append(nb::make_tuple(name, type, about, by_keyword));
    all.append(nb::make_tuple(argument.key, described.in_python, parameters));
  });
  return all;
}

}  // namespace

void register_vocabulary(nb::module_& m) {
  m.def("_vocabulary", [] {
    nb::list kinds, actions, quantities, parameters;
    for (const KindInfo& kind : all_kinds())
      kinds.append(nb::make_tuple(kind.name, kind.q_units, kind.v_units, kind.axis, kind.axis2, kind.pitch));
    for (const std::string& key : action_keys()) {
      const auto action = make_action(key);
      actions.append(nb::make_tuple(key, action->summary(), arguments_of(*action)));
    }
    for (const std::string& key : quantity_keys()) {
      const auto quantity = make_quantity(key);
      const nb::list arguments = arguments_of(*quantity);
      const bool threshold = quantity->has_threshold();
      quantities.append(nb::make_tuple(key, quantity->summary(), arguments, threshold, threshold && quantity->drop_threshold()));
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
