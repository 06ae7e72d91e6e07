#include <momentree/model/start.hpp>

#include <algorithm>

#include <momentree/joint/motion.hpp>

namespace momentree {

Values within_stops(const JointLimits& limits, Values q) {
  for (int i = 0; limits.hard() && i < q.size(); ++i) q[i] = std::min(std::max(q[i], limits.lower_of(i)), limits.upper_of(i));
  return q;
}

Values start_coordinates(const BodySpec& spec) {
  return spec.q.empty() ? within_stops(spec.joint.parameters.limits, joint_zero(spec.joint.kind)) : spec.q;
}

}  // namespace momentree
