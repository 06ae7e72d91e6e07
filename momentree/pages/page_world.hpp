#pragma once
// What the pages of web/ show of a running world: its topology as JSON, and arrays of numbers. The browser's module and the live
// view use it; wasm/engine.h documents the arrays.
#include <optional>
#include <string>
#include <vector>

#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

inline constexpr int motion_size = 13, joint_size = 29, totals_size = 17;  ///< numbers per body, per joint, of the totals

/// The row of a joint in joint_rows(), which it keeps for as long as it exists.
int row_of(const World& world, JointId joint);
int joint_row_count(const World& world);

/// {"mechanisms": […], "joints": […], …}: see mt_topology in wasm/engine.h.
std::string topology_json(const World& world);
/// The members of "scenario" that a page needs, as an object: title, until, every, step, method, gravity, floor (whether
/// put_on_floor changed the scenario) and events.
std::string scenario_json(const Scenario& scenario, const Vec3& gravity, bool floor = false);

/// The lines of events.jsonl of events from number `first` on, separated by commas.
std::string event_list(const std::vector<Event>& events, std::size_t first);

/// Per body its pose and velocities; NaN for a removed body.
void fill_motions(const World& world, std::vector<double>& all);

/// A load at which a joint breaks, in addition to its own strength: the threshold of an event's condition.
struct Threshold {
  int joint;
  Condition condition;
};
std::vector<Threshold> thresholds_of(const Scenario& scenario, const World& world);
/// Per joint its state and, if `reactions`, its reaction and load.
void fill_joints(const Simulation& simulation, const std::vector<Threshold>& thresholds, bool reactions,
                 std::vector<double>& all);
void fill_totals(const Simulation& simulation, double* all);

/// The spring between the pointer and a grabbed body.
struct Grip {
  int body = -1;
  Vec3 point{};   ///< in the body's frame (m)
  Vec3 target{};  ///< in the world (m)
  double stiffness = 0, damping = 0;
};
/// A spring and a damper that can carry the body's mechanism, scaled by `strength`.
Grip grip_on(const World& world, int body, Vec3 point, double strength);
/// The force of a grip on its body.
Wrench pull(const Grip& grip, const EvaluationContext& context);

/// Sets each joint's damping to that of `model` times `factor`, plus `offset` (N m s) for joints that can rotate.
std::vector<Action> scaled_damping(const World& world, const Model& model, double factor, double offset);

/// Sets the force at which each joint breaks (N) to the smaller one of `force` and that of `model`.
std::vector<Action> limited_strength(const World& world, const Model& model, double force);

/// The name of a joint that exists, or of a body that was not removed, by number; −1 is the ground if `ground_too`.
std::optional<std::string> joint_name(const World& world, int joint);
std::optional<std::string> body_name(const World& world, int body, bool ground_too = false);

}  // namespace momentree::io
