#include <momentree/simulate/stepping/slip_in_steps.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/simulate/contact/closed_contacts.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

void SlipInSteps::begin(double& h) {
  const std::span<const Contact> closed = world_->closed();
  speed_.assign(closed.size(), 0.0), turning_.assign(closed.size(), 0.0), direction_.assign(closed.size(), {});
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].mode != Contact::Mode::slip) continue;
    const Vec3 v = slip_velocity(*world_, closed[i]);
    speed_[i] = norm(v), turning_[i] = find_turning(i);
    if (speed_[i] > slowest_slip) direction_[i] = normalized(v);
    const double shortest = policy::shortest_step_of_slip * step_, turns = step_ > 0 ? 1 : policy::stable_turning;
    h = std::min(h, std::max(shortest, std::min(change_time(i), turns * (speed_[i] + most_kept(i)) / turning_[i])));
  }
}

double SlipInSteps::find_turning(std::size_t contact) const {
  const ContactRows& rows = world_->closed_rows();
  const std::span<const Contact> closed = world_->closed();
  double sum = 0;
  for (const std::size_t j : rows.of_group(rows.groups[rows.group_of[contact]])) {
    if (closed[j].mode != Contact::Mode::slip) continue;
    const double f1 = rows.forces[3 * j + 1], f2 = rows.forces[3 * j + 2];
    const auto change = [&](std::size_t k) {
      return rows.mobility(3 * contact + k, 3 * j + 1) * f1 + rows.mobility(3 * contact + k, 3 * j + 2) * f2;
    };
    sum += std::hypot(change(1), change(2));
  }
  return sum;
}

void SlipInSteps::keep_directions(double h) {
  std::vector<Contact> all = world_->closed_copy();
  bool any = false;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].mode != Contact::Mode::slip) continue;
    const double begun = step_ == 0 && least_kept(i) > slowest_slip ? least_kept(i) : 0;
    const double keeps = std::clamp(turning_[i] * (step_ > 0 ? step_ : h) / 2 - speed_[i], begun, most_kept(i));
    any = any || keeps > 0 || all[i].keeps_direction > 0;
    all[i].direction = world_->closed_rows().slip[i], all[i].keeps_direction = keeps;
  }
  if (any) world_->close(std::move(all)), world_->evaluate();
}

// Fixed steps keep the direction of slip that has begun. Methods that adapt theirs keep more and more of it while it goes
// straight on.
double SlipInSteps::most_kept(std::size_t contact) const {
  const double now = kept(contact), least = least_kept(contact);
  if (step_ > 0) return now > 0 ? HUGE_VAL : 0;
  const double less = turned(contact, world_->closed_rows());
  if (less > policy::most_turned) return least;
  return std::max(least, less * policy::keeps_more < policy::most_turned ? policy::keeps_more * now : now);
}

// What a contact keeps, or, if it has closed since its pair began to slip, what others of the pair do (m/s).
double SlipInSteps::kept(std::size_t contact) const {
  const std::span<const Contact> closed = world_->closed();
  double most = closed[contact].keeps_direction;
  if (most > 0) return most;
  for (const ContactsByPair::Entry& entry : world_->closed_of(closed[contact].pair))
    if (closed[entry.second].mode == Contact::Mode::slip) most = std::max(most, closed[entry.second].keeps_direction);
  return most;
}

// What slip keeps that turns (m/s): next to nothing, unless it has just begun.
double SlipInSteps::least_kept(std::size_t contact) const {
  const double slow = policy::slow_slip * turning_[contact];
  return speed_[contact] < 2 * slow && kept(contact) > 0.5 * slow ? slow : slowest_slip;
}

// By how much slip has turned less because it has kept its direction (m/s).
double SlipInSteps::turned(std::size_t contact, const ContactRows& rows) const {
  const Contact& c = world_->closed()[contact];
  return c.keeps_direction * norm(rows.slip[contact] - c.direction);
}

bool SlipInSteps::kept_too_much() const {
  if (step_ > 0) return false;
  const ContactRows& rows = world_->closed_rows();
  const std::span<const Contact> closed = world_->closed();
  for (std::size_t i = 0; i < closed.size(); ++i)
    if (closed[i].mode == Contact::Mode::slip && turned(i, rows) > policy::most_turned &&
        closed[i].keeps_direction > least_kept(i))
      return true;
  return false;
}

void SlipInSteps::keep_less() {
  std::vector<Contact> all = world_->closed_copy();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].mode == Contact::Mode::slip) all[i].keeps_direction = std::min(all[i].keeps_direction, least_kept(i));
  world_->close(std::move(all));
}

// The time (s) in which the slip velocity of a contact changes by its own size, at its present rate; for slip too slow to be
// followed, by `creeping`. In a longer adaptive step slip can end, or turn round, without being seen at the end of any stage.
double SlipInSteps::change_time(std::size_t contact) const {
  const ContactRows& rows = world_->closed_rows();
  double v[2] = {}, a[2] = {};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t row = 3 * contact + k + 1;
    v[k] = rows.velocity[row], a[k] = rows.acceleration[row];
    for (const std::size_t j : rows.of_group(rows.groups[rows.group_of[contact]]))
      for (std::size_t i = 0; i < 3; ++i) a[k] += rows.mobility(row, 3 * j + i) * rows.forces[3 * j + i];
  }
  return std::max(std::hypot(v[0], v[1]), policy::creeping) / std::hypot(a[0], a[1]);
}

}  // namespace momentree
