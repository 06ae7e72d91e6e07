// Contacts before a run begins: those that it will close, and those that were closed in the run that it continues.
#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/simulate/contacts_impl.hpp>
#include <momentree/simulate/overlap.hpp>

namespace momentree {

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

std::vector<Contact> Contacts::closed_ones() const {
  const std::span<const Contact> closed = world_->tree_.contacts();
  return has_pending() ? std::vector<Contact>() : std::vector<Contact>(closed.begin(), closed.end());
}

void Contacts::set_former(std::vector<Contact> closed) {
  if (!closed.empty()) world_->former_contacts_ = std::move(closed);
}

void Contacts::open_pending() {
  if (has_pending()) set({});
  if (!has_former()) return;
  std::vector<Contact>& former = world_->former_contacts_;
  std::erase_if(former, [this](const Contact& c) { return is_gone(c.a) || is_gone(c.b); });
  if (stay_together(former)) set(std::exchange(former, {}));
}

// True if features still touch, and move neither towards nor away from each other, nor along each other where they stick.
bool Contacts::stay_together(const std::vector<Contact>& contacts) {
  locate_bodies(world_->tree_, world_->state_, world_->workspace_);
  place_contacts(world_->tree_, world_->workspace_, contacts, rows_);
  const double slow = slow_approach();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double size = pairs_[static_cast<std::size_t>(contacts[i].pair)].size(*this);
    const double* const v = rows_.velocity.data() + 3 * i;
    if (std::fabs(rows_.touches[i].gap) > policy::touching_within * size || std::fabs(v[0]) > slow) return false;
    if (contacts[i].mode == Contact::Mode::stick && std::hypot(v[1], v[2]) > slow) return false;
  }
  return true;
}

// All contacts that touch at present, with those of bodies that are stepped through, which leave small gaps and overlaps.
std::vector<Contact> Contacts::touching_in_steps(bool method_steps) {
  std::vector<Contact> all;
  const double step = usual_step();
  const double open = std::max(policy::step_touch, norm(world_->model_.gravity()) * step * step);
  for (const int i : near_pairs(0, open)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    const bool steps = method_steps || handling(pair) != Handling::located;
    const double within = steps ? open : policy::touching_within * pair.size(*this);
    if (apart(pair) > within) continue;
    found_candidates_.clear();
    candidates(pair, within, found_candidates_);
    for (const contact::Candidate& found : found_candidates_) all.push_back(contact_of(pair, i, found));
  }
  return all;
}

// Which contacts of an island will close. False: no forces were found, or bodies hit each other.
bool Contacts::choose_pending(const std::vector<Contact>& touching, bool method_steps, std::vector<Contact>& chosen) {
  if (touching.size() > policy::most_pending) return false;
  const bool steps = method_steps || std::any_of(touching.begin(), touching.end(), [this](const Contact& c) {
                       return handling(pairs_[static_cast<std::size_t>(c.pair)]) != Handling::located;
                     });
  const double step = usual_step();
  if (steps)
    slowest_approach_ = std::max(policy::step_approach, norm(world_->model_.gravity()) * step), slowest_ = policy::step_slip;
  const bool found = !approach_each_other(touching) && choose(touching, chosen);
  slowest_approach_ = 0, slowest_ = slowest_slip;
  return found;
}

void Contacts::find_pending(bool method_steps) {
  if (!any()) return;
  set({});
  // Counts of a run do not include this.
  const auto count = evaluate_->count;
  const auto seconds = evaluate_->seconds;
  (*evaluate_)(world_->state_);
  std::vector<Contact> pending, chosen;
  const bool steps = method_steps || !stepped_.empty();
  const std::optional<Overlap> worst = overlap_of_all();
  if (!worst || (steps && worst->depth <= left_by_steps))
    for (const std::vector<Contact>& island : by_island(touching_in_steps(method_steps))) {
      if (!choose_pending(island, method_steps, chosen)) continue;
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
  return std::max(slowest_approach_, policy::no_approach * fastest);
}

// Contacts of a document with the features that they have in this world, without those that do not touch.
std::vector<Contact> Contacts::placed_again(const std::vector<Contact>& described) {
  std::vector<Contact> all;
  for (const Contact& given : described) {
    const Pair& pair = pairs_[static_cast<std::size_t>(given.pair)];
    if (pair.law.off || handling(pair) != Handling::located) continue;
    if (std::any_of(all.begin(), all.end(), [&](const Contact& c) { return same_contact(c, given); })) continue;
    if (pair.cable >= 0 && !can_be_taut(static_cast<std::size_t>(pair.cable))) continue;
    found_candidates_.clear();
    candidates(pair, policy::touching_within * pair.size(*this), found_candidates_);
    const auto same = [&](const contact::Candidate& found) { return found.id == given.id; };
    const auto found = std::find_if(found_candidates_.begin(), found_candidates_.end(), same);
    if (found == found_candidates_.end()) continue;
    Contact c = contact_of(pair, given.pair, *found);
    c.mode = given.mode, c.direction = given.direction, c.keeps_direction = given.keeps_direction, c.settles = given.settles;
    c.friction = friction_of(c);
    all.push_back(c);
  }
  return all;
}

void Contacts::close_from_document(const Forest& forest) {
  if (!any()) return;
  if (!forest.contacts.empty()) set(placed_again(forest.contacts));
  (*evaluate_)(world_->state_);
  if (!forest.former_contacts.empty()) world_->former_contacts_ = placed_again(forest.former_contacts);
}

double Contacts::excess_of_closed() {
  const std::vector<Contact> closed = closed_ones();
  if (closed.empty()) return -1;
  if (overlap()) return std::numeric_limits<double>::max();
  world_->evaluate();
  if (!stay_together(closed)) return std::numeric_limits<double>::max();
  const double excess = excess_of_forces();
  return excess <= policy::rounding ? -1 : excess;
}

}  // namespace momentree
