#pragma once
// Strengths of joints (JointStrength) and springs: each is monitored as if an event "strength of <joint>" had been scheduled that
// breaks the joint when its reaction exceeds the strength, or the spring when its force does.
#include <optional>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/simulate/events/condition.hpp>

namespace momentree {

/// A strength of one joint or spring.
struct Strength {
  int joint;    ///< or −1
  bool torque;  ///< torque or force
  double most;  ///< N m, N
  int spring = -1;
  friend bool operator==(const Strength&, const Strength&) = default;
};

/// True if a joint or a spring of the world has a strength.
bool has_strengths(const World& world);
/// The strengths of all joints of a world, in the order of joint numbers, forces first; then those of the springs.
std::vector<Strength> strengths(const World& world);
/// The joint or spring.
std::string name_of(const World& world, const Strength& strength);
/// The mistake of a strength of a joint whose reaction the closed loops leave open: `where` is "joint 'name'".
[[nodiscard]] std::optional<Error> undetermined_strength(const World& world);
Condition condition_of(const Strength& strength);
std::string event_name(const World& world, const Strength& strength);

}  // namespace momentree
