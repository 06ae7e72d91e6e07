#include <momentree/simulate/contact/contact_start.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/simulate/contact/closed_contacts.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

bool ContactsBetweenRuns::has_pending() const { return std::ranges::any_of(geometry_->world.closed(), &Contact::pending); }

std::vector<Contact> ContactsBetweenRuns::closed() const {
  return has_pending() ? std::vector<Contact>() : geometry_->world.closed_copy();
}

void ContactsBetweenRuns::set_former(std::vector<Contact> closed) const {
  if (!closed.empty()) geometry_->world.former() = std::move(closed);
}

void ContactsBetweenRuns::open_pending() {
  const ContactWorld& world = geometry_->world;
  if (has_pending()) world.open();
  if (!has_former()) return;
  std::vector<Contact>& former = world.former();
  std::erase_if(former, [&](const Contact& c) { return world.is_gone(c); });
  if (stay_together(former)) world.close(std::exchange(former, {}));
}

// True if features still touch, and move neither towards nor away from each other, nor along each other where they stick.
bool ContactsBetweenRuns::stay_together(const std::vector<Contact>& contacts) const {
  ContactRows rows;
  geometry_->world.place(contacts, rows);
  const double slow = slow_approach(geometry_->world, {});
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double size = geometry_->pairs.size(geometry_->pairs[contacts[i].pair]);
    const double* const v = rows.velocity.data() + 3 * i;
    if (std::fabs(rows.touches[i].gap) > policy::touching_within * size || std::fabs(v[0]) > slow) return false;
    if (contacts[i].mode == Contact::Mode::stick && std::hypot(v[1], v[2]) > slow) return false;
  }
  return true;
}

// Which contacts of an island will close. False: no forces were found, or bodies hit each other.
bool ContactsBetweenRuns::choose(const std::vector<Contact>& touching, bool method_steps, std::vector<Contact>& chosen) {
  if (touching.size() > policy::most_pending) return false;
  const ContactWorld& world = geometry_->world;
  SlowMotion slow;
  if (method_steps || std::ranges::any_of(touching, [&](const Contact& c) { return !geometry_->stepped.is_located(c.pair); }))
    slow = {policy::step_slip, std::max(policy::step_approach, world.gravity() * policy::usual_step(step_))};
  ContactRows rows;
  world.place(touching, rows);
  const double least = slow_approach(world, slow);
  for (std::size_t i = 0; i < touching.size(); ++i)
    if (rows.velocity[3 * i] < -least) return false;
  return choice_.choose(touching, slow, chosen);
}

void ContactsBetweenRuns::find_pending(bool method_steps) {
  if (!geometry_->pairs.any()) return;
  const ContactWorld& world = geometry_->world;
  world.open();
  // Counts of a run do not include this.
  Evaluator& evaluator = world.evaluator();
  const auto count = evaluator.count;
  const auto seconds = evaluator.seconds;
  world.evaluate();
  std::vector<Contact> pending, chosen;
  const bool steps = method_steps || geometry_->stepped.any();
  const std::optional<Overlap> worst = geometry_->overlaps.of_all();
  if (!worst || (steps && worst->depth <= left_by_steps)) {
    // Steps leave small gaps and overlaps.
    const double step = policy::usual_step(step_), open = std::max(policy::step_touch, world.gravity() * step * step);
    for (const std::vector<Contact>& island : world.by_island(geometry_->stepped.touching(open, method_steps))) {
      if (!choose(island, method_steps, chosen)) continue;
      for (Contact& c : chosen) c.pending = true;
      pending.insert(pending.end(), chosen.begin(), chosen.end());
    }
  }
  world.close(std::move(pending));
  world.evaluate();
  evaluator.count = count, evaluator.seconds = seconds;
}

// Contacts of a document with the features that they have in this world, without those that do not touch.
std::vector<Contact> ContactsBetweenRuns::placed_again(const std::vector<Contact>& described) const {
  std::vector<Contact> all;
  for (const Contact& given : described) {
    const ContactPair& pair = geometry_->pairs[given.pair];
    if (pair.law.off || !geometry_->stepped.is_located(given.pair)) continue;
    if (std::ranges::any_of(all, [&](const Contact& c) { return same_contact(c, given); })) continue;
    if (pair.cable >= 0 && !geometry_->world.can_be_taut(pair.cable)) continue;
    const auto& candidates = geometry_->pairs.candidates(pair, policy::touching_within * geometry_->pairs.size(pair));
    const auto found = std::ranges::find(candidates, given.id, &contact::Candidate::id);
    if (found == candidates.end()) continue;
    Contact c = geometry_->pairs.contact_of(given.pair, *found);
    c.mode = given.mode, c.direction = given.direction, c.keeps_direction = given.keeps_direction, c.settles = given.settles;
    c.friction = friction_of(pair.law, c);
    all.push_back(c);
  }
  return all;
}

void ContactsBetweenRuns::close_from_document(const Forest& forest) const {
  if (!geometry_->pairs.any()) return;
  const ContactWorld& world = geometry_->world;
  if (!forest.contacts.empty()) world.close(placed_again(forest.contacts));
  world.evaluate();
  if (!forest.former_contacts.empty()) world.former() = placed_again(forest.former_contacts);
}

double ContactsBetweenRuns::excess_of_closed() const {
  const std::vector<Contact> contacts = closed();
  if (contacts.empty()) return -1;
  if (geometry_->overlaps.of_located()) return std::numeric_limits<double>::max();
  static_cast<void>(geometry_->world.closed_rows());  // evaluates the state
  if (!stay_together(contacts)) return std::numeric_limits<double>::max();
  const double excess = force_excess(geometry_->world).excess;
  return excess <= policy::rounding ? -1 : excess;
}

}  // namespace momentree
