#pragma once
// Reads single parts of a scenario from values, with the checks and messages of the scenario reader: for programs that build a
// model or schedule events step by step, such as language bindings.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/model/model.hpp>
#include <momentree/models/import/shape.hpp>
#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/events/condition.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

struct TriggerMatch;

/// A body with the shapes that pictures show, and the solids with which it touches others.
struct BodyPart {
  BodySpec spec;
  Shape shape;
  std::vector<contact::Solid> solids{};
  std::vector<Shape> collision_shapes{};  ///< of which the solids are made
};

/// A condition; if a name in it has a wildcard, that of one match. Actions with the same wildcard then act on this match.
struct TriggerPart {
  std::optional<Condition> condition{};  ///< absent: the trigger is an instant or another event
  std::shared_ptr<const TriggerMatch> match{};
};

/// Every function throws InputError if the value is not valid: the message begins with `what`, such as `Model.add("arm/1")`.
class PartReader {
 public:
  explicit PartReader(std::string what) : what_(std::move(what)) {}

  /// A table with the keys of [[mechanism.body]]. `name`: its complete name, "mechanism/body". The joint's table has no parent;
  /// its name, if any, is the bare one.
  [[nodiscard]] BodyPart body(const std::string& name, const Value& table) const;
  /// A table with the keys of [[force]]; a wildcard in the body's name gives several forces.
  [[nodiscard]] std::vector<BodyForce> forces(const Value& table, const Model& model) const;

  /// The value of `floor` in [world]; adds the plane and its rule.
  void add_floor(const Value& value, Model& model) const;
  /// The value of `collision` in [world]; adds planes and solids of the ground. `shapes`: by collider, as to_toml() takes them.
  void add_ground(const Value& value, Model& model, std::vector<Shape>& shapes) const;
  /// A table with the keys of [[contact]]; adds its rule.
  void add_contact(const Value& table, Model& model) const;

  /// A table with the keys of [[spring]], [[cable]], [[coupling]] or another element, as `kind` says, except its name; adds it.
  /// `name`: empty for elements without a name.
  void add_element(const std::string& kind, const std::string& name, const Value& table, Model& model) const;
  /// A table with the keys of [[loop]], but `name`.
  [[nodiscard]] LoopSpec loop(const std::string& name, const Value& table, const Model& model) const;

  /// An event's table with `when` and the keys that go with it: one part, or one for each match of a wildcard.
  [[nodiscard]] std::vector<TriggerPart> triggers(const Value& event, const World& world) const;
  /// The value of an action's key in an event: a name, a table, or a list of them. Names of bodies are checked here, those of
  /// joints when the action is scheduled.
  [[nodiscard]] std::vector<Action> actions(const std::string& key, const Value& value, const TriggerPart& trigger,
                                            const World& world) const;
  /// A table that names one quantity, as `when` does, without a threshold. `joints`: further names of joints, which events make.
  [[nodiscard]] std::shared_ptr<momentree::Quantity> quantity(const Value& table, const World& world,
                                                              const std::vector<std::string>& joints = {}) const;
  /// A table with the keys of [integrate] except `until`.
  [[nodiscard]] Integration integration(const Value& table) const;

 private:
  std::string what_;
};

/// Actions as an event has them, `{"break": "hip", "lock": ["knee", "ankle"]}`, on what a world has now; names of joints are
/// checked when they are carried out. An error is not thrown: `problem` is the first one, with its remedy.
std::vector<Action> actions_now(const Value& table, const World& world, std::string& problem);

}  // namespace momentree::io
