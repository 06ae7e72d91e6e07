#include <momentree/model/forced_stop.hpp>

#include <algorithm>
#include <array>
#include <vector>

namespace momentree {

std::optional<ForcedStop> forced_stop(std::span<const Coupling> couplings,
                                      const std::function<const JointParameters*(JointId)>& parameters) {
  const auto moves = [&](JointId joint) {
    const JointParameters* const own = parameters(joint);
    return own != nullptr && own->drive != nullptr && own->drive->moves();
  };
  std::vector<ForcedStop> decided;  // each joint that moves as prescribed, and the one whose motion that is
  const auto found = [&](JointId joint) { return std::ranges::find(decided, joint, &ForcedStop::joint); };
  for (const Coupling& each : couplings)
    for (const JointId joint : {each.joint, each.follows})
      if (joint.index >= 0 && moves(joint)) decided.push_back({joint, joint});
  for (bool more = true; more;) {
    more = false;
    for (const Coupling& each : couplings) {
      if (!each.leads() || (each.multiplier == 0 && each.higher == std::array<double, 3>{})) continue;
      const auto one = found(each.joint), other = found(each.follows);
      if ((one == decided.end()) == (other == decided.end())) continue;
      const ForcedStop next = one == decided.end() ? ForcedStop{each.joint, other->moved} : ForcedStop{each.follows, one->moved};
      const JointParameters* const own = parameters(next.joint);
      if (own != nullptr && own->limits.hard()) return next;
      decided.push_back(next);
      more = true;
    }
  }
  return std::nullopt;
}

CouplingProblem problem_of(const ForcedStop& forced, const std::function<std::string(JointId)>& name) {
  return {"joint",
          "joint '" + name(forced.joint) + "' follows the prescribed motion of '" + name(forced.moved) +
              "', so that its limits can't stop it",
          "leave its 'limits' out, make them soft by a 'stiffness', or drive '" + name(forced.moved) + "' by 'pd'"};
}

}  // namespace momentree
