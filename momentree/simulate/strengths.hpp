#pragma once
// What joints bear (JointStrength): each is watched as if an event had been scheduled for it, "strength of <joint>", that breaks
// the joint when its reaction exceeds it.
#include <vector>

#include <momentree/simulate/condition.hpp>

namespace momentree {

/// A strength of one joint.
struct Strength {
  int joint;
  bool torque;  ///< or force
  double most;  ///< N m, N
  friend bool operator==(const Strength&, const Strength&) = default;
};

/// All that the joints of a world have now, in the order of joint numbers, forces first.
std::vector<Strength> strengths(const World& world);
Condition condition_of(const Strength& strength);
std::string event_name(const World& world, const Strength& strength);

}  // namespace momentree
