#pragma once
// A row of the result: what happened, when, and what it conserved.
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <momentree/dynamics/totals.hpp>
#include <momentree/joint/joint.hpp>

namespace momentree {

/// What one action of an event did. Names are those of the moment before the event, `joint` of an action that makes one apart.
struct ActionRecord {
  std::string kind;      ///< as in scenario files, "break"; of a joint limit "hit", "rest", "leave"; "add", "remove" of a body
  std::string target;    ///< as in logs: "chain/41", "satellite/hull to tug/gripper", "arm/elbow upper"
  std::string joint;     ///< the joint that it acted on or made; empty: none
  std::string body, to;  ///< the body that it acted on, and what that was joined to ("ground" is possible); empty: none
  std::string skipped;   ///< why nothing was done; empty: it was done

  /// "break chain/41", "break chain/41 skipped: the joint is not there any more".
  std::string text() const { return kind + " " + target + (skipped.empty() ? "" : " skipped: " + skipped); }
  friend bool operator==(const ActionRecord&, const ActionRecord&) = default;
};

/// A joint as an event left it, in its declared direction.
struct JointRecord {
  std::string name;
  Kind kind = Kind::weld;
  std::string parent, child;  ///< names of bodies; the parent may be "ground"
  Pose at, child_at;
  Vec3 axis{}, axis2{};
  double pitch = 0;
  unsigned locked = 0;  ///< a bit per locked freedom
};

/// How an event changed the topology: what a reader needs to follow it without knowing what actions do.
struct TopologyRecord {
  std::vector<std::string> gone;    ///< names of joints that do not exist any more
  std::vector<JointRecord> joints;  ///< those that were made or changed: they replace what had their names
  /// Bodies that belong to another mechanism now, as ranges of body numbers. Of events at one instant the last one has them.
  struct Moved {
    std::string mechanism;
    std::vector<std::pair<int, int>> bodies;  ///< first number, count
  };
  std::vector<Moved> moved;
  bool empty() const { return gone.empty() && joints.empty() && moved.empty(); }
};

/// An event that happened, with its certificate: what it conserved and what it lost.
struct Event {
  double time = 0;
  std::string name;  ///< the event's name, or #1, #2 … by its place
  std::vector<ActionRecord> actions;
  TopologyRecord topology;
  std::vector<std::string> mechanisms_before, mechanisms_after;
  /// "break chain/41", …: see ActionRecord::text().
  std::vector<std::string> action_texts() const {
    std::vector<std::string> all;
    for (const ActionRecord& action : actions) all.push_back(action.text());
    return all;
  }
  Totals before, after;
  double released = 0;  ///< energy of springs and rotors that left with a freedom (J)
  double lost = 0;      ///< energy that its impacts took: the kinetic energy of the jump of velocities (J)
  double work = 0;      ///< energy that its impulses and new parameters brought (J)
  /// Per joint the impulse that the parent exerted on the child through it (N s, N m s): about the child's origin, in the
  /// child's axes; only where not zero.
  std::vector<std::pair<std::string, std::array<double, 6>>> impulse;
  /// The impulse that the ground exerted on the mechanisms: world axes, about the world's origin.
  std::array<double, 6> ground_impulse{};
  /// The joint with the largest linear impulse (of equal ones that with the largest angular one), and both (N s, N m s).
  std::string hardest_joint;
  double hardest_linear = 0, hardest_angular = 0;
  double duration_ns = 0;  ///< the change itself; evaluations before and after it and this certificate apart
};

/// A scheduled event that did not happen so far, and why.
struct MissedEvent {
  std::string name;
  /// When it is due, where that is known; infinite where it follows another event or a condition.
  double time = HUGE_VAL;
  std::string after;  ///< the event that it follows, which did not happen
  /// Of a condition: the quantity, "distance"; its threshold, exceeded or fallen below; the nearest that it came, and when. NaN
  /// where there was nothing to look at, as with a joint that was gone. A condition that has to last held no longer than `held`.
  std::string quantity;
  std::vector<std::string> of;  ///< joints, bodies or mechanisms of the quantity
  double threshold = 0;
  bool exceeds = true;
  double nearest = NAN, nearest_time = NAN;
  double lasts = 0, held = 0;  ///< s
};

}  // namespace momentree
