#pragma once
// Time stepping through contacts, as a method of its own and as what is left when contacts can't be located one by one.
//
// After a step without contacts, the points that bodies have reached get impulses by the law of impact (contact::ManyPoints). A
// point that was reached a time τ before the end of the step moves by τ times the change of its velocity: the instant of touching
// is estimated instead of located, and a body at rest stays where it is.
#include <algorithm>
#include <memory>
#include <vector>

#include <momentree/contact/many_points.hpp>
#include <momentree/dynamics/contact_parts.hpp>
#include <momentree/integrate/step_contacts.hpp>
#include <momentree/simulate/contacts.hpp>
#include <momentree/simulate/resting_islands.hpp>
#include <momentree/simulate/stepping_state.hpp>

namespace momentree {

/// A hard stop of a joint of the tree, which takes part in the impulses of the next steps as a further point.
struct SteppedStop {
  int joint, body, dof, sign;  ///< sign 1: the upper stop
  double limit, restitution, rest_speed;
  bool touched;        ///< the joint is there at the start of the step, and does not move away
  bool rests = false;  ///< it rests there
  double force = 0;    ///< in the step before (N or N m)
};

class ContactSteps final : public StepContacts {
 public:
  ContactSteps(World& world, Evaluator& evaluate, Contacts& contacts)
      : world_(&world), evaluate_(&evaluate), contacts_(&contacts) {}

  void apply(State& state, EnergyLedger& ledger, double h) override;
  /// To be called before a step, with an evaluation of the state.
  void begin_step();
  void note_start() override { points_at_start_ = points_, released_at_start_ = released_; }
  void return_to_start() override { set_points(points_at_start_, released_at_start_); }

  /// Forgets all stops.
  void clear_stops() { stops_.clear(); }
  void add_stop(const SteppedStop& stop) { stops_.push_back(stop); }
  /// True if the contacts of this body are stepped through, and the stops of its joint.
  bool steps(int body) const { return contacts_->steps(body); }
  /// What is known of a stop since the last step; null: it had no force, and the joint does not rest on it.
  const SteppedContact* at_stop(int joint, int dof, int sign) const;
  /// True if the joint hit its stop in the last step.
  bool struck(int joint, int dof, int sign) const;
  /// Until the next step, no joint did.
  void forget_hits() { hit_.clear(); }
  /// Notes whether the joint rests on it.
  void set_resting(const SteppedStop& stop);

  /// The usual length of a step (s). Forces are the means over that time: impulses of shorter steps say little.
  void set_usual_step(double h) { usual_step_ = h; }
  /// Points with forces in the last step.
  const std::vector<SteppedContact>& points() const { return points_; }
  /// Continues with these points, or without any. `released`: as after release().
  void set_points(std::vector<SteppedContact> points, bool released = false);

  /// The bodies that hit others in the last step, rather than to lie on them.
  const std::vector<int>& hits() const { return hits_; }
  /// See ManyPoints::residual().
  double residual() const { return many_.residual(); }
  /// Pairs of bodies that touched in the last step; −1: the ground.
  const std::vector<std::pair<int, int>>& touching() const { return touching_; }
  /// The pairs that the last step could not keep from overlapping by more than `left_by_steps`, each with its depth (m).
  const std::vector<std::pair<int, double>>& overlapping() const { return overlapping_; }
  /// Evaluations until the next step are without the forces of the last one, which stay the first guess of that step. So it is
  /// before the first step.
  void release();
  bool released() const { return released_; }
  /// Until then, evaluations have the forces that the present state would have in a step, which take the place of those of the
  /// last one. What bodies hit each other with is no force.
  void find_forces();
  bool has_forces() const { return has_forces_; }
  /// True if the bodies of all points are as near each other as in a step that finds them.
  bool still_near();
  /// Forgets the points whose bodies are not: those of cables that broke or became longer.
  void forget_parted();

 private:
  struct Moments {
    std::size_t contact, point;  ///< numbers in near_ and in many_
    double length;               ///< of its unit impulses (m)
  };
  struct NearStop {
    SteppedStop stop;
    double gap, velocity, acceleration;  ///< as those of points
  };
  void forget_points();
  double reach(double h) const;
  void find_near() { near_.clear(), contacts_->add_near(reach(usual_step_), near_); }
  bool is_near(const SteppedContact& point) const;
  void find_stops(double h);
  void find_points(double within);
  void find_moments();
  const Moments* moments_of(std::size_t contact) const {
    const auto found = std::ranges::lower_bound(moments_, contact, {}, &Moments::contact);
    return found != moments_.end() && found->contact == contact ? &*found : nullptr;
  }
  void share_times();
  SteppedContact point_at(std::size_t i, const Vec3& force, const std::vector<double>& velocity) const;
  void add_moment(std::size_t i, double before, double over, SteppedContact& point) const;
  void guess(double h);
  bool approach(std::size_t point, double gap, double v, double a, double restitution, double slow, double h);
  void set_law(double h);
  void solve(double h);
  bool jammed();
  double energy() const;
  void move(State& state, EnergyLedger& ledger);
  void take_back_work(double t, EnergyLedger& ledger, double h);
  void displace(State& state, contact::LinksMotion& by);
  void note_overlaps(contact::LinksMotion& moved);
  bool lay_there(double v, double a, double h) const;
  void remember(double h);
  void hold(const std::vector<SteppedContact>& points);
  void show_stops(const std::vector<SteppedContact>& points);

  World* world_;
  Evaluator* evaluate_;
  Contacts* contacts_;
  ContactParts parts_;
  MomentumKeepingDisplacement displacement_;
  RestingIslands resting_;
  std::vector<Contact> near_;
  ContactRows rows_;
  contact::ManyPoints many_;
  std::vector<double> reached_;   // by point: the time since it was reached (s)
  std::vector<bool> hit_;         // by point: it was hit in the step
  std::vector<double> carried_;   // by point: three components of the force before (N)
  std::vector<Moments> moments_;  // in ascending order; their points are those after stops
  std::vector<double> after_, gaps_, pushes_, packed_;
  std::vector<double> free_q_, free_u_;  // the motion at the end of the step without contacts
  Power free_power_;                     // there
  double usual_step_ = 0;
  std::vector<SteppedStop> stops_;
  std::vector<NearStop> near_stops_;
  std::vector<SteppedContact> points_;
  bool released_ = true, has_forces_ = false;
  std::vector<SteppedContact> points_at_start_;  // of the present step
  bool released_at_start_ = false;
  std::vector<int> hits_;
  std::vector<std::pair<int, int>> touching_;
  std::vector<std::pair<int, double>> overlapping_;
};

}  // namespace momentree
