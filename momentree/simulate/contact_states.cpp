// What happens at an instant at which bodies touch: impacts, and the contacts that stay closed.
#include <algorithm>
#include <cmath>
#include <map>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/contacts_impl.hpp>
#include <momentree/simulate/topology_editor.hpp>

namespace momentree {

struct Contacts::Impulses {
  std::vector<double> generalised;  // packed as p
  std::vector<AppliedImpulse> on_bodies, on_ground;
  std::map<int, Vec3> by_pair;  // on its first body
};

// What happens to bodies that need no event of their own, such as the end of slow slip: part of another event of the instant.
struct Contacts::Settled {
  explicit Settled(World& world) : editor(world) {}
  TopologyEditor editor;
  Event event{};
  bool any = false;
};

ContactsByPair::ContactsByPair(std::span<const Contact> all) {
  for (std::size_t i = 0; i < all.size(); ++i) sorted_.emplace_back(all[i].pair, i);
  std::sort(sorted_.begin(), sorted_.end());
}

std::span<const ContactsByPair::Entry> ContactsByPair::of(int pair) const {
  const auto first = std::lower_bound(sorted_.begin(), sorted_.end(), Entry{pair, 0});
  return {first, std::partition_point(first, sorted_.end(), [&](const Entry& entry) { return entry.first == pair; })};
}

std::span<const ContactsByPair::Entry> Contacts::closed_of(int pair) const {
  const Tree& tree = world_->tree_;
  if (closed_by_pair_of_ != tree.revision())
    closed_by_pair_of_ = tree.revision(), closed_by_pair_ = ContactsByPair(tree.contacts());
  return closed_by_pair_.of(pair);
}

bool Contacts::is_closed(int pair, std::uint64_t id) const {
  const std::span<const ContactsByPair::Entry> closed = closed_of(pair);
  return std::any_of(closed.begin(), closed.end(),
                     [&](const auto& entry) { return world_->tree_.contacts()[entry.second].id == id; });
}

Event Contacts::begin_event(const char* what, int number) {
  Event event;
  event.time = world_->time(), event.name = event_name(what, number);
  event.mechanisms_before = event.mechanisms_after = world_->mechanism_names();
  event.before = event.after = world_->totals();
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  event.contact.one = name_of(pair.a), event.contact.other = name_of(pair.b);
  if (pair.cable >= 0) event.contact.cable = pair.law_name;
  return event;
}

// Point and normal of several contacts of one pair, each with a weight.
void Contacts::locate_event(Event& event, const std::vector<Contact>& contacts, const std::vector<double>& weights,
                            int pair) const {
  double total = 0;
  Vec3 point{}, normal{};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].pair != pair) continue;
    const double weight = weights[i] + 1e-300;
    const double sign = contacts[i].a == pairs_[static_cast<std::size_t>(pair)].a ? 1 : -1;
    total += weight, point += weight * rows_.touches[i].point, normal += sign * weight * rows_.touches[i].normal;
  }
  if (!(total > 0)) return;
  event.contact.point = (1 / total) * point;
  event.contact.normal = norm(normal) > 0 ? normalized(normal) : Vec3{};
}

// Normal accelerations of contacts that are placed, of which those that hit each other are open: what rests otherwise may press
// them together, such as a ball that rolls on the floor along a wall.
std::vector<double> Contacts::accelerations_on_others(const std::vector<Contact>& contacts, double slow) {
  std::vector<double> all(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) all[i] = rows_.acceleration[3 * i];
  std::vector<std::size_t> others;
  std::vector<Contact> resting;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (std::fabs(rows_.velocity[3 * i]) <= slow) others.push_back(i), resting.push_back(contacts[i]);
  if (others.empty() || others.size() == contacts.size()) return all;
  ContactRows rows = std::move(rows_);
  rows_ = rows.some(others);
  const bool solved = solve_states(resting);
  rows_ = std::move(rows);
  if (!solved) return all;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < others.size(); ++j)
      for (std::size_t k = 0; k < 3; ++k) all[i] += rows_.mobility(3 * i, 3 * others[j] + k) * system_.r[3 * j + k];
  return all;
}

