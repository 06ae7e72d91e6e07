#pragma once
// Hard stops of joints that couplings make follow a prescribed motion, which nothing can stop.
#include <functional>
#include <optional>
#include <span>
#include <string>

#include <momentree/joint/joint.hpp>
#include <momentree/model/coupling.hpp>

namespace momentree {

/// A joint with hard stops, and another one whose prescribed motion it has to follow by couplings.
struct ForcedStop {
  JointId joint, moved;
};
/// The first one, if there is any. `parameters`: of a joint of these couplings; null: it has none.
std::optional<ForcedStop> forced_stop(std::span<const Coupling> couplings,
                                      const std::function<const JointParameters*(JointId)>& parameters);
CouplingProblem problem_of(const ForcedStop& forced, const std::function<std::string(JointId)>& name);

}  // namespace momentree
