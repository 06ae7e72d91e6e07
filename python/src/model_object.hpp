#pragma once
// A model as Python builds it.
#include <memory>
#include <vector>

#include <momentree/scenario/part_reader.hpp>
#include <momentree/scenario/scenario.hpp>

#include "binding.hpp"

namespace momentree::python {

struct ModelObject {
  Model model;
  std::vector<io::Shape> shapes;  ///< by body number
  std::string title{};
  std::vector<io::Shape> collision_shapes{};  ///< by collider, as in a scenario
};
using ModelPtr = std::shared_ptr<ModelObject>;

/// A body of a model that is being built.
struct ModelBody {
  ModelPtr model;
  BodyId id;
};

/// A scenario without events for it.
std::shared_ptr<const io::Scenario> scenario_of(const ModelObject& model, const Integration& integration);
/// The parent that a user named: None, "ground", a name or a ModelBody of this model.
BodyId parent_in(const ModelPtr& model, nb::handle parent);
/// Adds a spring, a cable … from the keyword arguments of add_spring(), add_cable() …. springs.cpp
void add_element(ModelObject& model, const std::string& kind, const std::string& name, nb::handle fields);
/// What bodies touch with, for pickling. contacts.cpp
void add_contacts_to(nb::class_<ModelObject>& type);
/// The complete table of a body and its joint from the keyword arguments of add().
io::BodyPart body_part(const std::string& call, const std::string& name, nb::handle fields);

}  // namespace momentree::python
