#pragma once
// How a change is carried out and booked. Included only by the files that implement TopologyEditor.
#include <chrono>
#include <cmath>

#include <momentree/base/error.hpp>
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree {

template <class Change>
void TopologyEditor::carry_out(const Change& change, Nature nature) {
  if (tree().has_loops()) edit_.take_variables(Variables::velocities);  // until the end of the instant
  evaluate();
  const Totals before = world_.totals();
  if constexpr (std::is_same_v<Change, ChangeJoint>) {
    if (!std::isfinite(before.kinetic))
      throw_error({"joint '" + joint_name(change.joint.index) + "' can't change: the kinetic energy is not finite", "",
                   "are the velocities and momenta in SI units?"});
  }
  if (nature != Nature::workless) remember_momenta();
  const std::vector<unsigned char> coupled = acting_couplings(tree());
  const auto start = std::chrono::steady_clock::now();
  Released released;
  if constexpr (std::is_same_v<Change, Impact> || std::is_same_v<Change, MakeLoop>)
    apply(change, edit_.tree(), edit_.state(), edit_.workspace());
  else
    released = apply(change, edit_.tree(), edit_.state(), edit_.workspace());
  const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  account_.seconds += taken;
  ++account_.changes;
  event_->duration_ns += taken * 1e9;
  event_->released += released.energy;
  note_ended_couplings(coupled);
  if (nature == Nature::workless) return;
  loop_impulses_now_.clear();
  for (std::size_t i = 0; i < tree().loops().size(); ++i)
    loop_impulses_now_.push_back(loop_impulse(tree(), edit_.workspace(), static_cast<int>(i)));
  coupling_impulses_now_.clear();
  for (std::size_t i = tree().loops().size(); i < tree().loops().links.size(); ++i)
    coupling_impulses_now_.push_back(coupling_impulse(tree(), edit_.workspace(), static_cast<int>(i)));
  evaluate();
  const Totals after = world_.totals();
  const double gone = before.kinetic + before.potential - after.kinetic - after.potential - released.energy;
  const double driven = nature == Nature::impact ? work_of_motions() : -gone;
  event_->work += driven;
  if (nature == Nature::impact) event_->lost += gone + driven;
  if (nature == Nature::outside) account_.brought += after.kinetic - before.kinetic;
  if constexpr (std::is_same_v<Change, Impulse>) {
    const BodyMotion& motion = world_.motions()[static_cast<std::size_t>(change.body.index)];
    const AppliedImpulse applied{change.body.index, change.force, change.torque, motion.pose * change.point};
    book_impulses({&applied, 1});
  } else {
    book_impulses({});
  }
}

}  // namespace momentree