// One impact at all contacts. False if none of them approach.
bool Contacts::impact(const std::vector<Contact>& contacts, std::vector<Event>& events, std::string& failure) {
  const Tree& tree = world_->tree_;
  const double* const q = world_->state_.q().data();
  Workspace<double>& workspace = world_->workspace_;
  accelerate(tree, world_->state_, workspace);
  locate_bodies(tree, world_->state_, workspace);
  place_contacts(tree, workspace, contacts, rows_);
  const double slow = slow_approach();
  bool approaching = false;
  for (std::size_t i = 0; i < contacts.size(); ++i) approaching = approaching || rows_.velocity[3 * i] < -slow;
  if (!approaching) return false;
  find_contact_accelerations(tree, q, workspace, contacts, rows_);
  find_contact_mobility(tree, q, workspace, contacts, rows_);
  forget_evaluation_with_loops();
  const std::vector<double> approach = accelerations_on_others(contacts, slow);
  system_.resize(contacts.size());
  system_.A = rows_.matrix(), system_.b = rows_.velocity;
  restitution_.assign(contacts.size(), 0.0);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Pair& pair = pairs_[static_cast<std::size_t>(contacts[i].pair)];
    system_.laws[i].friction = pair.law.friction;
    const double e = pair.law.restitution, v = -e * rows_.velocity[3 * i], a = -approach[i];
    restitution_[i] = e;
    if (!(v > 0) || !(a > 0)) continue;
    // Flights that are too low or too short to be followed: all further bounces of this contact, in closed form. Where next to
    // nothing is lost they would be countless; without losses they would never end, and the contact closes at once.
    const double height = v * v / (2 * a), flight = 2 * v / a;
    const double shortest = e > policy::nearly_elastic ? policy::shortest_flight * usual_step() : 8 * tolerance_ * (1 - e);
    if (height > policy::resolved_flight * pair.size(*this) && flight > shortest) continue;
    restitution_[i] = 0;
    const double ends = e < 1 ? world_->time() + flight / (1 - e) : 0;
    if (!(ends > world_->time() + tolerance_)) continue;
    const auto known =
        std::find_if(settling_.begin(), settling_.end(), [pair = contacts[i].pair](const auto& s) { return s.first == pair; });
    if (known == settling_.end())
      settling_.emplace_back(contacts[i].pair, ends);
    else
      known->second = std::max(known->second, ends);
  }
  const contact::ImpactResult result = law_.apply(system_, restitution_, simultaneous_);
  if (!result.solved) {
    failure = "no impulses were found that obey the law of impact";
    return false;
  }
  const Impulses impulses = impulses_of(contacts, system_.r);
  std::vector<double> weights(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) weights[i] = system_.r[3 * i];
  // One event for each pair of solids; the first one has the certificate of all.
  bool booked = false;
  for (const auto& [number, impulse] : impulses.by_pair) {
    Event event = begin_event("impact", number);
    locate_event(event, contacts, weights, number);
    event.contact.impulse = impulse, event.contact.scaled = result.scale;
    event.contact.in_turn = simultaneous_ == contact::Simultaneous::in_turn || result.separated;
    if (!booked) {
      TopologyEditor editor(*world_);
      editor.begin(event, "");
      apply(impulses, system_.r, editor, event);
      editor.certify(event);
      booked = true;
    }
    events.push_back(std::move(event));
  }
  return booked;
}

