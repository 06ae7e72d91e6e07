#pragma once
// The actions of events. Each action is in its own file in actions/: its parameters, preconditions and effect.
#include <concepts>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/simulate/events/argument.hpp>

namespace momentree {

class TopologyEditor;

/// The order of actions at one instant: first those that change no velocity, then all impacts together, impulses, parameters.
enum class ActionPhase { release, impact, impulse, parameters };

/// What an action does to the joint that it names. `released`: the joint gains DoFs and keeps its coordinates or the pose;
/// `replaced`: it becomes another joint, as the user describes it; `held`: it loses DoFs.
enum class JointEffect { none, removed, released, replaced, held };

/// Outcome of an action. `skipped`: there was nothing to do, and the event reports why; `refused`: the action is impossible, and
/// nothing of its instant is carried out.
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

/// Base class of actions. Derive each action in its own file in actions/.
class ActionBase : public WithArguments {
 public:
  const char* hint() const override = 0;
  /// False for an action that is only for C++.
  virtual bool in_scenarios() const { return true; }
  /// The joint or bodies that it acts on, for logs: "chain/41", "satellite/hull to tug/gripper".
  virtual std::string target() const = 0;
  /// DoFs of its joint that it locks, unlocks or replaces, one bit each: two actions of one instant must not share any.
  virtual unsigned reshapes() const { return 0; }
  virtual JointEffect effect() const { return JointEffect::none; }
  /// Default name of the joint that it makes, used if its event does not name it; empty: it makes no joint.
  virtual std::string makes() const { return {}; }
  /// The name that the user gave to the joint that it makes; empty: none.
  virtual std::string made_name() const { return {}; }
  /// The kind of the joint that it makes, or that its joint has afterwards; empty: no kind changes.
  virtual std::optional<Kind> resulting_kind() const { return {}; }

  virtual ActionPhase phase(TopologyEditor& editor) const = 0;
  /// Called before all impacts of an instant: releases the old constraints, so that the impacts of several actions are solved as
  /// one.
  virtual ActionResult prepare(TopologyEditor&) const { return ActionResult::done(); }
  virtual ActionResult apply(TopologyEditor& editor) const = 0;
};

/// Why an action does nothing.
inline constexpr const char* joint_is_gone = "the joint no longer exists";

/// An action as a value, made by the functions below or from a class in actions/.
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

/// An action with that key, its arguments still empty; null if no action has that key.
std::shared_ptr<ActionBase> make_action(std::string_view key);
/// Keys of all actions.
std::vector<std::string> action_keys();

/// Removes a joint: the child's subtree becomes a separate mechanism. Of a spring: it exerts no force from then on.
Action break_joint(std::string joint);
inline Action break_spring(std::string spring) { return break_joint(std::move(spring)); }
/// Another length (m) for a cable, or another rest length for a spring. The ends of a cable must not be farther apart.
Action set_length(std::string cable, double length);
/// Replaces the joint by a six-DoF joint relative to the same parent.
Action free_joint(std::string joint);
/// Changes the kind of a joint; its axes stay. Coordinates that the new kind can represent are kept; otherwise the present pose
/// becomes the offset, and q = 0. Joint parameters are not carried over to the new kind.
Action change_joint(std::string joint, Kind kind);
/// Replaces the joint by another: its axes are given in the child's axes at that instant, its origin is the child's origin.
Action change_joint(std::string joint, JointSpec to);
/// Locks a joint where it is (all of its DoFs, or those with these indices): a plastic impact.
Action lock(std::string joint, std::vector<int> dofs = {});
/// Releases a lock.
Action unlock(std::string joint, std::vector<int> dofs = {});
/// Joins a body rigidly to another body or to the ground, in their present poses. The joint that this makes has the name `name`,
/// by which later actions refer to it; if that is empty, the name of the event, or else "<to>+<body>".
Action weld(std::string body, std::string to = "ground", std::string name = {});
/// Joins a body to another body by a joint of any kind. Its frame is `at` in `to`'s frame (by default at the body's origin, with
/// `to`'s axes), and the present pose is its zero. `name`: of the joint, as for weld().
Action attach(std::string body, std::string to, JointSpec joint, std::optional<Pose> at = {}, std::string name = {});
/// An impulsive wrench on a body: force (N s) at `point` (in the body's frame) and torque (N m s), both in world axes.
Action impulse(std::string body, Vec3 force, Vec3 torque = {}, Vec3 point = {});
/// Sets those parameters of a joint that are not empty; of a spring: `stiffness`, `rest`, `damping` and the force of `strength`.
Action set_parameters(std::string joint, JointParameters parameters);
/// Makes a body the root of its free mechanism; this does not affect the motion.
Action reroot(std::string body);

}  // namespace momentree
