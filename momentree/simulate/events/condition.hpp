#pragma once
// Conditions of events: a quantity of the world, a threshold, and the instant at which the quantity crosses it. Each quantity is
// in its own file in quantities/.
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>
#include <momentree/base/units.hpp>
#include <momentree/model/body_force.hpp>
#include <momentree/simulate/events/argument.hpp>
#include <momentree/simulate/events/event.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

class World;

/// A scalar function of the world's state. In files it has the value of its argument, or a table if there are several.
class Quantity : public WithArguments {
 public:
  const char* plain_argument() const override { return "joint"; }
  virtual Dimension dimension() const = 0;
  virtual std::vector<std::string> mechanisms() const { return {}; }
  /// Bodies or mechanisms that can touch, or "ground".
  virtual std::vector<std::string> solids() const { return {}; }
  /// True for quantities of joints with one DoF.
  virtual bool of_single_dof() const { return false; }
  /// True if the quantity cannot be negative, so that a threshold below zero is an error.
  virtual bool never_negative() const { return false; }
  /// True for loads on joints: among several that are exceeded at one instant, the one with the largest ratio to its threshold
  /// comes first.
  virtual bool is_load() const { return false; }
  /// The components of a reaction on which it depends, which closed loops may leave open.
  virtual ReactionParts reaction_parts() const { return 0; }
  /// False for what is true (1) or not (0), and needs no threshold.
  virtual bool has_threshold() const { return true; }
  /// Turns it into what a condition without a threshold means: has_threshold() is false from then on. False if it needs one.
  virtual bool drop_threshold() { return false; }
  /// True for quantities that exist only at instants of change (impulses); they are not located within steps.
  virtual bool is_impulsive() const { return false; }
  /// Of an impulsive quantity: it began at this instant, so that a condition that repeats happens again, whether or not it was
  /// evaluated since the last time.
  virtual bool begins(const World& world, std::span<const Event> now) const { return value(world, now).value_or(0) > 0; }
  /// Empty if its joint, body or mechanism no longer exists. `now`: the events of this instant so far.
  virtual std::optional<double> value(const World& world, std::span<const Event> now) const = 0;
  /// Its exact time derivative, if coordinates and velocities determine it: crossings within a step are then found without
  /// further evaluations.
  virtual std::optional<double> rate(const World&) const { return std::nullopt; }
};

/// A quantity with its threshold. The condition fires at the instant of crossing, located to the run's event_tolerance, or at the
/// start if the threshold is already exceeded then. It fires once, unless it repeats.
class Condition {
 public:
  Condition(std::shared_ptr<const Quantity> what_, double threshold_, bool above_)
      : what(std::move(what_)), threshold(threshold_), above(above_) {
    MT_REQUIRE(what != nullptr, "a condition has a quantity");
  }

  /// Repeats: armed again once the quantity is back past the threshold by `width` (in its unit); negative: by 1 % of the
  /// threshold.
  [[nodiscard]] Condition repeated(double width = -1) && {
    repeats = true, hysteresis = width;
    return std::move(*this);
  }
  double width() const { return hysteresis >= 0 ? hysteresis : 0.01 * (threshold < 0 ? -threshold : threshold); }
  /// Fires only after the condition has held for that long (s) without interruption, even within a step.
  [[nodiscard]] Condition lasting(double seconds) && {
    duration = seconds;
    return std::move(*this);
  }
  /// Evaluated only at the ends of steps: cheaper, and as exact as the step.
  [[nodiscard]] Condition per_step() && {
    exact = false;
    return std::move(*this);
  }

  /// The quantity's value, cached until the world's state changes: not for use by two threads at once. Each simulation has its
  /// own copy.
  std::optional<double> value(const World& world, std::span<const Event> now) const;
  /// Positive while the condition holds; empty if the quantity no longer exists.
  std::optional<double> excess(const World& world, std::span<const Event> now) const;
  /// Time derivative of the excess, if the quantity provides it.
  std::optional<double> rate(const World& world) const {
    const std::optional<double> found = what->rate(world);
    return found ? std::optional(above ? *found : -*found) : std::nullopt;
  }
  /// Load divided by threshold, or threshold divided by load for a condition of falling below it.
  double ratio(double value) const { return above ? value / threshold : threshold / value; }