// Of impulses r along the rows of contacts that are placed.
Contacts::Impulses Contacts::impulses_of(const std::vector<Contact>& contacts, const std::vector<double>& r) const {
  Impulses all;
  all.generalised.assign(static_cast<std::size_t>(world_->tree_.nv()), 0.0);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Vec3 impulse{};
    for (std::size_t k = 0; k < 3; ++k) {
      impulse += r[3 * i + k] * along(rows_.touches[i], k);
      rows_.add_row(rows_.J, 3 * i + k, r[3 * i + k], all.generalised.data());
    }
    if (impulse == Vec3{}) continue;
    const Vec3 point = rows_.touches[i].point;
    for (const auto& [body, sign] : {std::pair{contacts[i].a, 1.0}, {contacts[i].b, -1.0}}) {
      if (body >= 0)
        all.on_bodies.push_back({body, sign * impulse, {}, point});
      else
        all.on_ground.push_back({-1, -sign * impulse, {}, point});
    }
    const bool first = contacts[i].a == pairs_[static_cast<std::size_t>(contacts[i].pair)].a;
    all.by_pair[contacts[i].pair] += (first ? 1.0 : -1.0) * impulse;
  }
  return all;
}

// Applies impulses r along the rows of contacts that are placed, as part of an event.
void Contacts::apply(const Impulses& impulses, const std::vector<double>& r, TopologyEditor& editor, Event& event) {
  const double lost = event.lost;
  editor.apply_contact_impulses(impulses.generalised, impulses.on_bodies, impulses.on_ground);
  event.after = world_->totals();
  if (world_->tree_.driven_joints().empty() && world_->tree_.loop_motions() == 0 && !rows_.has_belts()) return;
  // What the contacts did not take, prescribed motions and belts brought in.
  double taken = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    taken -= r[i] * rows_.velocity[i];
    for (std::size_t j = 0; j < r.size(); ++j) taken -= 0.5 * r[i] * rows_.mobility(i, j) * r[j];
  }
  event.work += taken - (event.lost - lost), event.lost = lost + taken;
}

void Contacts::set(std::vector<Contact> contacts) {
  if (contacts.empty() && world_->tree_.contacts().empty()) return;
  world_->tree_.set_contacts(std::move(contacts));
  world_->state_.replace(0, 0, {}, 0, 0, {}, world_->tree_);
}

// After find_contact_mobility.
void Contacts::forget_evaluation_with_loops() {
  if (world_->tree_.has_loops()) static_cast<void>(world_->state_.edit());
}

// Contacts of each island, in their order.
std::vector<std::vector<Contact>> Contacts::by_island(const std::vector<Contact>& contacts) const {
  Islands islands(world_->tree_);
  for (const Contact& c : contacts) islands.join(c.a, c.b);
  std::vector<std::vector<Contact>> all;
  std::map<int, std::size_t> place;
  for (const Contact& c : contacts) {
    const auto [known, first] = place.emplace(islands.of(c.a >= 0 ? c.a : c.b), all.size());
    if (first) all.emplace_back();
    all[known->second].push_back(c);
  }
  return all;
}

// Impacts of an island.
std::optional<Contacts::Unresolved> Contacts::strike_island(const std::vector<Contact>& touching, std::vector<Event>& events) {
  const std::vector<int> here{touching.front().a, touching.front().b};
  if (std::ranges::any_of(touching, [this](const Contact& c) { return law_of(c.pair).has_moments(); }))
    return Unresolved{"torsional or rolling friction", true, here};
  if (touching.size() > policy::most_points)
    return Unresolved{std::to_string(touching.size()) + " points touch at once", true, here};
  std::string failure;
  for (int k = 0; k < policy::most_impacts; ++k) {
    if (!impact(touching, events, failure)) break;
    (*evaluate_)(world_->state_);
  }
  if (!failure.empty()) return Unresolved{failure, true, here};
  return std::nullopt;
}

