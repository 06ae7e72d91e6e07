#pragma once
// When something happens: a quantity of the world, a threshold, and the instant at which the one passes the other. Each quantity
// stands in its own file in quantities/.
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
#include <momentree/math/vec.hpp>
#include <momentree/simulate/event.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

class World;

/// Visitor through which file readers fill in the fields of a quantity.
class QuantityFields {
 public:
  virtual ~QuantityFields() = default;
  virtual void joint(std::string& name) = 0;
  virtual void mechanism(std::string& name) = 0;
  /// A point of a body, in its frame; the `number`-th of `count`.
  virtual void point(int number, int count, std::string& body, Vec3& point) = 0;
  virtual void component(std::string& name) = 0;
};

/// A number that the world has at an instant.
class Quantity {
 public:
  virtual ~Quantity() = default;
  /// As in scenario files: "reaction_force".
  virtual std::string_view key() const = 0;
  virtual void fields(QuantityFields& fields) = 0;
  virtual Dimension dimension() const = 0;
  virtual std::vector<std::string> joints() const { return {}; }
  virtual std::vector<std::string> bodies() const { return {}; }
  virtual std::vector<std::string> mechanisms() const { return {}; }
  /// True for what joints with one freedom have.
  virtual bool of_single_dof() const { return false; }
  /// True for what can't pass a threshold below zero.
  virtual bool never_negative() const { return false; }
  /// True for loads on joints: of several at one instant the largest ratio to its threshold comes first.
  virtual bool is_load() const { return false; }
  /// True for what exists at instants only (impulses), and is not looked for between them.
  virtual bool is_impulsive() const { return false; }
  /// Nothing where its joint, body or mechanism is gone. `now`: the events of this instant so far.
  virtual std::optional<double> value(const World& world, std::span<const Event> now) const = 0;
  /// Its exact time derivative, where coordinates and velocities give it: crossings within a step are then found without further
  /// evaluations.
  virtual std::optional<double> rate(const World&) const { return std::nullopt; }
};

/// A quantity with its threshold. Happens at the instant of crossing, located to the run's event_tolerance, also at the start if
/// it is past already; once, unless it repeats.
class Condition {
 public:
  Condition(std::shared_ptr<const Quantity> what_, double threshold_, bool above_)
      : what(std::move(what_)), threshold(threshold_), above(above_) {
    MT_REQUIRE(what != nullptr, "a condition is one on a quantity");
  }

  /// Armed again once it is back past the threshold by that much; negative: by 1 % of it.
  [[nodiscard]] Condition repeated(double width = -1) && {
    repeats = true, hysteresis = width;
    return std::move(*this);
  }
  double width() const { return hysteresis >= 0 ? hysteresis : 0.01 * (threshold < 0 ? -threshold : threshold); }
  /// Only after it has held for that long (s) without a gap, be it within a step.
  [[nodiscard]] Condition lasting(double seconds) && {
    duration = seconds;
    return std::move(*this);
  }
  /// Looked at after each step alone: cheaper, and as exact as the step.
  [[nodiscard]] Condition per_step() && {
    exact = false;
    return std::move(*this);
  }

  /// The quantity's value, remembered as long as the world's state stays what it is: not for two threads at once. Each simulation
  /// has a copy of its own.
  std::optional<double> value(const World& world, std::span<const Event> now) const;
  /// Positive where it holds; nothing where the quantity is gone.
  std::optional<double> excess(const World& world, std::span<const Event> now) const;
  /// Time derivative of the excess, where the quantity gives it.
  std::optional<double> rate(const World& world) const {
    const std::optional<double> found = what->rate(world);
    return found ? std::optional(above ? *found : -*found) : std::nullopt;
  }
  /// Load over threshold, or for what falls below it threshold over load.
  double ratio(double value) const { return above ? value / threshold : threshold / value; }

  std::shared_ptr<const Quantity> what;
  double threshold;
  bool above;
  bool repeats = false, exact = true;
  double hysteresis = -1, duration = 0;

 private:
  mutable Stamp seen_;
  mutable std::optional<double> last_;
};

/// A quantity before it has a threshold: `reaction_force("crane/hook").exceeds(4e3)`, or `reaction("crane/hook").force() > 4e3`.
class Measure {
 public:
  explicit Measure(std::shared_ptr<const Quantity> what) : what_(std::move(what)) {
    MT_REQUIRE(what_ != nullptr, "a measure is one of a quantity");
  }
  [[nodiscard]] Condition exceeds(double threshold) const { return {what_, threshold, true}; }
  [[nodiscard]] Condition below(double threshold) const { return {what_, threshold, false}; }
  [[nodiscard]] friend Condition operator>(const Measure& measure, double threshold) { return measure.exceeds(threshold); }
  [[nodiscard]] friend Condition operator<(const Measure& measure, double threshold) { return measure.below(threshold); }

 private:
  std::shared_ptr<const Quantity> what_;
};

/// Norm of the force (N), of the torque (N m) that a joint transmits, about the child's origin.
Measure reaction_force(std::string joint);
Measure reaction_torque(std::string joint);
/// One component of them, in the child's axes: "fx", "fy", "fz", "mx", "my" or "mz".
Measure reaction(std::string joint, std::string component);
/// The same by the joint: `reaction("arm/wrist").torque() > 40`, `reaction("arm/wrist").component("mx") < -3`.
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
/// Coordinate and speed of a joint with one freedom.
Measure position_of(std::string joint);
Measure speed_of(std::string joint);
/// Between two points of bodies, each in its body's frame (m); "ground" is a body.
Measure distance_between(std::string one, std::string other, Vec3 point_of_one = {}, Vec3 point_of_other = {});
/// Of a point of a body above the world's origin, against gravity (m); along z where there is none.
Measure height_of(std::string body, Vec3 point = {});
/// Of the bodies of a mechanism (J).
Measure kinetic_energy_of(std::string mechanism);
/// Any function of the world's state, continuous where its crossing is to be found. It reads the world that it is given; what it
/// throws leaves run_until(). Throws Error for an empty function.
Measure measured(std::function<double(const World&)> function);

/// A quantity of that key, its fields still empty; null if there is none.
std::shared_ptr<Quantity> make_quantity(std::string_view key);
/// Keys of all quantities.
std::vector<std::string> quantity_keys();

}  // namespace momentree
