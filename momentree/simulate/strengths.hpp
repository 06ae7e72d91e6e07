#pragma once
// Joint strengths (JointStrength): each is monitored as if an event "strength of <joint>" had been scheduled that breaks the
// joint when its reaction exceeds the strength.
#include <optional>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/simulate/condition.hpp>

namespace momentree {

/// A strength of one joint.
struct Strength {
  int joint;
  bool torque;  ///< torque or force
  double most;  ///< N m, N
  friend bool operator==(const Strength&, const Strength&) = default;
};

/// The strengths of all joints of a world, in the order of joint numbers, forces first.
std::vector<Strength> strengths(const World& world);
/// The mistake of a strength of a joint whose reaction the closed loops leave open: `where` is "joint 'name'".
[[nodiscard]] std::optional<Error> undetermined_strength(const World& world);
Condition condition_of(const Strength& strength);
std::string event_name(const World& world, const Strength& strength);

}  // namespace momentree