std::vector<double> Contacts::rigid_pushes() {
  const Tree& tree = world_->tree_;
  const double* const q = world_->state_.q().data();
  Workspace<double>& workspace = world_->workspace_;
  std::vector<double> forces(static_cast<std::size_t>(tree.nv()), 0.0);
  (*evaluate_)(world_->state_);
  const std::vector<Contact> contacts = touching();
  if (contacts.empty()) return forces;
  locate_bodies(tree, world_->state_, workspace);
  place_contacts(tree, workspace, contacts, rows_);
  find_contact_mobility(tree, q, workspace, contacts, rows_);
  forget_evaluation_with_loops();
  (*evaluate_)(world_->state_);
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (const auto& [body, sign] : {std::pair{contacts[i].a, 1.0}, {contacts[i].b, -1.0}})
      if (body >= 0 && rows_.velocity[3 * i] < -slow_approach() && rows_.mobility(3 * i, 3 * i) == 0)
        add_contact_row(tree, q, workspace, body, rows_.touches[i].normal, rows_.touches[i].point, sign, forces.data());
  return forces;
}

// Which contacts of an island are closed from now on, which are appended. `before`: those that were closed.
std::optional<Contacts::Unresolved> Contacts::close_island(std::vector<Contact>& touching, const std::vector<Contact>& before,
                                                           const ContactsByPair& before_by_pair, std::vector<Contact>& closed,
                                                           Settled& settled) {
  if (slowest_ > slowest_slip) stop_creeping(touching, settled);
  for (Contact& c : touching) {
    const auto of_pair = before_by_pair.of(c.pair);
    const auto found =
        std::find_if(of_pair.begin(), of_pair.end(), [&](const auto& b) { return same_contact(before[b.second], c); });
    if (found == of_pair.end()) continue;
    const Contact* const same = &before[found->second];
    if (!(same->keeps_direction > 0)) continue;
    c.direction = same->direction, c.keeps_direction = same->keeps_direction;  // it still begins to slip, or is at the limit
  }
  std::vector<Contact> chosen;
  if (!choose(touching, chosen))
    return Unresolved{"no forces were found for " + std::to_string(touching.size()) + " points of contact at once",
                      true,
                      {touching.front().a, touching.front().b}};
  closed.insert(closed.end(), chosen.begin(), chosen.end());
  return std::nullopt;
}

std::optional<Contacts::Unresolved> Contacts::resolve(std::vector<Event>& events) {
  std::vector<Contact> before = std::exchange(world_->former_contacts_, {});
  if (before.empty()) {
    before.assign(world_->tree_.contacts().begin(), world_->tree_.contacts().end());
    for (std::size_t i = 0; i < std::min(before.size(), slips_along_.size()); ++i)
      if (before[i].keeps_direction == 0 && !(slips_along_[i] == Vec3{})) before[i].direction = slips_along_[i];
  }
  slips_along_.clear();
  std::erase_if(before, [this](const Contact& c) { return is_gone(c.a) || is_gone(c.b); });
  set({});
  settling_.clear(), jammed_.clear();
  forget_apart();
  const std::size_t first = events.size();
  (*evaluate_)(world_->state_);
  if (const std::optional<Overlap> worst = overlap())
    return Unresolved{worst->text(), worst->depth <= left_by_steps, {worst->a, worst->b}};
  std::vector<std::vector<Contact>> islands = by_island(this->touching());
  for (const std::vector<Contact>& touching : islands)
    if (std::optional<Unresolved> failed = strike_island(touching, events)) return failed;
  std::vector<Contact> closed;
  Settled settled(*world_);
  const ContactsByPair before_by_pair(before);
  std::map<int, Vec3> impulses;
  double lacking = 0;
  std::size_t where = 0;
  for (int left = policy::most_choices;; --left) {
    for (std::vector<Contact>& touching : islands)
      if (std::optional<Unresolved> failed = close_island(touching, before, before_by_pair, closed, settled)) {
        lost_ += settled.event.lost - settled.event.work;
        return failed;
      }
    for (Contact& c : closed) {
      const auto now = std::find_if(settling_.begin(), settling_.end(), [&](const auto& s) { return s.first == c.pair; });
      const auto then = before_by_pair.of(c.pair);
      const double known = then.empty() ? 0 : before[then.front().second].settles;  // negative: it was closed, and stays so
      if (now != settling_.end() && known >= 0)
        c.settles = now->second;
      else if (known > world_->time())
        c.settles = known;
    }
    for (const auto& [pair, impulse] : stop(closed, settled)) impulses[pair] += impulse;
    set(closed);
    (*evaluate_)(world_->state_);
    lacking = closed.empty() ? 0 : excess_of_forces(&where);
    if (left == 0 || !(lacking > 0)) break;
    set({}), closed.clear();  // what is stopped leaves others with another slip, or may begin to slip anew
    (*evaluate_)(world_->state_);
  }
  if (lacking > policy::most_lacking) {
    lost_ += settled.event.lost - settled.event.work;
    set({});
    return Unresolved{"no forces were found that obey the law of contact", true, {closed[where].a, closed[where].b}};
  }
  const std::size_t reported = events.size();
  report_changes(before, first, impulses, events);
  if (!settled.any) return std::nullopt;
  if (events.size() == first) {
    lost_ += settled.event.lost - settled.event.work;
    return std::nullopt;
  }
  // Part of the first of these changes, or else of the last impact.
  const bool changes = reported < events.size();
  Event& whole = events[changes ? reported : reported - 1];
  if (changes)
    whole.before = settled.event.before;
  else
    whole.after = settled.event.after;
  settled.editor.certify_part(settled.event, whole);
  return std::nullopt;
}

