#pragma once
// What topology changes did to a world, as events report it.
#include <string>
#include <vector>

#include <momentree/simulate/events/event.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

/// The joint of that number as it is now, its locks without those of limits that it rests on.
JointRecord joint_record(const World& world, JointId joint);

/// Joints that the world has now, in the order of their numbers.
std::vector<JointId> present_joints(const World& world);

/// Which mechanism each body belongs to.
class Membership {
 public:
  explicit Membership(const World& world);
  /// Numbers of bodies that the world had given.
  int bodies() const { return static_cast<int>(mechanism_.size()); }
  /// Bodies whose mechanism in `now` has another name than here. A body that was added since has moved, one that was removed not.
  std::vector<TopologyRecord::Moved> moved(const Membership& now) const;

 private:
  std::vector<int> mechanism_;      // by body a place in names_; −1: it left the world
  std::vector<std::string> names_;  // by mechanism
};

}  // namespace momentree
