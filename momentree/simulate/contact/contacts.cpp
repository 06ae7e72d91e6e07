#include <momentree/simulate/contact/contacts.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/simulate/contact/closed_contacts.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

Contacts::Contacts(const ContactGeometry& geometry, double tolerance, contact::Simultaneous how, double step)
    : watches(geometry.world, geometry.pairs, geometry.stepped, step),
      geometry_(&geometry),
      events_(geometry.world, geometry.pairs),
      choice_(geometry.world, geometry.pairs, step),
      impacts_(geometry.world, geometry.pairs, events_, choice_, tolerance, policy::usual_step(step), how) {}

std::optional<Contacts::Unresolved> Contacts::resolve(std::vector<Event>& events) {
  const ContactWorld& world = geometry_->world;
  const std::vector<Contact> before = take_former();
  world.open();
  impacts_.forget_bounces(), choice_.forget_jams();
  geometry_->overlaps.forget_apart();
  const std::size_t first = events.size();
  world.evaluate();
  if (const std::optional<Overlap> worst = geometry_->overlaps.of_located())
    return Unresolved{worst->text(), {worst->a, worst->b}, worst->depth <= left_by_steps};
  std::vector<std::vector<Contact>> islands = world.by_island(geometry_->stepped.touching());
  for (const std::vector<Contact>& touching : islands)
    if (std::optional<Unresolved> failed = strike(touching, events)) return failed;
  StoppedMotion stopped(world, events_);
  std::map<int, Vec3> impulses;
  std::optional<Unresolved> failed = close(std::move(islands), before, stopped, impulses);
  if (!failed) {
    const std::size_t changes = events.size();
    report_changes(before, first, impulses, events);
    stopped.join(events, first, changes);
  }
  lost_ += stopped.lost();
  return failed;
}

// The contacts that were closed, those that slip with their present direction.
std::vector<Contact> Contacts::take_former() {
  const ContactWorld& world = geometry_->world;
  std::vector<Contact> all = std::exchange(world.former(), {});
  if (all.empty()) {
    all = world.closed_copy();
    const std::vector<Vec3>& slips = watches.slip.direction();
    for (std::size_t i = 0; i < std::min(all.size(), slips.size()); ++i)
      if (all[i].keeps_direction == 0 && !(slips[i] == Vec3{})) all[i].direction = slips[i];
  }
  watches.slip.forget_directions();
  std::erase_if(all, [&](const Contact& c) { return world.is_gone(c); });
  return all;
}

// Impacts of an island.
std::optional<Contacts::Unresolved> Contacts::strike(const std::vector<Contact>& touching, std::vector<Event>& events) {
  std::string failure;
  if (std::ranges::any_of(touching, [this](const Contact& c) { return geometry_->pairs.law(c.pair).has_moments(); }))
    failure = "torsional or rolling friction";
  else if (touching.size() > policy::most_points)
    failure = std::to_string(touching.size()) + " points touch at once";
  else
    failure = impacts_.strike(touching, slow(), events);
  if (failure.empty()) return std::nullopt;
  return Unresolved{std::move(failure), {touching.front().a, touching.front().b}};
}

std::vector<double> Contacts::rigid_pushes() const {
  const ContactWorld& world = geometry_->world;
  std::vector<double> forces(static_cast<std::size_t>(world.tree().nv()), 0.0);
  world.evaluate();
  const std::vector<Contact> contacts = geometry_->stepped.touching();
  if (contacts.empty()) return forces;
  ContactRows rows;
  world.place(contacts, rows);
  world.find_mobility(contacts, rows);
  world.evaluate();
  const double slow_speed = slow_approach(world, slow());
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (const auto& [body, sign] : {std::pair{contacts[i].a, 1.0}, {contacts[i].b, -1.0}})
      if (body >= 0 && rows.velocity[3 * i] < -slow_speed && rows.mobility(3 * i, 3 * i) == 0)
        add_contact_row(world.tree(), world.q(), world.workspace(), body, rows.touches[i].normal, rows.touches[i].point, sign,
                        forces.data());
  return forces;
}

// Which contacts are closed from now on. `before`: those that were closed. `impulses`: with which pairs came to rest.
std::optional<Contacts::Unresolved> Contacts::close(std::vector<std::vector<Contact>> islands, const std::vector<Contact>& before,
                                                    StoppedMotion& stopped, std::map<int, Vec3>& impulses) {
  const ContactWorld& world = geometry_->world;
  const ContactsByPair before_by_pair(before);
  for (int left = policy::most_choices;; --left) {
    std::vector<Contact> closed;
    for (std::vector<Contact>& touching : islands)
      if (!choose(touching, before, before_by_pair, stopped, closed))
        return Unresolved{"no forces were found for " + std::to_string(touching.size()) + " points of contact at once",
                          {touching.front().a, touching.front().b}};
    for (Contact& c : closed) {
      const std::optional<double> now = impacts_.settles(c.pair);
      const auto then = before_by_pair.of(c.pair);
      const double known = then.empty() ? 0 : before[then.front().second].settles;  // negative: it was closed, and stays so
      if (now && known >= 0)
        c.settles = *now;
      else if (known > world.time())
        c.settles = known;
    }
    for (const auto& [pair, impulse] : stopped.stop(closed, slow())) impulses[pair] += impulse;
    world.close(closed);
    world.evaluate();
    const ForceExcess lacking = closed.empty() ? ForceExcess{} : force_excess(world);
    if (!(lacking.excess > 0)) return std::nullopt;
    if (left == 0 && lacking.excess <= policy::most_lacking) return std::nullopt;
    world.open();
    if (left == 0)
      return Unresolved{"no forces were found that obey the law of contact",
                        {closed[lacking.contact].a, closed[lacking.contact].b}};
    world.evaluate();  // what is stopped leaves others with another slip, or may begin to slip anew
  }
}

