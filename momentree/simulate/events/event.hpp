#pragma once
// Events that happened: actions, times and conservation certificates.
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <momentree/dynamics/motion.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/simulate/names.hpp>

namespace momentree {

/// The effect of one action of an event. Names are those just before the event, except `joint` of an action that makes one.
struct ActionRecord {
  std::string kind;      ///< as in scenario files: "break"; for joint limits "hit", "rest" or "leave"; for bodies "add" or
                         ///< "remove"
  std::string target;    ///< as in logs: "chain/41", "satellite/hull to tug/gripper", "arm/elbow upper"
  std::string joint;     ///< the joint that it acted on or made; empty: none
  std::string body, to;  ///< the body that it acted on, and the body that was joined to it (may be "ground"); empty: none
  std::string skipped;   ///< why nothing was done; empty: the action was carried out
  std::string spring{};  ///< the spring that it acted on, which then is in the place of a joint; empty: none

  /// "break chain/41", "break chain/41 skipped: the joint no longer exists".
  std::string text() const { return kind + " " + target + (skipped.empty() ? "" : " skipped: " + skipped); }
  friend bool operator==(const ActionRecord&, const ActionRecord&) = default;
};

/// A joint after an event, in its declared direction.
struct JointRecord {
  std::string name;
  Kind kind = Kind::weld;
  std::string parent, child;  ///< names of bodies; the parent may be "ground"
  Pose at, child_at;
  Vec3 axis{}, axis2{};
  double pitch = 0;
  unsigned locked = 0;  ///< one bit per locked DoF
  bool loop = false;    ///< it closes a loop
};

/// How an event changed the topology: all that a reader needs to follow it without implementing the actions.
struct TopologyRecord {
  std::vector<std::string> gone;    ///< names of joints that no longer exist
  std::vector<JointRecord> joints;  ///< joints that were made or changed; they replace earlier joints with the same names
  /// Bodies that now belong to another mechanism, as ranges of body numbers. Of several events at one instant, the last one lists
  /// them.
  struct Moved {
    std::string mechanism;
    std::vector<std::pair<int, int>> bodies;  ///< first number, count
  };
  std::vector<Moved> moved;
  std::vector<std::string> broken_springs{};  ///< names of springs that broke, or lost a body with which they left the world
  /// Exact couplings that ended with one of their joints: the names of both joints, the second one empty if there is none.
  std::vector<std::pair<std::string, std::string>> ended_couplings{};
  bool empty() const {
    return gone.empty() && joints.empty() && moved.empty() && broken_springs.empty() && ended_couplings.empty();
  }
};

/// An event that happened, with its certificate: the quantities that it conserved and the energy that it lost.
struct Event {
  double time = 0;
  std::string name;  ///< the event's name, or #1, #2 … by its place
  std::vector<ActionRecord> actions;
  TopologyRecord topology;
  MechanismNames mechanisms_before, mechanisms_after;
  /// "break chain/41", …: see ActionRecord::text().
  std::vector<std::string> action_texts() const {
    std::vector<std::string> all;
    for (const ActionRecord& action : actions) all.push_back(action.text());
    return all;
  }
  Totals before, after;
  double released = 0;  ///< energy of springs and armatures removed together with their DoFs (J)
  double lost = 0;      ///< energy lost in its impacts: the kinetic energy of the velocity jump (J)
  double work = 0;      ///< energy added by its impulses and new parameters (J)
  /// By joint name, the impulse that the parent exerted on the child through the joint: force (N s), then torque (N m s) about
  /// the child's origin, in the child's axes. Zero impulses are omitted.
  std::vector<std::pair<std::string, std::array<double, 6>>> impulse;
  /// Of an event at a contact.
  struct Contact {
    std::string one, other;  ///< bodies, or "ground"; empty: the event is no such event
    Vec3 point{}, normal{};  ///< in the world (m); the normal points from `other` to `one`
    Vec3 impulse{};          ///< on `one` (N s), world axes; of several points of the two bodies, their sum
    double scaled = 1;       ///< the part of the expansion that the law of impact let happen
    bool in_turn = false;    ///< simultaneous contacts were taken in turn
    std::string cable{};     ///< that became taut or slack; empty: the bodies touch
  };
  Contact contact{};
  /// Of an event that changes how contacts are computed: why, and the mechanisms of which this is true. A slip that ends because
  /// no finite force allows it (Painlevé's paradox) has a reason, too.
  std::string reason{};
  std::vector<std::string> stepped{};
  /// The impulse that the ground exerted on the mechanisms: force (N s), then torque (N m s) about the world's origin, in world
  /// axes.
  std::array<double, 6> ground_impulse{};
  /// The impulses of exact couplings along the DoFs of their joints (N s, N m s). Zero impulses are omitted.
  struct OfCoupling {
    std::string joint, follows;  ///< names; `follows` is empty if there is none
    double on_joint = 0, on_follows = 0;
  };
  std::vector<OfCoupling> coupling_impulse{};
  /// The joint with the largest linear impulse (among equal ones, that with the largest angular impulse), and both (N s, N m s).
  std::string hardest_joint;
  double hardest_linear = 0, hardest_angular = 0;
  double duration_ns = 0;  ///< the change itself, without the evaluations before and after it and without this certificate
};

/// A scheduled event that has not happened so far, and why.
struct MissedEvent {
  std::string name;
  /// When it is due (s), if that is known; infinite if it follows another event or depends on a condition.
  double time = HUGE_VAL;
  std::string after;  ///< the event that it follows, which did not happen
  /// For a condition: the quantity ("distance"), its threshold, exceeded or fallen below, the nearest value, and when it
  /// occurred. NaN if the quantity never had a value, for example because its joint no longer existed. A condition that has to
  /// last never held for longer than `held`.
  std::string quantity;
  std::vector<std::string> of;  ///< joints, bodies or mechanisms of the quantity
  double threshold = 0;
  bool exceeds = true;
  double nearest = NAN, nearest_time = NAN;
  double lasts = 0, held = 0;  ///< s
};

/// Status of a scheduled event in a snapshot.
struct EventStatus {
  double time = 0;       ///< when it is due (s), if known
  int fired = 0;         ///< how often it has happened
  bool done = false;     ///< it will not happen again
  double since = -1;     ///< time (s) since which its condition holds; −1: it does not hold
  bool resting = false;  ///< it repeats, and is not armed again yet
  double excess = 0, excess_before = 0, looked = -1, looked_before = -1;  ///< at the last two evaluations, and their times
  friend bool operator==(const EventStatus&, const EventStatus&) = default;
};

}  // namespace momentree
