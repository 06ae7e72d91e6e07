#include <momentree/simulate/stepping/step_points.hpp>

#include <algorithm>
#include <iterator>

namespace momentree {

const SteppedContact* StepPoints::at_stop(int joint, int dof, int sign) const {
  for (const SteppedContact& p : all_) {
    if (p.joint < 0) break;
    if (p.joint == joint && p.id == static_cast<std::uint64_t>(dof) && p.side == sign) return &p;
  }
  return nullptr;
}

void StepPoints::set_resting(const SteppedStop& stop) {
  if (const SteppedContact* const known = at_stop(stop.joint, stop.dof, stop.sign))
    all_[static_cast<std::size_t>(known - all_.data())].rests = stop.rests;
  else
    all_.insert(all_.begin(), point_of(stop, 0));
  show_stops(all_);
}

void StepPoints::set(std::vector<SteppedContact> points, bool released) {
  all_ = std::move(points), released_ = released;
  if (released) return release();
  hold(all_);
}

void StepPoints::release() {
  released_ = true, has_forces_ = false;
  held_forces(world_->workspace()).clear();
  show_stops(all_);
  static_cast<void>(world_->state().edit());
}

void StepPoints::take_place(std::vector<SteppedContact> forces) {
  if (!all_.empty()) return set(std::move(forces));
  std::ranges::copy_if(forces, std::back_inserter(all_), [](const SteppedContact& point) { return point.joint >= 0; });
  hold(forces);
}

void StepPoints::hold(const std::vector<SteppedContact>& points) {
  has_forces_ = true;
  std::vector<HeldForce>& held = held_forces(world_->workspace());
  held.clear();
  for (const SteppedContact& point : points)
    if (point.joint < 0)
      held.push_back({point.a, point.b, point.point, point.force, point.normal, point.slip, point.cable, point.moment});
  show_stops(points);
  static_cast<void>(world_->state().edit());  // its evaluation is without them
}

void StepPoints::show_stops(const std::vector<SteppedContact>& points) {
  std::vector<HeldStop>& held = contact_memory(world_->workspace()).stops;
  held.clear();
  for (const SteppedContact& point : points)
    if (point.joint >= 0)
      held.push_back({point.joint, static_cast<int>(point.id), has_forces_ ? -point.side * point.force.x : 0, point.rests});
}

}  // namespace momentree