// Which contacts of an island are closed from now on, which are appended. False: no forces were found.
bool Contacts::choose(std::vector<Contact>& touching, const std::vector<Contact>& before, const ContactsByPair& before_by_pair,
                      StoppedMotion& stopped, std::vector<Contact>& closed) {
  if (watches.slow_slip() > slowest_slip) stop_creeping(touching, stopped);
  for (Contact& c : touching)
    for (const ContactsByPair::Entry& entry : before_by_pair.of(c.pair)) {
      const Contact& then = before[entry.second];
      if (!same_contact(then, c)) continue;
      // It still begins to slip, or is at the limit.
      if (then.keeps_direction > 0) c.direction = then.direction, c.keeps_direction = then.keeps_direction;
      break;
    }
  std::vector<Contact> chosen;
  if (!choice_.choose(touching, slow(), chosen)) return false;
  closed.insert(closed.end(), chosen.begin(), chosen.end());
  return true;
}

// Stops the slip of contacts that creep, as if they stuck.
void Contacts::stop_creeping(std::vector<Contact> contacts, StoppedMotion& stopped) {
  const ContactWorld& world = geometry_->world;
  const double slow_slip = watches.slow_slip();
  ContactRows rows;
  world.place(contacts, rows);
  std::vector<Contact> staying;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (!(rows.velocity[3 * i] > slow_slip)) staying.push_back(contacts[i]);
  contacts = std::move(staying);
  world.place(contacts, rows);
  // All points of a pair stop slipping at one instant, except one about which it pivots. If one were stopped shortly before the
  // others, these would slip on in another direction.
  constexpr double shortly = 10;  // times the speed below which slip is stopped: they decelerate alike
  std::map<int, double> slowest;  // by pair
  const auto slip = [&](std::size_t i) { return std::hypot(rows.velocity[3 * i + 1], rows.velocity[3 * i + 2]); };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    double& least = slowest.emplace(contacts[i].pair, HUGE_VAL).first->second;
    if (slip(i) > slowest_slip) least = std::min(least, slip(i));
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const bool ends = slowest[contacts[i].pair] < slow_slip, creeps = slip(i) < (ends ? shortly : 1) * slow_slip;
    contacts[i].mode = creeps ? Contact::Mode::stick : Contact::Mode::smooth;
  }
  stopped.stop(contacts, slow());
  world.evaluate();
}

// Events of pairs whose contacts closed, opened, began to slip or to stick; slip that turns back, or that jams, begins anew. A
// contact that bounces too low to be followed closes when these bounces end. `first`: of the events of this instant. `impulses`:
// with which pairs came to rest.
void Contacts::report_changes(const std::vector<Contact>& before, std::size_t first, const std::map<int, Vec3>& impulses,
                              std::vector<Event>& events) const {
  const ContactWorld& world = geometry_->world;
  enum class Now : unsigned char { open, still, slips };
  struct Change {
    Now from = Now::open, to = Now::open;
  };
  std::map<int, Change> pairs;
  const auto note = [](Now& now, const Contact& c, bool counts) {
    if (counts) now = std::max(now, c.mode == Contact::Mode::slip ? Now::slips : Now::still);
  };
  for (const Contact& c : before) note(pairs[c.pair].from, c, c.settles < 0);
  const std::vector<Contact> closed = world.closed_copy();
  for (const Contact& c : closed) note(pairs[c.pair].to, c, c.settles < 0);
  const ContactsByPair before_by_pair(before), closed_by_pair(closed);
  for (const Contact& c : closed)
    for (const auto& entry : before_by_pair.of(c.pair)) {
      const Contact& then = before[entry.second];
      if (c.keeps_direction > 0 && same_contact(then, c) && dot(then.direction, c.direction) < 0) pairs[c.pair].from = Now::still;
    }
  for (auto& [pair, change] : pairs)
    if (change.to == Now::slips && choice_.jams(pair)) change.from = Now::still;
  for (const auto& [pair, change] : pairs) {
    if (change.from == change.to) continue;
    const char* const what = change.to == Now::open     ? "lift"
                             : change.to == Now::slips  ? "slip"
                             : change.from == Now::open ? "rest"
                                                        : "stick";
    const ContactPair& changed = geometry_->pairs[pair];
    if (changed.cable >= 0 && !world.can_be_taut(changed.cable)) continue;  // it broke
    const auto is_known = [&](const Event& event) { return event.contact.cable == changed.law_name; };
    if (changed.cable >= 0 && change.to != Now::open &&
        std::any_of(events.begin() + static_cast<std::ptrdiff_t>(first), events.end(), is_known))
      continue;  // the impact by which it became taut
    const bool opened = change.to == Now::open;
    std::vector<Contact> of;
    for (const auto& entry : (opened ? before_by_pair : closed_by_pair).of(pair))
      of.push_back((opened ? before : closed)[entry.second]);
    Event event = events_.begin(what, pair);
    ContactRows rows;
    world.place(of, rows);
    events_.locate(event, of, rows, std::vector<double>(of.size(), 1.0), pair);
    if (!opened && choice_.jams(pair)) {
      event.reason = "no finite force lets it slip on (Painlevé's paradox)";
      if (const auto found = impulses.find(pair); found != impulses.end()) event.contact.impulse = found->second;
    }
    events.push_back(std::move(event));
  }
}

}  // namespace momentree
