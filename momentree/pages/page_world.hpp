#pragma once
// What the pages of web/ show of a running world: its topology as JSON, and arrays of numbers (SI units, world axes).
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// Numbers per body: position and quaternion (w, x, y, z) of its frame, velocity of the origin, angular velocity; NaN for a
/// removed body.
inline constexpr int motion_size = 13;
/// Numbers per joint: nq, nv, q (7), v (6), p (6), the reaction on the declared child about the joint's frame there, in the
/// child's axes (force and torque, 6), the load: the largest ratio of a reaction to the value at which the joint breaks (its
/// strength, or an event's threshold), NaN if there is none; 0 if closed loops leave the reaction open (it is then the least of
/// those possible), else 1. nq is -1 where there is no joint (any more); p of a joint that closes a loop is zero. First the
/// joints of the tree in the order of their numbers, then those that close loops.
inline constexpr int joint_size = 29;
/// Time; kinetic, potential; linear momentum (3), angular momentum about the origin (3); the energy balance: initial, final,
/// dissipated, work, lost in impacts, released, error, and the energy that keeping loops closed brought in.
inline constexpr int totals_size = 17;
/// Numbers per contact: both bodies (-1: the ground, only the second), point (3), normal from the second to the first body (3),
/// force on the first body (3), velocity of slip (3), and 1 if it slips.
inline constexpr int contact_size = 15;

/// The row of a joint in fill_joints(), which it keeps for as long as it exists.
int row_of(const World& world, JointId joint);
int joint_row_count(const World& world);

/// {"mechanisms": [{"name", "root", "grounded", "bodies": […]}], "joints": [{"number", "row", "name", "kind", "parent", "child",
/// "locked": bits, "at", "child_at", "axis", "damping", "stiffness", "force", "torque", "loop"}]}: bodies by number, -1: the
/// ground; "force" and "torque": the joint's strength, null: unlimited; "loop": true for a joint that closes a loop, absent for
/// others. "broken_springs": names, absent if the model has no springs; "couplings": [{"joint", "follows", "ended"}], the exact
/// couplings of joints by name, absent if the model has none.
std::string topology_json(const World& world);
/// The members of "scenario" that a page needs, as an object: title, until, every, step, method, gravity, floor (whether
/// put_on_floor changed the scenario) and events.
std::string scenario_json(const Scenario& scenario, const Vec3& gravity, bool floor = false);

/// The message "loaded", of JSON; without a model its world is null.
std::string loaded_json(std::string_view diagnostics, std::string_view scenario = {}, std::string_view model = {},
                        std::string_view topology = {}, std::string_view frame = {});

/// What pages have been told of a simulation.
struct KnownWorld {
  std::string topology;  ///< JSON
  std::uint64_t revision = 0;
  std::size_t events = 0;

  /// The present world is known.
  void read(const Simulation& simulation);
  /// Posts the messages "topology" and "events" if there is something new. `lines`: of the new events, see event_list(). False if
  /// there is nothing.
  bool tell(const Simulation& simulation, const std::function<void(const std::string&)>& post, std::string& lines);
};

/// The lines of events.jsonl of events from number `first` on, separated by commas.
std::string event_list(const std::vector<Event>& events, std::size_t first);

void fill_motions(const World& world, std::vector<double>& all);

/// A load at which a joint breaks, in addition to its own strength: the threshold of an event's condition.
struct Threshold {
  int joint;
  Condition condition;
};
std::vector<Threshold> thresholds_of(const Scenario& scenario, const World& world);
/// `reactions`: with reactions and loads, which are zero and NaN otherwise.
void fill_joints(const Simulation& simulation, const std::vector<Threshold>& thresholds, bool reactions,
                 std::vector<double>& all);
void fill_totals(const Simulation& simulation, double* all);
/// The points at which bodies touch, see contact_size.
void fill_contacts(const World& world, std::vector<double>& all);

/// What a page draws: the totals in double precision, then in single precision per body position and quaternion (7), per joint's
/// row the load as a fraction of that at which it breaks, the reaction force, whether it is determined, and its components (6),
/// and per contact its point and the force on the first body (6); in the machine's byte order.
struct PageFrame {
  std::size_t poses = 0, loads = 0, contacts = 0;  ///< numbers of each
  std::vector<unsigned char> bytes;
};
PageFrame frame_of(const Simulation& simulation, const std::vector<Threshold>& thresholds);
/// {"poses": …, "loads": …, "contacts": …}, the counts, and the bytes in base64 as "numbers" if `with_numbers`.
std::string frame_json(const PageFrame& frame, bool with_numbers);

/// The motions (fill_motions) of a model at rest at these coordinates of the joints of its tree, in the order of their numbers;
/// prescribed motions are at time 0. Loops are closed by the least change of the joints whose coordinates are as in `posed`, the
/// result of the last call or, if that is empty, the start: a joint that is moved stays where it was put. `posed` becomes the
/// present one. Nothing changes if that is impossible.
void pose(const Model& model, const double* q, std::vector<double>& motions, std::vector<double>& posed);

}  // namespace momentree::io
