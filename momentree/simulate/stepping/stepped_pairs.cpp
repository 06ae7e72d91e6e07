#include <momentree/simulate/stepping/stepped_pairs.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

SteppedPairs::Handling SteppedPairs::handling(const ContactPair& pair) const {
  const bool a = holds(pair.a), b = holds(pair.b);
  if (!a && !b) return Handling::located;
  return (a || pair.a < 0) && (b || pair.b < 0) ? Handling::stepped : Handling::between;
}

void SteppedPairs::set(std::vector<bool> bodies) {
  bodies_ = std::move(bodies);
  std::vector<Contact> stay;
  for (const Contact& c : world_->closed())
    if (!holds(c.a) && !holds(c.b)) stay.push_back(c);
  if (stay.size() != world_->closed().size()) world_->close(std::move(stay));
}

std::vector<Contact> SteppedPairs::touching(double open, bool all) const {
  std::vector<Contact> found;
  for (const int i : pairs_->near(0, std::max(open, policy::touching_within))) {
    const ContactPair& pair = (*pairs_)[i];
    const bool steps = all || !is_located(i);
    const double within = steps ? open : policy::touching_within * pairs_->size(pair);
    if (!(steps && open == 0) && !(pairs_->apart(pair) > within)) pairs_->add(i, within, found);
  }
  return found;
}

void SteppedPairs::join_touching(Islands& islands) const {
  for (const Contact& c : world_->closed()) islands.join(c.a, c.b);
  for (const Contact& c : touching()) islands.join(c.a, c.b);
}

std::vector<int> SteppedPairs::touched() const {
  std::vector<int> bodies;
  if (!any()) return bodies;
  for (const int i : pairs_->near(0, policy::touching_within)) {
    const ContactPair& pair = (*pairs_)[i];
    const double touching = 2 * policy::touching_within * pairs_->size(pair);
    if (handling(pair) != Handling::between || pairs_->apart(pair) > touching) continue;
    if (!(pairs_->gap(i, ContactPairs::looked_within(pair)).value < touching)) continue;
    bodies.push_back(pair.a), bodies.push_back(pair.b);
  }
  return bodies;
}

double SteppedPairs::limit_step(double h) {
  const double accelerated = world_->gravity() * h;
  fast_.clear();
  for (const int i : pairs_->near(h, 0)) {
    const ContactPair& pair = (*pairs_)[i];
    if (pair.cable >= 0 || pair.other->plane || is_left_out(pair)) continue;
    const double speed = 2 * pairs_->speed_bound(pair) + 2 * accelerated, distance = pairs_->apart(pair);
    if (distance > speed * h) continue;
    const double safe = (2 * std::max(distance, 0.0) + pairs_->margin(pair)) / speed;
    if (safe < policy::shortest_of_fast * h && !pair.other->field) fast_.push_back({i, centre_in_other(pair)});
    h = std::min(h, std::max(safe, policy::shortest_of_fast * h));
  }
  return h;
}

// The centre of the first solid of a pair in the frame of the body of the second one.
Vec3 SteppedPairs::centre_in_other(const ContactPair& pair) const {
  const contact::Place a = world_->place(pair.a), b = world_->place(pair.b);
  return transpose_times(b.R, a.r + a.R * pair.one->solid.centre - b.r);
}

std::vector<SteppedPairs::Passed> SteppedPairs::passed() {
  constexpr int most_places = 60;
  std::vector<Passed> all;
  for (const Fast& fast : std::exchange(fast_, {})) {
    const ContactPair& pair = (*pairs_)[fast.pair];
    if (world_->is_gone(pair.a) || world_->is_gone(pair.b)) continue;
    const contact::Place a = world_->place(pair.a), b = world_->place(pair.b);
    const Vec3 back = b.R * (fast.from - centre_in_other(pair));
    if (norm(back) <= pairs_->margin(pair)) continue;
    // At a part of the path, from its end to its start; the distance of convex solids is a convex function of it.
    const auto distance = [&](double part) {
      contact::Place there = a;
      there.r += part * back;
      return contact::distance(pair.one->solid, there, pair.other->solid, b).distance;
    };
    if (!(distance(0) > 0) || !(distance(1) > 0)) continue;
    constexpr double golden = 0.6180339887498949;
    double low = 0, high = 1, one = 1 - golden, other = golden, at_one = distance(one), at_other = distance(other);
    for (int k = 0; k < most_places && at_one > 0 && at_other > 0; ++k) {
      if (at_one < at_other)
        high = other, other = one, at_other = at_one, one = high - golden * (high - low), at_one = distance(one);
      else
        low = one, one = other, at_one = at_other, other = low + golden * (high - low), at_other = distance(other);
    }
    if (std::min(at_one, at_other) <= 0)
      all.push_back({pair.a, pair.b, a.r + a.R * pair.one->solid.centre + (at_one <= 0 ? one : other) * back, normalized(back),
                     pairs_->margin(pair) / (2 * pairs_->speed_bound(pair) * policy::shortest_of_fast)});
  }
  return all;
}

double SteppedPairs::fastest() const {
  double most = 0;
  for (const Collider& collider : world_->model().colliders()) {
    const int body = collider.body.index;
    if (collider.plane || body < 0 || world_->is_gone(body) || (any() && !holds(body))) continue;
    const contact::Place at = world_->place(body);
    most = std::max(most, norm(at.v + cross(at.w, at.R * collider.solid.centre)) + norm(at.w) * collider.solid.reach);
  }
  for (std::size_t s = 0; s < world_->model().springs().size(); ++s) {
    if (!world_->can_be_taut(static_cast<int>(s))) continue;
    const Spring& cable = world_->model().springs()[s];
    for (const SpringEnd* end : {&cable.from, &cable.to}) {
      const contact::Place at = world_->place(end->body.index);
      most = std::max(most, norm(at.v + cross(at.w, at.R * end->point)));
    }
  }
  return most;
}

void SteppedPairs::join_near(double within, Islands& islands) const {
  for (const int i : pairs_->near(0, within)) {
    const ContactPair& pair = (*pairs_)[i];
    if (pair.b >= 0 && pairs_->apart(pair) <= within) islands.join(pair.a, pair.b);
  }
}

void SteppedPairs::add_near(double within, std::vector<Contact>& out, const std::vector<bool>& stays) const {
  const auto is_still = [&](int body) { return body >= 0 && !stays.empty() && stays[static_cast<std::size_t>(body)]; };
  for (const int i : pairs_->near(0, within)) {
    const ContactPair& pair = (*pairs_)[i];
    if (!is_still(pair.a) && !is_still(pair.b) && !is_left_out(pair) && pairs_->apart(pair) <= within)
      pairs_->add_overlapping(i, within, out);
  }
}

}  // namespace momentree
