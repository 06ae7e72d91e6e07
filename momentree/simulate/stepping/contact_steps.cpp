#include <momentree/simulate/stepping/contact_steps.hpp>

#include <algorithm>
#include <iterator>

#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

void ContactSteps::begin_step() {
  const std::span<const SteppedContact> known(points.all().data(), points.released() ? 0 : points.all().size());
  resting_.begin_step(world_->tree(), world_->state(), world_->workspace(), known, usual_step_);
}

void ContactSteps::apply(State& state, EnergyLedger& ledger, double h) {
  const std::vector<SteppedContact> before = points.all();
  points.release();
  world_->evaluate();
  motion_.note_power();
  const double within = reach(h);
  if (resting_.put_back(world_->tree(), state, *stepped_, within, before)) world_->evaluate();
  impulses_.find_stops(stops_, h);
  impulses_.find_points(within, resting_.stays());
  impulses_.hits.clear(), touching_.clear(), motion_.forget_overlapping();
  for (; impulses_.any(); impulses_.find_points(within, resting_.stays())) {
    impulses_.solve(before, h);
    if (impulses_.stops.empty() || !impulses_.jammed()) break;
    impulses_.stops.clear(), impulses_.hits.clear();
    world_->evaluate();
  }
  // Bodies that rest keep their points.
  std::vector<SteppedContact> next;
  std::ranges::copy_if(before, std::back_inserter(next), [this](const SteppedContact& point) {
    return point.joint < 0 && (resting_.stays(point.a) || resting_.stays(point.b));
  });
  for (std::size_t i = 0; i < impulses_.near.size(); ++i)
    if (!(impulses_.rows.touches[i].gap > policy::step_touch)) touching_.emplace_back(impulses_.near[i].a, impulses_.near[i].b);
  for (const SteppedContact& point : next) touching_.emplace_back(point.a, point.b);
  if (impulses_.any()) {
    motion_.apply(impulses_, state, ledger, h);
    impulses_.add_means(before, h, usual_step_, next);
    resting_.come_to_rest(world_->tree(), state, next);
  }
  points.set(std::move(next));
}

void ContactSteps::find_forces() {
  points.release();
  world_->evaluate();
  impulses_.find_stops(stops_, 0);
  impulses_.find_points(policy::step_touch, {});
  points.take_place(impulses_.forces_from_rest(points.all(), usual_step_));
}

// How near each other points are that count in a step of h seconds (m): also those that others push towards each other in it, and
// those with forces that a short step may not need.
double ContactSteps::reach(double h) const {
  const double gravity = world_->gravity(), speed = stepped_->fastest() + gravity * h;
  return std::max({h * speed, gravity * usual_step_ * usual_step_, policy::step_touch});
}

std::vector<SteppedContact> ContactSteps::near_points() const {
  std::vector<Contact> near;
  stepped_->add_near(reach(usual_step_), near);
  std::vector<SteppedContact> all = points.all();
  std::erase_if(all, [&](const SteppedContact& point) {
    return point.joint < 0 && std::ranges::none_of(near, [&](const Contact& c) { return c.pair == point.pair; });
  });
  return all;
}

bool ContactSteps::still_near() const { return near_points().size() == points.all().size(); }

void ContactSteps::forget_parted() {
  if (points.all().empty()) return;
  std::vector<SteppedContact> near = near_points();
  if (near.size() < points.all().size()) points.set(std::move(near), points.released());
}

}  // namespace momentree
