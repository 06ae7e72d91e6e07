#pragma once
// What is to be located within a step: the instants at which bodies touch, a contact would have to pull, or it begins to slip or
// to stick.
#include <span>
#include <vector>

#include <momentree/simulate/events/stops.hpp>
#include <momentree/simulate/stepping/slip_in_steps.hpp>
#include <momentree/simulate/stepping/stepped_pairs.hpp>

namespace momentree {

class ContactWatches {
 public:
  /// `step`: the length of steps (s); 0: the method adapts them.
  ContactWatches(const ContactWorld& world, const ContactPairs& pairs, const SteppedPairs& stepped, double step)
      : slip(world, step), world_(&world), pairs_(&pairs), stepped_(&stepped) {}

  /// What is to be located within a step of at most h seconds, which it may shorten so that nothing passes through anything.
  std::span<const Watch> watches(double& h);
  /// True after a step that ended at such an instant.
  bool must_resolve();
  /// Slower contacts have no direction of slip when their states are next chosen (m/s). What must_resolve() found about that is
  /// for one instant.
  double slow_slip() const { return slow_slip_; }
  void forget_slow_slip() { slow_slip_ = slowest_slip; }
  /// Short steps in a row in which a contact crept.
  int short_steps() const { return short_steps_; }
  void set_short_steps(int count) { short_steps_ = count; }

  SlipInSteps slip;

 private:
  struct Located;
  void watch(const Located& what);
  void watch_pairs(double& h);
  void watch_closed();
  void note_ended_slip();

  const ContactWorld* world_;
  const ContactPairs* pairs_;
  const SteppedPairs* stepped_;
  std::vector<Watch> watches_;
  std::vector<Condition> conditions_;
  std::vector<double> rounding_;  // of those that are gaps, which come first
  double started_ = 0;            // when the step began (s)
  int short_steps_ = 0;
  double slow_slip_ = slowest_slip;
};

}  // namespace momentree
