#pragma once
// The columns and rows of bodies.csv and joints.csv.
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// Keeps the sign of quaternions continuous from row to row, since q and −q are the same rotation.
class ContinuousQuaternions {
 public:
  explicit ContinuousQuaternions(std::size_t count) : last_(count, Quat{0, 0, 0, 0}) {}
  /// `q`, or −q if that is nearer to the last quaternion of this `index`; the first one has w >= 0.
  Quat next(std::size_t index, const Quat& q);
  std::size_t size() const { return last_.size(); }
  /// The last quaternion of each index, to continue with.
  const std::vector<Quat>& last() const { return last_; }
  void continue_from(std::vector<Quat> last) {
    MT_REQUIRE(last.size() == last_.size(), "as many quaternions as there are");
    last_ = std::move(last);
  }

 private:
  std::vector<Quat> last_;
};

/// `time` (s), then per body x, y, z (m), qw, qx, qy, qz: the pose of its frame in the world. The columns stay the same for the
/// whole run: those of the bodies that are in the world at its start.
class BodyColumns {
 public:
  explicit BodyColumns(const World& world);
  void header(std::string& text, const Model& model) const;
  void row(std::string& text, const World& world);
  ContinuousQuaternions& quaternions() { return quaternions_; }

 private:
  std::vector<int> bodies_;
  ContinuousQuaternions quaternions_;
};

/// A joint of the columns, by name, with the numbers of coordinates and DoFs of the widest kind that it can have.
struct JointKinds {
  std::string name;
  int nq = 0, nv = 0;
};

/// Every joint that the simulation has now, in the order of their numbers, then those that its scheduled events will make, by
/// name. If the dry run is incomplete, the latter are those that the scenario's breaks and attachments alone would make.
std::vector<JointKinds> joints_of(const Simulation& simulation, const DryRun& dry_run, const Scenario& scenario);

/// `time`, then per joint its coordinates q0…, velocities v0… and momenta p0…; empty if the joint does not have that coordinate
/// at that time, or does not exist. A joint without columns is left out. With `reactions` also fx, fy, fz, mx, my, mz: the
/// whole wrench by which its declared parent holds its declared child (JointForces).
class JointColumns {
 public:
  explicit JointColumns(std::vector<JointKinds> joints, bool reactions = false);
  void header(std::string& text) const;
  void row(std::string& text, const World& world);
  ContinuousQuaternions& quaternions() { return quaternions_; }

 private:
  std::size_t group_of(std::size_t joint, std::string_view name);

  bool reactions_;
  std::vector<JointKinds> groups_;  ///< the last group is for joints without columns
  std::unordered_map<std::string, std::size_t> by_name_;
  std::vector<std::size_t> group_of_joint_;  ///< the group of the joint with that number in the last row
  std::vector<int> joint_of_group_;          ///< in this row; −1: absent
  ContinuousQuaternions quaternions_;
};

}  // namespace momentree::io
