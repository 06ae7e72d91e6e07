// Contacts before a run begins: those that it will close, and those that were closed in the run that it continues.
#include <algorithm>
#include <cmath>

#include <momentree/simulate/contacts_impl.hpp>
#include <momentree/simulate/overlap.hpp>

namespace momentree {

namespace {

constexpr std::size_t most_pending = 64;  // points of an island: its dense equations are solved once for the start

}  // namespace

int pair_of_colliders(const Model& model, int one, int other) {
  const auto plane = [&](int collider) { return model.colliders()[static_cast<std::size_t>(collider)].plane; };
  const bool swap = plane(one) || (!plane(other) && other < one);
  constexpr int stride = static_cast<int>(most_colliders);
  return swap ? other * stride + one : one * stride + other;
}

int pair_of_cable(int spring) { return static_cast<int>(most_colliders * most_colliders) + spring; }

bool Contacts::has_pending() const {
  const std::span<const Contact> closed = world_->tree_.contacts();
  return std::any_of(closed.begin(), closed.end(), [](const Contact& c) { return c.pending; });
}

void Contacts::open_pending() {
  if (has_pending()) set({});
}

void Contacts::find_pending() {
  if (!any()) return;
  set({});
  // Counts of a run do not include this.
  const auto count = evaluate_->count;
  const auto seconds = evaluate_->seconds;
  (*evaluate_)(world_->state_);
  std::vector<Contact> pending, chosen;
  if (!overlap())
    for (const std::vector<Contact>& island : by_island(touching())) {
      if (island.size() > most_pending || approach_each_other(island) || !choose(island, chosen)) continue;
      for (Contact& c : chosen) c.pending = true;
      pending.insert(pending.end(), chosen.begin(), chosen.end());
    }
  set(std::move(pending));
  (*evaluate_)(world_->state_);
  evaluate_->count = count, evaluate_->seconds = seconds;
}

bool Contacts::approach_each_other(const std::vector<Contact>& contacts) {
  locate_bodies(world_->tree_, world_->state_, world_->workspace_);
  place_contacts(world_->tree_, world_->workspace_, contacts, rows_);
  const double slow = slow_approach();
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (rows_.velocity[3 * i] < -slow) return true;
  return false;
}

double Contacts::slow_approach() const {
  double fastest = 1;
  for (const BodyMotion& m : world_->motions()) fastest = std::max(fastest, norm(m.linear));
  return no_approach * fastest;
}

void Contacts::take(const std::vector<Contact>& described) {
  if (!any()) return;
  std::vector<Contact> closed;
  for (const Contact& given : described) {
    const Pair& pair = pairs_[static_cast<std::size_t>(given.pair)];
    if (pair.law.off || handling(pair) != Handling::located) continue;
    if (std::any_of(closed.begin(), closed.end(), [&](const Contact& c) { return same_contact(c, given); })) continue;
    if (pair.cable >= 0 && !can_be_taut(static_cast<std::size_t>(pair.cable))) continue;
    found_candidates_.clear();
    candidates(pair, touching_within * pair.size(*this), found_candidates_);
    const auto same = [&](const contact::Candidate& found) { return found.id == given.id; };
    const auto found = std::find_if(found_candidates_.begin(), found_candidates_.end(), same);
    if (found == found_candidates_.end()) continue;
    Contact c = contact_of(pair, given.pair, *found);
    c.mode = given.mode, c.direction = given.direction, c.keeps_direction = given.keeps_direction, c.settles = given.settles;
    closed.push_back(c);
  }
  set(std::move(closed));
  (*evaluate_)(world_->state_);
}

bool Contacts::can_go_on() {
  const std::span<const Contact> closed = world_->tree_.contacts();
  if (closed.empty() || has_pending() || overlap()) return false;
  world_->evaluate();
  const ContactRows& rows = world_->workspace_.contacts->rows;
  const double slow = slow_approach();
  for (std::size_t i = 0; i < closed.size(); ++i) {
    const double size = pairs_[static_cast<std::size_t>(closed[i].pair)].size(*this);
    const double* const v = rows.velocity.data() + 3 * i;
    if (std::fabs(rows.touches[i].gap) > touching_within * size || std::fabs(v[0]) > slow) return false;
    if (closed[i].mode == Contact::Mode::stick && std::hypot(v[1], v[2]) > slow) return false;
  }
  return excess_of_forces() <= rounding;
}

}  // namespace momentree
