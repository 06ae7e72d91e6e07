// Contacts that are stepped through: of which bodies, and the points that they have reached.
#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/contact/distance.hpp>
#include <momentree/simulate/contacts.hpp>

namespace momentree {

Contacts::Handling Contacts::handling(const Pair& pair) const {
  const bool a = is_stepped(pair.a), b = is_stepped(pair.b);
  if (!a && !b) return Handling::located;
  return (a || pair.a < 0) && (b || pair.b < 0) ? Handling::stepped : Handling::between;
}

void Contacts::set_stepped(std::vector<bool> bodies) {
  stepped_ = std::move(bodies);
  const std::span<const Contact> closed = world_->tree_.contacts();
  std::vector<Contact> stay;
  for (const Contact& c : closed)
    if (!is_stepped(c.a) && !is_stepped(c.b)) stay.push_back(c);
  if (stay.size() != closed.size()) set(std::move(stay));
}

void Contacts::join_touching(Islands& islands) {
  for (const Contact& c : world_->tree_.contacts()) islands.join(c.a, c.b);
  for (const Contact& c : touching()) islands.join(c.a, c.b);
}

std::vector<int> Contacts::touching_bodies() {
  std::vector<int> bodies;
  for (const Contact& c : touching()) bodies.push_back(c.a), bodies.push_back(c.b);
  return bodies;
}

std::vector<int> Contacts::touched_by_stepped() {
  std::vector<int> bodies;
  if (stepped_.empty()) return bodies;
  for (const int i : near_pairs(0, policy::touching_within)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    const double touching = 2 * policy::touching_within * pair.size(*this);
    if (handling(pair) != Handling::between || apart(pair) > touching) continue;
    if (!(gap_of(i, looked_within(pair)).value < touching)) continue;
    bodies.push_back(pair.a), bodies.push_back(pair.b);
  }
  return bodies;
}

std::vector<int> Contacts::slowest() const {
  const std::span<const Contact> closed = world_->tree_.contacts();
  std::size_t slowest = 0;
  const auto speed = [&](std::size_t i) {
    return closed[i].mode == Contact::Mode::slip ? norm(slip_velocity(static_cast<int>(i))) : HUGE_VAL;
  };
  for (std::size_t i = 1; i < closed.size(); ++i)
    if (speed(i) < speed(slowest)) slowest = i;
  return {closed[slowest].a, closed[slowest].b};
}

std::vector<int> Contacts::most_loaded() const {
  const std::span<const Contact> closed = world_->tree_.contacts();
  const std::vector<double>& forces = world_->workspace_.contacts->rows.forces;
  if (forces.size() != 3 * closed.size()) return {};
  std::size_t worst = 0;
  const auto load = [&](std::size_t i) { return std::isfinite(forces[3 * i]) ? std::fabs(forces[3 * i]) : HUGE_VAL; };
  for (std::size_t i = 1; i < closed.size(); ++i)
    if (load(i) > load(worst)) worst = i;
  return {closed[worst].a, closed[worst].b};
}

double Contacts::limit_step(double h) {
  const double accelerated = norm(world_->model_.gravity()) * h;
  fast_.clear();
  for (const int i : near_pairs(h, 0)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (pair.cable >= 0 || pair.other->plane || (!stepped_.empty() && handling(pair) != Handling::stepped)) continue;
    const double speed = 2 * speed_bound(pair) + 2 * accelerated, distance = apart(pair);
    if (distance > speed * h) continue;
    const double safe = (2 * std::max(distance, 0.0) + margin_within(pair)) / speed;
    if (safe < policy::shortest_of_fast * h && !pair.other->field) fast_.push_back({i, centre_in_other(pair)});
    h = std::min(h, std::max(safe, policy::shortest_of_fast * h));
  }
  return h;
}

// The centre of the first solid of a pair in the frame of the body of the second one.
Vec3 Contacts::centre_in_other(const Pair& pair) const {
  const contact::Place a = place(pair.a), b = place(pair.b);
  return transpose_times(b.R, a.r + a.R * pair.one->solid.centre - b.r);
}

std::vector<Contacts::Passed> Contacts::passed() {
  constexpr int most_places = 60;
  std::vector<Passed> all;
  for (const Fast& fast : std::exchange(fast_, {})) {
    const Pair& pair = pairs_[static_cast<std::size_t>(fast.pair)];
    if (is_gone(pair.a) || is_gone(pair.b)) continue;
    const contact::Place a = place(pair.a), b = place(pair.b);
    const Vec3 back = b.R * (fast.from - centre_in_other(pair));
    if (norm(back) <= margin_within(pair)) continue;
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
                     margin_within(pair) / (2 * speed_bound(pair) * policy::shortest_of_fast)});
  }
  return all;
}

double Contacts::fastest() const {
  double most = 0;
  for (const Collider& collider : world_->model_.colliders()) {
    if (collider.plane || collider.body == ground || !world_->alive(collider.body)) continue;
    if (!stepped_.empty() && !is_stepped(collider.body.index)) continue;
    const contact::Place at = place(collider.body.index);
    most = std::max(most, norm(at.v + cross(at.w, at.R * collider.solid.centre)) + norm(at.w) * collider.solid.reach);
  }
  for (std::size_t s = 0; s < world_->model_.springs().size(); ++s) {
    if (!can_be_taut(s)) continue;
    const Spring& cable = world_->model_.springs()[s];
    for (const SpringEnd* end : {&cable.from, &cable.to}) {
      const contact::Place at = place(end->body.index);
      most = std::max(most, norm(at.v + cross(at.w, at.R * end->point)));
    }
  }
  return most;
}

void Contacts::join_near(double within, Islands& islands) const {
  for (const int i : near_pairs(0, within)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (pair.b >= 0 && apart(pair) <= within) islands.join(pair.a, pair.b);
  }
}

void Contacts::add_near(double within, std::vector<Contact>& out, const std::vector<bool>& stays) const {
  for (const int i : near_pairs(0, within)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (!stays.empty() && (stays[static_cast<std::size_t>(pair.a)] || (pair.b >= 0 && stays[static_cast<std::size_t>(pair.b)])))
      continue;
    if (apart(pair) > within || (!stepped_.empty() && handling(pair) != Handling::stepped)) continue;
    found_candidates_.clear();
    if (pair.cable < 0 && !pair.other->plane && !pair.one->solid.faces.empty() && !pair.other->solid.faces.empty())
      overlap_.find(pair.one->solid, place(pair.a), pair.other->solid, place(pair.b), within, found_candidates_);
    else
      candidates(pair, within, found_candidates_);
    for (const contact::Candidate& found : found_candidates_) out.push_back(contact_of(pair, i, found));
  }
}

}  // namespace momentree
