#include <momentree/simulate/contact/contact_impacts.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

std::string ContactImpacts::strike(const std::vector<Contact>& touching, const SlowMotion& slow, std::vector<Event>& events) {
  std::string failure;
  for (int k = 0; k < policy::most_impacts; ++k) {
    if (!strike_once(touching, slow, events, failure)) break;
    world_->evaluate();
  }
  return failure;
}

std::optional<double> ContactImpacts::settles(int pair) const {
  const auto known = std::ranges::find(settling_, pair, &std::pair<int, double>::first);
  return known == settling_.end() ? std::nullopt : std::optional(known->second);
}

// Normal accelerations of contacts that are placed, of which those that hit each other are open: what rests otherwise may press
// them together, such as a ball that rolls on the floor along a wall.
std::vector<double> ContactImpacts::accelerations_on_others(const std::vector<Contact>& contacts, const SlowMotion& slow,
                                                            double least) {
  std::vector<double> all(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) all[i] = rows_.acceleration[3 * i];
  std::vector<std::size_t> others;
  std::vector<Contact> resting;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (std::fabs(rows_.velocity[3 * i]) <= least) others.push_back(i), resting.push_back(contacts[i]);
  if (others.empty() || others.size() == contacts.size()) return all;
  const std::vector<double>* const r = choice_->forces(resting, rows_.some(others), slow);
  if (r == nullptr) return all;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < others.size(); ++j)
      for (std::size_t k = 0; k < 3; ++k) all[i] += rows_.mobility(3 * i, 3 * others[j] + k) * (*r)[3 * j + k];
  return all;
}

// Zero for flights that are too low or too short to be followed: all further bounces of this contact, in closed form. Where next
// to nothing is lost they would be countless; without losses they would never end, and the contact closes at once.
double ContactImpacts::restitution(const Contact& c, double approach, double acceleration) {
  const ContactPair& pair = (*pairs_)[c.pair];
  const double e = pair.law.restitution, v = -e * approach, a = -acceleration;
  if (!(v > 0) || !(a > 0)) return e;
  const double height = v * v / (2 * a), flight = 2 * v / a;
  const double shortest = e > policy::nearly_elastic ? policy::shortest_flight * usual_step_ : 8 * tolerance_ * (1 - e);
  if (height > policy::resolved_flight * pairs_->size(pair) && flight > shortest) return e;
  const double ends = e < 1 ? world_->time() + flight / (1 - e) : 0;
  if (!(ends > world_->time() + tolerance_)) return 0;
  const auto known = std::ranges::find(settling_, c.pair, &std::pair<int, double>::first);
  if (known == settling_.end())
    settling_.emplace_back(c.pair, ends);
  else
    known->second = std::max(known->second, ends);
  return 0;
}

// One impact at all contacts. False if none of them approach.
bool ContactImpacts::strike_once(const std::vector<Contact>& contacts, const SlowMotion& slow, std::vector<Event>& events,
                                 std::string& failure) {
  world_->accelerate(contacts, rows_);
  const double least = slow_approach(*world_, slow);
  bool approaching = false;
  for (std::size_t i = 0; i < contacts.size(); ++i) approaching = approaching || rows_.velocity[3 * i] < -least;
  if (!approaching) return false;
  world_->find_mobility(contacts, rows_);
  const std::vector<double> accelerations = accelerations_on_others(contacts, slow, least);
  system_.resize(contacts.size());
  system_.A = rows_.matrix(), system_.b = rows_.velocity;
  restitution_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    system_.laws[i].friction = pairs_->law(contacts[i].pair).friction;
    restitution_[i] = restitution(contacts[i], rows_.velocity[3 * i], accelerations[i]);
  }
  const contact::ImpactResult result = law_.apply(system_, restitution_, simultaneous_);
  if (!result.solved) {
    failure = "no impulses were found that obey the law of impact";
    return false;
  }
  const ContactEvents::Impulses impulses = events_->impulses(contacts, rows_, system_.r);
  std::vector<double> weights(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) weights[i] = system_.r[3 * i];
  // One event for each pair of solids; the first one has the certificate of all.
  bool booked = false;
  for (const auto& [pair, impulse] : impulses.by_pair) {
    Event event = events_->begin("impact", pair);
    events_->locate(event, contacts, rows_, weights, pair);
    event.contact.impulse = impulse, event.contact.scaled = result.scale;
    event.contact.in_turn = simultaneous_ == contact::Simultaneous::in_turn || result.separated;
    if (!booked) {
      TopologyEditor editor(world_->world());
      editor.begin(event, "");
      events_->apply(impulses, rows_, system_.r, editor, event);
      editor.certify(event);
      booked = true;
    }
    events.push_back(std::move(event));
  }
  return booked;
}

}  // namespace momentree
