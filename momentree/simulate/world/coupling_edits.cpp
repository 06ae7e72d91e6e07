// Couplings of joints in topology changes.
#include <momentree/model/forced_stop.hpp>
#include <momentree/simulate/world/topology_editor_impl.hpp>

namespace momentree {

std::vector<unsigned char> acting_couplings(const Tree& tree) {
  std::vector<unsigned char> acting(tree.couplings().size());
  for (std::size_t c = 0; c < acting.size(); ++c) acting[c] = tree.coupling_acts(static_cast<int>(c)) ? 1 : 0;
  return acting;
}

void TopologyEditor::end_couplings(int joint) {
  for (std::size_t c = 0; c < tree().couplings().size(); ++c) {
    const Coupling& coupling = tree().couplings()[c];
    if (tree().coupling_acts(static_cast<int>(c)) && (coupling.joint.index == joint || coupling.follows.index == joint))
      carry_out(EndCoupling{{static_cast<int>(c)}}, Nature::workless);
  }
}

ActionResult TopologyEditor::can_be_stopped(int joint, const JointParameters& parameters) const {
  std::vector<Coupling> acting;
  for (std::size_t c = 0; c < tree().couplings().size(); ++c)
    if (tree().coupling_acts(static_cast<int>(c))) acting.push_back(tree().couplings()[c]);
  const auto of = [&](JointId id) { return id.index == joint ? &parameters : tree().parameters(tree().carrier(id.index)); };
  const std::optional<ForcedStop> forced = forced_stop(acting, of);
  if (!forced) return ActionResult::done();
  const CouplingProblem problem = problem_of(*forced, [&](JointId id) { return joint_name(id.index); });
  return ActionResult::refused(problem.what, problem.hint);
}

void TopologyEditor::note_ended_couplings(const std::vector<unsigned char>& before) {
  for (std::size_t c = 0; c < before.size(); ++c)
    if (before[c] != 0 && !tree().coupling_acts(static_cast<int>(c)))
      event_->topology.ended_couplings.push_back(coupling_names(world_, {static_cast<int>(c)}));
}

void TopologyEditor::book_coupling_impulses() {
  for (const CouplingImpulse& given : coupling_impulses_now_) {
    if (given.joint == 0 && given.follows == 0) continue;
    const auto [joint, follows] = coupling_names(world_, {given.coupling});
    Event::OfCoupling* booked = nullptr;
    for (Event::OfCoupling& each : event_->coupling_impulse)
      if (each.joint == joint && each.follows == follows) booked = &each;
    if (booked == nullptr) booked = &event_->coupling_impulse.emplace_back(joint, follows);
    booked->on_joint += given.joint, booked->on_follows += given.follows;
  }
}

}  // namespace momentree