// Removes what is left of the velocities that closed contacts do not allow; returns the impulses of pairs.
std::map<int, Vec3> Contacts::stop(const std::vector<Contact>& closed, Settled& settled) {
  if (closed.empty()) return {};
  const double slow = slow_approach();
  const Totals before = world_->totals();
  std::vector<double> r;
  bool felt = false;
  {
    const State::Edit edit = world_->state_.edit();
    if (!find_stopping_impulses(world_->tree_, edit.time, edit.q.data(), edit.u.data(), world_->workspace_, closed)) return {};
    rows_ = world_->workspace_.contacts->rows, r = world_->workspace_.contacts->change;
    for (std::size_t i = 0; i < r.size(); ++i) felt = felt || (r[i] != 0 && std::fabs(rows_.velocity[i]) > slow);
    for (std::size_t i = 0; i < r.size() && !felt; ++i) rows_.add_row(rows_.Y, i, r[i], edit.u.data());
  }
  if (!felt) {
    lost_ += before.kinetic - world_->totals().kinetic;
    return {};
  }
  if (!settled.any) {
    settled.any = true, settled.event.before = before;
    settled.editor.begin(settled.event, "");
  }
  const Impulses impulses = impulses_of(closed, r);
  apply(impulses, r, settled.editor, settled.event);
  return impulses.by_pair;
}

// Stops the slip of contacts that creep, as if they stuck.
void Contacts::stop_creeping(std::vector<Contact> contacts, Settled& settled) {
  locate_bodies(world_->tree_, world_->state_, world_->workspace_);
  place_contacts(world_->tree_, world_->workspace_, contacts, rows_);
  std::vector<Contact> staying;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (!(rows_.velocity[3 * i] > slowest_)) staying.push_back(contacts[i]);
  if (staying.size() != contacts.size()) {
    contacts = std::move(staying);
    place_contacts(world_->tree_, world_->workspace_, contacts, rows_);
  }
  // All points of a pair stop slipping at one instant, except one about which it pivots. If one were stopped shortly before the
  // others, these would slip on in another direction.
  constexpr double shortly = 10;  // times the speed below which slip is stopped: they decelerate alike
  std::map<int, double> slowest;  // by pair
  const auto slip = [this](std::size_t i) { return std::hypot(rows_.velocity[3 * i + 1], rows_.velocity[3 * i + 2]); };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    double& least = slowest.emplace(contacts[i].pair, HUGE_VAL).first->second;
    if (slip(i) > slowest_slip) least = std::min(least, slip(i));
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const bool ends = slowest[contacts[i].pair] < slowest_, creeps = slip(i) < (ends ? shortly : 1) * slowest_;
    contacts[i].mode = creeps ? Contact::Mode::stick : Contact::Mode::smooth;
  }
  stop(contacts, settled);
  (*evaluate_)(world_->state_);
}

