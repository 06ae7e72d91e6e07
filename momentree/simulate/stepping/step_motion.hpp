#pragma once
// What the impulses of a step through contacts move, and the energy that this takes or brings.
#include <vector>

#include <momentree/dynamics/contacts/contact_parts.hpp>
#include <momentree/simulate/stepping/step_impulses.hpp>

namespace momentree {

class StepMotion {
 public:
  explicit StepMotion(const ContactWorld& world) : world_(&world) {}

  /// To be called with an evaluation of the state at the end of the step without contacts, and before apply().
  void note_power() { free_power_ = world_->workspace().power; }
  /// Applies the impulses of a step of h seconds: to the velocities, and to the coordinates for the time since the points were
  /// reached. What is left of overlaps is removed. The energy that each of this takes or brings is measured.
  void apply(StepImpulses& impulses, State& state, EnergyLedger& ledger, double h);
  /// The pairs that the last step could not keep from overlapping by more than `left_by_steps`, each with its depth (m).
  const std::vector<std::pair<int, double>>& overlapping() const { return overlapping_; }
  void forget_overlapping() { overlapping_.clear(); }

 private:
  double energy() const;
  double deepest_after(StepImpulses& impulses, const State& state, contact::LinksMotion& moved);
  void take_back_work(StepImpulses& impulses, double t, EnergyLedger& ledger, double h);
  void displace(StepImpulses& impulses, State& state, contact::LinksMotion& by);

  const ContactWorld* world_;
  MomentumKeepingDisplacement displacement_;
  std::vector<double> gaps_, pushes_, packed_;
  std::vector<double> free_q_, free_u_;  // the motion at the end of the step without contacts
  Power free_power_;                     // there
  std::vector<std::pair<int, double>> overlapping_;
};

}  // namespace momentree
