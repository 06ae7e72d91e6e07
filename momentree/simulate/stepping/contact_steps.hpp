#pragma once
// Time stepping through contacts, as a method of its own and as what is left when contacts can't be located one by one.
//
// After a step without contacts, the points that bodies have reached get impulses by the law of impact (contact::ManyPoints). A
// point that was reached a time τ before the end of the step moves by τ times the change of its velocity: the instant of touching
// is estimated instead of located, and a body at rest stays where it is.
#include <utility>
#include <vector>

#include <momentree/integrate/step_contacts.hpp>
#include <momentree/simulate/stepping/pair_overlaps.hpp>
#include <momentree/simulate/stepping/resting_islands.hpp>
#include <momentree/simulate/stepping/step_impulses.hpp>
#include <momentree/simulate/stepping/step_motion.hpp>
#include <momentree/simulate/stepping/step_points.hpp>

namespace momentree {

class ContactSteps final : public StepContacts {
 public:
  explicit ContactSteps(const ContactGeometry& geometry)
      : points(geometry.world),
        world_(&geometry.world),
        stepped_(&geometry.stepped),
        impulses_(geometry.world, geometry.pairs, geometry.stepped),
        motion_(geometry.world) {}

  void apply(State& state, EnergyLedger& ledger, double h) override;
  /// To be called before a step, with an evaluation of the state.
  void begin_step();
  void note_start() override { points_at_start_ = points; }
  void return_to_start() override { points.set(points_at_start_.all(), points_at_start_.released()); }
  /// The usual length of a step (s). Forces are the means over that time: impulses of shorter steps say little.
  void set_usual_step(double h) { usual_step_ = h; }

  /// Forgets all stops.
  void clear_stops() { stops_.clear(); }
  void add_stop(const SteppedStop& stop) { stops_.push_back(stop); }
  /// True if the contacts of this body are stepped through, and the stops of its joint.
  bool steps(int body) const { return stepped_->steps(body); }
  /// True if the joint hit its stop in the last step.
  bool struck(int joint, int dof, int sign) const { return impulses_.struck(joint, dof, sign); }
  /// Until the next step, no joint did.
  void forget_hits() { impulses_.forget_hits(); }

  /// The bodies that hit others in the last step, rather than to lie on them.
  const std::vector<int>& hits() const { return impulses_.hits; }
  /// See ManyPoints::residual().
  double residual() const { return impulses_.many.residual(); }
  /// Pairs of bodies that touched in the last step; −1: the ground.
  const std::vector<std::pair<int, int>>& touching() const { return touching_; }
  /// See StepMotion::overlapping().
  const std::vector<std::pair<int, double>>& overlapping() const { return motion_.overlapping(); }

  /// Until the next step, evaluations have the forces that the present state would have in one. What bodies hit each other with
  /// is no force.
  void find_forces();
  /// True if the bodies of all points are as near each other as in a step that finds them.
  bool still_near() const;
  /// Forgets the points whose bodies are not: those of cables that broke or became longer.
  void forget_parted();

  StepPoints points;

 private:
  double reach(double h) const;
  std::vector<SteppedContact> near_points() const;

  const ContactWorld* world_;
  const SteppedPairs* stepped_;
  StepImpulses impulses_;
  StepMotion motion_;
  RestingIslands resting_;
  double usual_step_ = 0;
  std::vector<SteppedStop> stops_;
  StepPoints points_at_start_ = points;  // of the present step
  std::vector<std::pair<int, int>> touching_;
};

}  // namespace momentree