// Events of pairs whose contacts closed, opened, began to slip or to stick; slip that turns back, or that jams, begins anew. A
// contact that bounces too low to be followed closes when these bounces end. `first`: of the events of this instant. `impulses`:
// with which pairs came to rest.
void Contacts::report_changes(const std::vector<Contact>& before, std::size_t first, const std::map<int, Vec3>& impulses,
                              std::vector<Event>& events) {
  enum class Now : unsigned char { open, still, slips };
  struct Change {
    Now from = Now::open, to = Now::open;
  };
  std::map<int, Change> pairs;
  const auto note = [](Now& now, const Contact& c, bool counts) {
    if (counts) now = std::max(now, c.mode == Contact::Mode::slip ? Now::slips : Now::still);
  };
  for (const Contact& c : before) note(pairs[c.pair].from, c, c.settles < 0);
  const std::vector<Contact> closed(world_->tree_.contacts().begin(), world_->tree_.contacts().end());
  for (const Contact& c : closed) note(pairs[c.pair].to, c, c.settles < 0);
  const ContactsByPair before_by_pair(before), closed_by_pair(closed);
  for (const Contact& c : closed)
    for (const auto& entry : before_by_pair.of(c.pair)) {
      const Contact& then = before[entry.second];
      if (c.keeps_direction > 0 && same_contact(then, c) && dot(then.direction, c.direction) < 0) pairs[c.pair].from = Now::still;
    }
  const auto jams = [&](int pair) { return std::ranges::find(jammed_, pair) != jammed_.end(); };
  for (auto& [pair, change] : pairs)
    if (change.to == Now::slips && jams(pair)) change.from = Now::still;
  locate_bodies(world_->tree_, world_->state_, world_->workspace_);
  for (const auto& [pair, change] : pairs) {
    if (change.from == change.to) continue;
    const char* const what = change.to == Now::open     ? "lift"
                             : change.to == Now::slips  ? "slip"
                             : change.from == Now::open ? "rest"
                                                        : "stick";
    const Pair& changed = pairs_[static_cast<std::size_t>(pair)];
    if (changed.cable >= 0 && !can_be_taut(static_cast<std::size_t>(changed.cable))) continue;  // it broke
    const auto is_known = [&](const Event& event) { return event.contact.cable == changed.law_name; };
    if (changed.cable >= 0 && change.to != Now::open &&
        std::any_of(events.begin() + static_cast<std::ptrdiff_t>(first), events.end(), is_known))
      continue;  // the impact by which it became taut
    const bool opened = change.to == Now::open;
    std::vector<Contact> of;
    for (const auto& entry : (opened ? before_by_pair : closed_by_pair).of(pair))
      of.push_back((opened ? before : closed)[entry.second]);
    Event event = begin_event(what, pair);
    place_contacts(world_->tree_, world_->workspace_, of, rows_);
    locate_event(event, of, std::vector<double>(of.size(), 1.0), pair);
    if (!opened && jams(pair)) {
      event.reason = "no finite force lets it slip on (Painlevé's paradox)";
      if (const auto found = impulses.find(pair); found != impulses.end()) event.contact.impulse = found->second;
    }
    events.push_back(std::move(event));
  }
}

std::string Contacts::event_name(const char* what, int number) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  const std::string& name = pair.law_name;
  if (pair.cable >= 0) return (std::string_view(what) == "lift" ? "slack " : "taut ") + name;
  return name.empty() ? what : std::string(what) + " " + name;
}

}  // namespace momentree
