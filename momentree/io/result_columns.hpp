#pragma once
// The rows of bodies.csv and joints.csv: which columns there are, and what stands in them.
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <momentree/simulate/world.hpp>

namespace momentree::io {

/// Keeps the sign of quaternions continuous from row to row: q and −q are the same rotation.
class ContinuousQuaternions {
 public:
  explicit ContinuousQuaternions(std::size_t count) : last_(count, Quat{0, 0, 0, 0}) {}
  /// `q`, or −q if that is nearer to the last one of this `index`; the first one has w >= 0.
  Quat next(std::size_t index, const Quat& q);

 private:
  std::vector<Quat> last_;
};

/// `time`, then per body x, y, z, qw, qx, qy, qz: its frame in the world. The same columns for the whole run.
class BodyColumns {
 public:
  explicit BodyColumns(const Model& model);
  static void header(std::string& text, const Model& model);
  void row(std::string& text, const World& world);

 private:
  ContinuousQuaternions quaternions_;
};

/// `time`, then per joint its coordinates q0…, velocities v0… and momenta p0…, as wide as the widest kind that the joint can
/// have; empty where it has no such coordinate at that time, or is not there.
class JointColumns {
 public:
  /// `breakable`: the bodies whose joint an event breaks. Such a joint's place is taken by a free root joint named after the
  /// body.
  JointColumns(const Model& model, const std::vector<Body>& breakable);
  void header(std::string& text) const;
  void row(std::string& text, const World& world);

 private:
  struct Group {
    std::string name;
    int nq = 0, nv = 0;
  };
  void widen(const std::string& name, const KindInfo& kind);
  std::size_t group_of(std::size_t body, std::string_view name);

  std::vector<Group> groups_;
  std::unordered_map<std::string, std::size_t> by_name_;
  std::vector<std::size_t> group_of_body_;  ///< where the body's joint was in the last row
  std::vector<int> body_of_group_;          ///< in this row; −1: absent
  ContinuousQuaternions quaternions_;
};

}  // namespace momentree::io
