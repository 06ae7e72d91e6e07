#pragma once
// The points of contact with forces in the last step, which evaluations have until the next one.
#include <vector>

#include <momentree/simulate/contact/contact_world.hpp>
#include <momentree/simulate/stepping/step_impulses.hpp>

namespace momentree {

class StepPoints {
 public:
  explicit StepPoints(const ContactWorld& world) : world_(&world) {}

  const std::vector<SteppedContact>& all() const { return all_; }
  /// Continues with these points, or without any. `released`: as after release().
  void set(std::vector<SteppedContact> points, bool released = false);
  /// Evaluations until the next step are without the forces of the last one, which stay the first guess of that step. So it is
  /// before the first step.
  void release();
  bool released() const { return released_; }
  /// Until then, evaluations have these forces, which take the place of those of the last one.
  void take_place(std::vector<SteppedContact> forces);
  bool has_forces() const { return has_forces_; }

  /// What is known of a stop since the last step; null: it had no force, and the joint does not rest on it.
  const SteppedContact* at_stop(int joint, int dof, int sign) const;
  /// Notes whether the joint rests on it.
  void set_resting(const SteppedStop& stop);

 private:
  void hold(const std::vector<SteppedContact>& points);
  void show_stops(const std::vector<SteppedContact>& points);

  const ContactWorld* world_;
  std::vector<SteppedContact> all_;  // in order; stops come first
  bool released_ = true, has_forces_ = false;
};

}  // namespace momentree