  std::shared_ptr<const Quantity> what;
  double threshold;
  bool above;
  bool repeats = false, exact = true;
  /// For a reaction that closed loops leave open: the least of all possible ones is meant. Otherwise such a condition is an
  /// error.
  bool least_norm = false;
  double hysteresis = -1, duration = 0;

 private:
  mutable Stamp seen_;
  mutable std::optional<double> last_;
};

/// A quantity without its threshold: `reaction_force("crane/hook").exceeds(4e3)`, or `reaction("crane/hook").force() > 4e3`.
class Measure {
 public:
  explicit Measure(std::shared_ptr<const Quantity> what) : what_(std::move(what)) {
    MT_REQUIRE(what_ != nullptr, "a measure has a quantity");
  }
  [[nodiscard]] Condition exceeds(double threshold) const { return {what_, threshold, true}; }
  [[nodiscard]] Condition below(double threshold) const { return {what_, threshold, false}; }
  /// Its present value, in its SI unit; nothing if its joint, body or mechanism no longer exists, and for impulses. Throws Error
  /// for unknown names.
  [[nodiscard]] std::optional<double> value(const World& world) const { return what_->value(world, {}); }
  [[nodiscard]] friend Condition operator>(const Measure& measure, double threshold) { return measure.exceeds(threshold); }
  [[nodiscard]] friend Condition operator<(const Measure& measure, double threshold) { return measure.below(threshold); }

 private:
  std::shared_ptr<const Quantity> what_;
};

/// Norm of the force (N) or of the torque (N m) that a joint transmits, about the origin of the joint's frame on the child. The
/// force also of a spring: the magnitude of its tension.
Measure reaction_force(std::string joint);
Measure reaction_torque(std::string joint);
/// One component of that wrench, in the child's axes: "fx", "fy", "fz" (N), "mx", "my" or "mz" (N m).
Measure reaction(std::string joint, std::string component);
/// Alternative notation: `reaction("arm/wrist").torque() > 40`, `reaction("arm/wrist").component("mx") < -3`.
class Reaction {
 public:
  explicit Reaction(std::string joint) : joint_(std::move(joint)) {}
  Measure force() const { return reaction_force(joint_); }
  Measure torque() const { return reaction_torque(joint_); }
  Measure component(std::string name) const { return reaction(joint_, std::move(name)); }

 private:
  std::string joint_;
};
inline Reaction reaction(std::string joint) { return Reaction(std::move(joint)); }
/// Norm of the linear impulse (N s) through a joint at an instantaneous change.
Measure reaction_impulse(std::string joint);
/// Coordinate (rad, m) and velocity (rad/s, m/s) of a joint with one DoF.
Measure position_of(std::string joint);
Measure speed_of(std::string joint);
/// Distance (m) between two points of bodies, each in its body's frame; "ground" counts as a body.
Measure distance_between(std::string one, std::string other, Vec3 point_of_one = {}, Vec3 point_of_other = {});
/// Height (m) of a point of a body above the world's origin, against gravity; along z if there is no gravity.
Measure height_of(std::string body, Vec3 point = {});
/// Kinetic energy (J) of the bodies of a mechanism.
Measure kinetic_energy_of(std::string mechanism);
/// Of contacts. Each name is that of a body, or of a mechanism, which stands for all bodies "NAME/…" of the model; or "ground",
/// which is the floor and can be called "floor". Simulation::when throws Error if they can never touch.
/// The least distance (m) of what they touch with.
Measure gap_between(std::string one, std::string other);
/// Norms of the sum of the forces (N) between them, and of the impulses (N s) at an instant at which they hit each other; the
/// largest speed (m/s) with which they slip on each other.
Measure contact_force_between(std::string one, std::string other);
Measure contact_impulse_between(std::string one, std::string other);
Measure slip_between(std::string one, std::string other);
/// Fires when they touch.
Condition touching(std::string one, std::string other);
/// Fires when they begin to slip on each other, at the instant of the event "slip".
Condition beginning_to_slip(std::string one, std::string other);
/// Any function of the world's state, continuous where its crossing is to be located. It may read only the world that is passed
/// to it; exceptions that it throws propagate out of run_until(). Throws Error for an empty function.
Measure measured(std::function<double(const World&)> function);

/// A quantity with that key, its arguments still empty; null if no quantity has that key.
std::shared_ptr<Quantity> make_quantity(std::string_view key);
/// Keys of all quantities.
std::vector<std::string> quantity_keys();

}  // namespace momentree
