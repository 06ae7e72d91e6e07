#include <momentree/io/coupling.hpp>

#include <map>
#include <utility>

#include <momentree/simulate/world.hpp>

namespace momentree::io {

namespace {

/// One end of a coupling: what it does to one of the two joints.
struct End {
  JointCoupling coupling;
  double share;  ///< of the spring's effort: 1 on the joint, −multiplier on its leader

  double effort(const Moment& moment) const noexcept {
    const auto q = moment.q(coupling.joint), v = moment.v(coupling.joint);
    const auto q0 = moment.q(coupling.leader), v0 = moment.v(coupling.leader);
    if (q.size() != 1 || q0.size() != 1) return 0;  // one of them broke, or has more freedoms now
    const double apart = q[0] - coupling.multiplier * q0[0] - coupling.offset, rate = v[0] - coupling.multiplier * v0[0];
    return -share * (coupling.stiffness * apart + coupling.damping * rate);
  }
};

bool as_in_the_model(const World& world, Body joint) {
  return world.tree().carrier(joint.index) >= 0 && world.joint(joint).kind == world.model()[joint].joint.kind;
}

}  // namespace

void couple(Simulation& simulation, const std::vector<JointCoupling>& couplings) {
  std::map<int, std::vector<End>> ends;  // a joint may have several
  for (const JointCoupling& each : couplings) {
    if (!as_in_the_model(simulation.world(), each.joint) || !as_in_the_model(simulation.world(), each.leader)) continue;
    ends[each.joint.index].push_back({each, 1});
    ends[each.leader.index].push_back({each, -each.multiplier});
  }
  std::vector<JointDriver> drivers;
  for (auto& [joint, acting] : ends)
    drivers.push_back({std::string(simulation.world().joint({joint}).name),
                       [all = std::move(acting)](const Moment& moment, std::span<double> efforts) {
                         for (const End& end : all) efforts[0] += end.effort(moment);
                       }});
  if (!drivers.empty()) simulation.drive_all(std::move(drivers));
}

}  // namespace momentree::io
