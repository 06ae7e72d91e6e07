#include <momentree/scenario/coupling.hpp>

#include <cmath>
#include <map>
#include <utility>

#include <momentree/simulate/world/world.hpp>
#include <momentree/tree/lasting_function.hpp>

namespace momentree::io {

namespace {

/// One end of a coupling: its effort on one of the two joints.
struct End {
  JointCoupling coupling;
  double share;  ///< share of the spring's effort: 1 on the joint, −multiplier on its leader

  double effort(const EvaluationContext& context) const noexcept {
    // A joint that broke or was changed no longer has its function. Another joint with its number is not coupled; after a break
    // it is free, and may be driven.
    if (!context.has_function(coupling.joint) || !context.has_function(coupling.leader)) return 0;
    if (context.q(coupling.joint).size() != 1 || context.q(coupling.leader).size() != 1) return 0;
    const auto q = context.q(coupling.joint), v = context.v(coupling.joint);
    const auto q0 = context.q(coupling.leader), v0 = context.v(coupling.leader);
    const double apart = q[0] - coupling.multiplier * q0[0] - coupling.offset, rate = v[0] - coupling.multiplier * v0[0];
    return -share * (coupling.stiffness * apart + coupling.damping * rate);
  }
};

// Equal up to rounding: quaternions of a document are normalised when they are read.
bool same(double a, double b) { return std::fabs(a - b) <= 1e-12 * (1 + std::fabs(a)); }
bool same(const Vec3& a, const Vec3& b) { return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z); }
bool same(const Pose& a, const Pose& b) {
  const Quat &r = a.rotation, &s = b.rotation;
  const double sign = r.w * s.w + r.x * s.x + r.y * s.y + r.z * s.z < 0 ? -1 : 1;
  return same(a.position, b.position) && same(r.w, sign * s.w) && same(Vec3{r.x, r.y, r.z}, sign * Vec3{s.x, s.y, s.z});
}

// False for a joint that broke or was changed before the run began.
bool as_in_the_model(const World& world, JointId joint) {
  if (world.tree().carrier(joint.index) < 0) return false;
  const JointView now = world.joint(joint);
  const BodySpec& then = world.model()[joint];
  return now.name == then.joint_name && now.child == world.model().child(joint) && now.parent == then.parent &&
         now.kind == then.joint.kind && same(now.axis, then.joint.axis) && now.pitch == then.joint.pitch &&
         same(now.at, then.at) && same(now.child_at, then.child_at);
}

}  // namespace

void couple(Simulation& simulation, const std::vector<JointCoupling>& couplings) {
  std::map<int, std::vector<End>> ends;  // a joint may have several
  // if one end no longer exists, the other one stays, as in a run: it then has no effect
  for (const JointCoupling& each : couplings) {
    if (as_in_the_model(simulation.world(), each.joint)) ends[each.joint.index].push_back({each, 1});
    if (as_in_the_model(simulation.world(), each.leader)) ends[each.leader.index].push_back({each, -each.multiplier});
  }
  std::vector<JointDriver> drivers;
  for (auto& [joint, acting] : ends)
    drivers.push_back({std::string(simulation.world().joint({joint}).name),
                       lasting([all = std::move(acting)](const EvaluationContext& context, std::span<double> efforts) {
                         for (const End& end : all) efforts[0] += end.effort(context);
                       })});
  if (!drivers.empty()) simulation.drive_all(std::move(drivers));
}

}  // namespace momentree::io
