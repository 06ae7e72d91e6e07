#pragma once
// What an event does. Each action stands in its own file in actions/: its parameters, preconditions and effect.
#include <concepts>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/units.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/math/vec.hpp>

namespace momentree {

class TopologyEditor;

/// The order of what happens at one instant: first what changes no velocity, then all impacts together, impulses, parameters.
enum class ActionPhase { release, impact, impulse, parameters };

/// What became of an action. `skipped`: it had nothing to do, which is reported; `refused`: it is impossible, and nothing of its
/// instant happens.
struct ActionResult {
  enum class Outcome { done, skipped, refused };
  Outcome outcome = Outcome::done;
  std::string why, hint;

  static ActionResult done() { return {}; }
  static ActionResult skipped(std::string why) { return {Outcome::skipped, std::move(why), ""}; }
  static ActionResult refused(std::string why, std::string hint = "") {
    return {Outcome::refused, std::move(why), std::move(hint)};
  }
};

/// A joint that an action makes, as its user describes it.
struct JointDescription {
  JointSpec spec;
  bool axis_given = false, axis2_given = false;
};

/// Visitor through which file readers fill in the fields of an action, under their names in files.
class ActionFields {
 public:
  virtual ~ActionFields() = default;
  virtual void joint(const char* key, std::string& name) = 0;
  /// `ground_too`: "ground" is one of the names.
  virtual void body(const char* key, std::string& name, bool ground_too) = 0;
  /// Numbers of freedoms of the joint `of`, in the order of v; none: all.
  virtual void dofs(const char* key, const std::string& of, std::vector<int>& numbers) = 0;
  virtual void vector(const char* key, Vec3& value, const Dimension& dimension) = 0;
  virtual void placement(const char* key, std::optional<Pose>& value) = 0;
  /// kind, axis, axis2, pitch and the parameters of a joint.
  virtual void description(JointDescription& joint) = 0;
  /// Parameters for the joint `of`: those that are given.
  virtual void parameters(const std::string& of, JointParameters& parameters) = 0;
};

/// One action. Derive in a file of its own in actions/.
class ActionBase {
 public:
  virtual ~ActionBase() = default;
  /// As in scenario files: "break".
  virtual std::string_view key() const = 0;
  /// What it acts on, for logs: "chain/41", "satellite/hull to tug/gripper".
  virtual std::string target() const = 0;
  /// The field that a plain name in place of a table gives; null where there must be a table.
  virtual const char* plain_field() const { return nullptr; }
  virtual void fields(ActionFields& fields) = 0;
  /// Names that it looks for: joints and bodies ("ground" is none).
  virtual std::vector<std::string> joints() const { return {}; }
  virtual std::vector<std::string> bodies() const { return {}; }
  /// Freedoms of its joint whose fate it decides, a bit each: two actions of one instant must not decide the same.
  virtual unsigned reshapes() const { return 0; }
  /// The name that the joint which it makes has where its event gives none; empty: it makes none.
  virtual std::string makes() const { return {}; }

  virtual ActionPhase phase(TopologyEditor& editor) const = 0;
  /// Before all impacts of an instant: what it lets go of, so that the impacts of several actions are one.
  virtual ActionResult prepare(TopologyEditor&) const { return ActionResult::done(); }
  virtual ActionResult apply(TopologyEditor& editor) const = 0;
};

/// An action as a value. Made by the functions below or from a class in actions/.
class Action {
 public:
  template <std::derived_from<ActionBase> A>
  Action(A action) : what_(std::make_shared<const A>(std::move(action))) {}  // NOLINT(google-explicit-constructor)
  explicit Action(std::shared_ptr<const ActionBase> what) : what_(std::move(what)) {
    MT_REQUIRE(what_ != nullptr, "an action does something");
  }

  const ActionBase& operator*() const { return *what_; }
  const ActionBase* operator->() const { return what_.get(); }
  /// For logs: "break chain/41".
  std::string text() const { return std::string(what_->key()) + " " + what_->target(); }

 private:
  std::shared_ptr<const ActionBase> what_;
};

/// An action of that key, its fields still empty; null if there is none.
std::shared_ptr<ActionBase> make_action(std::string_view key);
/// Keys of all actions.
std::vector<std::string> action_keys();

/// Removes a joint: the child's subtree becomes a mechanism of its own.
Action break_joint(std::string joint);
/// The joint becomes one with six freedoms, relative to the same parent.
Action free_joint(std::string joint);
/// The joint becomes one of another kind on the axes that it has. Coordinates that the new kind can represent are kept; else the
/// present pose becomes the offset, and q = 0. A change of kind takes no parameters along.
Action change_joint(std::string joint, Kind kind);
/// The joint becomes another: axes in the child's axes at that instant, about the child's origin.
Action change_joint(std::string joint, JointSpec to);
/// Freezes a joint where it is (all of its freedoms, or those of these numbers), with the impulse that it takes.
Action lock(std::string joint, std::vector<int> dofs = {});
/// Lets it move again.
Action unlock(std::string joint, std::vector<int> dofs = {});
/// Joins a body to another, or to the ground, rigidly where they are.
Action weld(std::string body, std::string to = "ground");
/// The same with a joint of any kind: its frame at `at` in `to`'s frame (absent: at body's origin, `to`'s axes), the present pose
/// its zero.
Action attach(std::string body, std::string to, JointSpec joint, std::optional<Pose> at = {});
/// An impulsive wrench on a body: N s at `point` (in the body's frame) and N m s, world axes.
Action impulse(std::string body, Vec3 force, Vec3 torque = {}, Vec3 point = {});
/// Gives a joint the parameters that are not empty.
Action set_parameters(std::string joint, JointParameters parameters);
/// Makes a body the root of its free mechanism: nothing moves otherwise for it.
Action reroot(std::string body);

}  // namespace momentree
