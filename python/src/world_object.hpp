#pragma once
// The world, its bodies and joints as Python sees them.
#include "simulation_object.hpp"

namespace momentree::python {

/// The world of a simulation, or the one that is passed to a function for the duration of a call.
struct WorldObject {
  SimulationPtr simulation;
  const World* passed = nullptr;
  bool is_passed = false;
};
using WorldPtr = std::shared_ptr<WorldObject>;

/// Read access to it.
class Reading {
 public:
  explicit Reading(const WorldPtr& world);
  const World& operator*() const { return *world_; }
  const World* operator->() const { return world_; }

 private:
  std::optional<Use> use_;
  const World* world_;
};

/// Handles: bodies and joints keep their numbers; a number belongs to another body only after a body was added, an earlier state
/// was restored, and another one was added. The name tells them apart.
struct BodyObject {
  WorldPtr world;
  BodyId id;
  std::string name;
};
struct JointObject {
  WorldPtr world;
  JointId id;
  std::string body;  ///< that was added with it
};

/// The context of a function that drives a joint or acts on a body; valid during the call.
struct ContextObject {
  SimulationObject* simulation = nullptr;
  const EvaluationContext* context = nullptr;
};

/// The number of a body or joint from its name, or from a handle of this very simulation.
BodyId body_of(const World& world, const SimulationObject& object, nb::handle name);
JointId joint_of(const World& world, const SimulationObject& object, nb::handle name);
/// springs.cpp
void register_spring(nb::module_& m);
void add_springs_to(nb::class_<WorldObject>& type);

/// Names in place of handles, in arguments of actions and conditions.
nb::object name_of(nb::handle handle);

}  // namespace momentree::python
