// What happens at an instant at which bodies touch: impacts, and the contacts that stay closed.
#include <algorithm>
#include <cmath>
#include <map>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/contacts_impl.hpp>
#include <momentree/simulate/topology_editor.hpp>

namespace momentree {

namespace {

constexpr int most_impacts = 200;          // at one instant
constexpr double resolved_flight = 1e-12;  // lower flights, relative to coordinates, count as rest (m)
constexpr double left_by_steps = 1e-3;     // m: states from time stepping may have such overlaps
constexpr double motion_from_residual =
    50;                                // the motion that a solution may have because it is inexact, relative to its residual
constexpr double no_approach = 1e-10;  // m/s, relative to the fastest point

double largest(const std::vector<double>& all) {
  double most = 0;
  for (const double x : all) most = std::max(most, std::fabs(x));
  return most;
}

const Vec3& along(const contact::Touch& touch, std::size_t k) { return k == 0 ? touch.normal : touch.tangent[k - 1]; }

}  // namespace

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

// One impact at all contacts. False if none of them approach.
bool Contacts::impact(const std::vector<Contact>& contacts, std::vector<Event>& events, std::string& failure) {
  const Tree& tree = world_->tree_;
  const double* const q = world_->state_.q().data();
  Workspace<double>& workspace = world_->workspace_;
  accelerate(tree, world_->state_, workspace);
  locate_bodies(tree, world_->state_, workspace);
  place_contacts(tree, workspace, contacts, rows_);
  double fastest = 1;
  for (const BodyMotion& m : world_->motions()) fastest = std::max(fastest, norm(m.linear));
  bool approaching = false;
  for (std::size_t i = 0; i < contacts.size(); ++i) approaching = approaching || rows_.velocity[3 * i] < -no_approach * fastest;
  if (!approaching) return false;
  find_contact_accelerations(tree, q, workspace, contacts, rows_);
  find_contact_mobility(tree, q, workspace, contacts, rows_);
  static_cast<void>(world_->state_.edit());  // the workspace no longer holds its evaluation if there are loops
  system_.resize(contacts.size());
  system_.A = rows_.A, system_.b = rows_.velocity;
  restitution_.assign(contacts.size(), 0.0);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Pair& pair = pairs_[static_cast<std::size_t>(contacts[i].pair)];
    system_.laws[i].friction = pair.law.friction;
    const double e = pair.law.restitution, v = -e * rows_.velocity[3 * i], a = -rows_.acceleration[3 * i];
    restitution_[i] = e;
    if (!(v > 0) || !(a > 0) || e == 1) continue;
    // All further bounces of this contact, in closed form.
    const double height = v * v / (2 * a), last = 2 * v / (a * (1 - e));
    if (height > resolved_flight * pair.size(*this) && last > 8 * tolerance_) continue;
    restitution_[i] = 0;
    const double ends = world_->time() + last;
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
  const auto nv = static_cast<std::size_t>(tree.nv());
  std::vector<double> generalised(nv, 0.0), weights(contacts.size());
  std::vector<AppliedImpulse> on_bodies, on_ground;
  std::map<int, Vec3> by_pair;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Vec3 impulse{};
    for (std::size_t k = 0; k < 3; ++k) {
      impulse += system_.r[3 * i + k] * along(rows_.touches[i], k);
      for (std::size_t j = 0; j < nv; ++j) generalised[j] += system_.r[3 * i + k] * rows_.J[(3 * i + k) * nv + j];
    }
    weights[i] = system_.r[3 * i];
    if (impulse == Vec3{}) continue;
    const Vec3 point = rows_.touches[i].point;
    for (const auto& [body, sign] : {std::pair{contacts[i].a, 1.0}, {contacts[i].b, -1.0}}) {
      if (body >= 0)
        on_bodies.push_back({body, sign * impulse, {}, point});
      else
        on_ground.push_back({-1, -sign * impulse, {}, point});
    }
    const bool first = contacts[i].a == pairs_[static_cast<std::size_t>(contacts[i].pair)].a;
    by_pair[contacts[i].pair] += (first ? 1.0 : -1.0) * impulse;
  }
  // One event for each pair of solids; the first one has the certificate of all.
  bool booked = false;
  for (const auto& [number, impulse] : by_pair) {
    Event event = begin_event("impact", number);
    locate_event(event, contacts, weights, number);
    event.contact.impulse = impulse, event.contact.scaled = result.scale;
    event.contact.in_turn = simultaneous_ == contact::Simultaneous::in_turn || result.separated;
    if (!booked) {
      TopologyEditor editor(*world_);
      editor.begin(event, "");
      editor.apply_contact_impulses(generalised, on_bodies, on_ground);
      event.after = world_->totals();
      if (!tree.driven_joints().empty()) {
        // What the contacts did not take, prescribed motions brought in.
        const double taken = -system_.energy_change();
        event.work += taken - event.lost, event.lost = taken;
      }
      editor.certify(event);
      booked = true;
    }
    events.push_back(std::move(event));
  }
  return booked;
}

// Which of the contacts that touch, and do not separate, stay closed: from a complementarity problem in the accelerations.
bool Contacts::choose(const std::vector<Contact>& contacts, std::vector<Contact>& closed) {
  closed.clear();
  const Tree& tree = world_->tree_;
  Workspace<double>& workspace = world_->workspace_;
  accelerate(tree, world_->state_, workspace);
  locate_bodies(tree, world_->state_, workspace);
  place_contacts(tree, workspace, contacts, rows_);
  const double* const q = world_->state_.q().data();
  find_contact_accelerations(tree, q, workspace, contacts, rows_);
  double fastest = 1;
  for (const BodyMotion& m : world_->motions()) fastest = std::max(fastest, norm(m.linear));
  std::vector<Contact> staying;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    // Flights too low to be resolved count as rest.
    const double size = pairs_[static_cast<std::size_t>(contacts[i].pair)].size(*this);
    const double hidden = std::sqrt(2 * std::max(0.0, -rows_.acceleration[3 * i]) * resolved_flight * size);
    if (rows_.velocity[3 * i] <= std::max(10 * no_approach * fastest, hidden)) staying.push_back(contacts[i]);
  }
  if (staying.empty()) return true;
  place_contacts(tree, workspace, staying, rows_);
  find_contact_accelerations(tree, q, workspace, staying, rows_);
  find_contact_mobility(tree, q, workspace, staying, rows_);
  static_cast<void>(world_->state_.edit());
  if (!solve_states(staying)) return false;
  system_.velocities(after_);
  weakened_ = false;
  const double noise = 1e-12 * largest(system_.r), inexact = motion_from_residual * system_.residual() * largest(system_.b);
  for (std::size_t i = 0; i < staying.size(); ++i) {
    if (!(system_.r[3 * i] > noise)) continue;
    Contact c = staying[i];
    const contact::PointLaw& law = system_.laws[i];
    const ContactLaw& own = pairs_[static_cast<std::size_t>(c.pair)].law;
    c.friction = own.friction;
    if (!law.slipping) c.keeps_direction = 0;
    if (law.slipping) {
      c.mode = Contact::Mode::slip;
      const Vec3 v =
          rows_.velocity[3 * i + 1] * rows_.touches[i].tangent[0] + rows_.velocity[3 * i + 2] * rows_.touches[i].tangent[1];
      if (!keeps_direction(c, v)) {
        c.direction = law.direction[0] * rows_.touches[i].tangent[0] + law.direction[1] * rows_.touches[i].tangent[1];
        if (norm(v) >= 2 * c.keeps_direction) c.keeps_direction = 0;
      }
    } else if (!(own.static_friction > 0)) {
      c.mode = Contact::Mode::smooth;
    } else if (system_.state(i) == contact::PointState::slip && std::hypot(after_[3 * i + 1], after_[3 * i + 2]) > inexact) {
      if (!weakened_) weaken_friction();
      const double a1 = weaker_[3 * i + 1], a2 = weaker_[3 * i + 2], size = std::hypot(a1, a2);
      c.mode = Contact::Mode::slip;
      c.direction = (a1 / size) * rows_.touches[i].tangent[0] + (a2 / size) * rows_.touches[i].tangent[1];
      c.keeps_direction = 2 * own.friction * std::fabs(rows_.acceleration[3 * i]) * slow_slip_;
    } else {
      c.mode = Contact::Mode::stick;
    }
    closed.push_back(c);
  }
  return true;
}

// Accelerations with a little less friction, in weaker_: where bodies begin to slip, their accelerations are nearly zero, and so
// are known less well than the directions in which they will slip.
void Contacts::weaken_friction() {
  constexpr double less = 1 - 1e-5;
  weakened_ = true;
  weaker_ = after_;
  const std::vector<double> solution = system_.r;
  const std::vector<contact::PointLaw> laws = system_.laws;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    system_.laws[i].friction *= less;
    for (std::size_t k = 1; k < 3; ++k) system_.r[3 * i + k] *= less;
  }
  if (system_.solve(contact::Effort::little)) {
    std::vector<double> found;
    system_.velocities(found);
    for (std::size_t i = 0; i < laws.size(); ++i)
      if (std::hypot(found[3 * i + 1], found[3 * i + 2]) > std::hypot(after_[3 * i + 1], after_[3 * i + 2]))
        std::copy_n(found.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, weaker_.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  system_.r = solution, system_.laws = laws;
}

// The forces of contacts that are placed, with their accelerations and mobility.
bool Contacts::solve_states(const std::vector<Contact>& contacts) {
  system_.resize(contacts.size());
  system_.A = rows_.A, system_.b = rows_.acceleration;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactLaw& own = pairs_[static_cast<std::size_t>(contacts[i].pair)].law;
    contact::PointLaw& law = system_.laws[i];
    const double v1 = rows_.velocity[3 * i + 1], v2 = rows_.velocity[3 * i + 2], speed = std::hypot(v1, v2);
    const contact::Touch& touch = rows_.touches[i];
    const Vec3 v = v1 * touch.tangent[0] + v2 * touch.tangent[1];
    const bool keeps = keeps_direction(contacts[i], v), ahead = dot(v, contacts[i].direction) > slowest_slip;
    law.slipping = (keeps ? ahead : speed > slowest_) && own.friction > 0;
    law.friction = law.slipping ? own.friction : own.static_friction;
    if (!law.slipping) continue;
    const Vec3 s = keeps ? v + contacts[i].keeps_direction * contacts[i].direction : v;
    const double along_1 = dot(s, touch.tangent[0]), along_2 = dot(s, touch.tangent[1]), size = std::hypot(along_1, along_2);
    law.direction = {along_1 / size, along_2 / size};
  }
  // Contacts that are nearly at rest contradict each other by what is left of their velocities. The result only tells states
  // apart.
  constexpr double acceptable = 1e-8;
  if (system_.solve(contact::Effort::little, acceptable)) return true;
  // With many points that slip the solver may cycle. The velocities after a very short time obey a law without given directions.
  constexpr double soon = 1e-6;  // s
  for (std::size_t i = 0; i < system_.unknowns(); ++i) system_.b[i] = rows_.velocity[i] + soon * rows_.acceleration[i];
  for (std::size_t i = 0; i < contacts.size(); ++i) system_.b[3 * i] = soon * rows_.acceleration[3 * i];
  for (contact::PointLaw& law : system_.laws) law.slipping = false;
  std::fill(system_.r.begin(), system_.r.end(), 0.0);
  const bool solved = system_.solve(contact::Effort::full, acceptable);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double v1 = rows_.velocity[3 * i + 1], v2 = rows_.velocity[3 * i + 2], speed = std::hypot(v1, v2);
    if (!(speed > slowest_) || !(system_.laws[i].friction > 0)) continue;
    if (system_.state(i) == contact::PointState::stick) continue;  // no finite force keeps it slipping: it stops (Painlevé)
    system_.laws[i].slipping = true, system_.laws[i].direction = {v1 / speed, v2 / speed};
  }
  return solved;
}

void Contacts::set(std::vector<Contact> contacts) {
  if (contacts.empty() && world_->tree_.contacts().empty()) return;
  world_->tree_.set_contacts(std::move(contacts));
  world_->state_.replace(0, 0, {}, 0, 0, {}, world_->tree_);
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

// Impacts of an island, and which of its contacts are closed from now on, which are appended. `before`: those that were closed.
std::optional<Contacts::Unresolved> Contacts::resolve_island(std::vector<Contact>& touching, const std::vector<Contact>& before,
                                                             std::vector<Contact>& closed, std::vector<Event>& events) {
  const std::vector<int> here{touching.front().a, touching.front().b};
  if (touching.size() > most_points) return Unresolved{std::to_string(touching.size()) + " points touch at once", true, here};
  std::string failure;
  for (int k = 0; k < most_impacts; ++k) {
    if (!impact(touching, events, failure)) break;
    (*evaluate_)(world_->state_);
  }
  if (!failure.empty()) return Unresolved{failure, true, here};
  if (slowest_ > slowest_slip) lost_ += stop_creeping(touching);
  for (Contact& c : touching) {
    const auto same = std::find_if(before.begin(), before.end(), [&](const Contact& b) { return same_contact(b, c); });
    if (same == before.end() || same->mode != Contact::Mode::slip || !(same->keeps_direction > 0)) continue;
    c.direction = same->direction, c.keeps_direction = same->keeps_direction;  // it still begins to slip
  }
  std::vector<Contact> chosen;
  if (!choose(touching, chosen))
    return Unresolved{"no forces were found for " + std::to_string(touching.size()) + " points of contact at once", true, here};
  closed.insert(closed.end(), chosen.begin(), chosen.end());
  return std::nullopt;
}

std::optional<Contacts::Unresolved> Contacts::resolve(std::vector<Event>& events) {
  const std::vector<Contact> before(world_->tree_.contacts().begin(), world_->tree_.contacts().end());
  set({});
  settling_.clear();
  const std::size_t first = events.size();
  (*evaluate_)(world_->state_);
  if (const std::optional<Overlap> worst = overlap())
    return Unresolved{worst->text(), worst->depth <= left_by_steps, {worst->a, worst->b}};
  std::vector<Contact> closed;
  for (std::vector<Contact>& touching : by_island(this->touching())) {
    std::optional<Unresolved> failed = resolve_island(touching, before, closed, events);
    if (!failed) continue;
    slowest_ = slowest_slip;
    return failed;
  }
  slowest_ = slowest_slip;
  for (Contact& c : closed) {
    const auto now = std::find_if(settling_.begin(), settling_.end(), [&](const auto& s) { return s.first == c.pair; });
    const auto then = std::find_if(before.begin(), before.end(), [&](const Contact& b) { return b.pair == c.pair; });
    if (now != settling_.end())
      c.settles = now->second;
    else if (then != before.end() && then->settles > world_->time())
      c.settles = then->settles;
  }
  set(closed);
  const std::size_t reported = events.size();
  const double lost = stop(closed);
  (*evaluate_)(world_->state_);
  report_changes(before, first, events);
  if (lost != 0) (events.size() > reported ? events[reported].lost : lost_) += lost;
  return std::nullopt;
}

// Removes what is left of the velocities that closed contacts do not allow; returns the energy lost (J).
double Contacts::stop(const std::vector<Contact>& closed) {
  if (closed.empty()) return 0;
  const Tree& tree = world_->tree_;
  const double before = world_->totals().kinetic;
  {
    const State::Edit edit = world_->state_.edit();
    if (!stop_contacts(tree, edit.time, edit.q.data(), edit.u.data(), world_->workspace_)) return 0;
  }
  return before - world_->totals().kinetic;
}

// Stops the slip of contacts that creep, as if they stuck; returns the energy lost (J).
double Contacts::stop_creeping(std::vector<Contact> contacts) {
  locate_bodies(world_->tree_, world_->state_, world_->workspace_);
  place_contacts(world_->tree_, world_->workspace_, contacts, rows_);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const bool creeps = std::hypot(rows_.velocity[3 * i + 1], rows_.velocity[3 * i + 2]) < slowest_;
    contacts[i].mode = creeps ? Contact::Mode::stick : Contact::Mode::smooth;
  }
  set(contacts);
  const double lost = stop(contacts);
  set({});
  (*evaluate_)(world_->state_);
  return lost;
}

// Events of pairs whose contacts closed, opened, began to slip or to stick. A contact that bounces too low to be followed closes
// when these bounces end. `first`: of the events of this instant.
void Contacts::report_changes(const std::vector<Contact>& before, std::size_t first, std::vector<Event>& events) {
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
    const std::vector<Contact>& of = change.to == Now::open ? before : closed;
    Event event = begin_event(what, pair);
    place_contacts(world_->tree_, world_->workspace_, of, rows_);
    locate_event(event, of, std::vector<double>(of.size(), 1.0), pair);
    events.push_back(std::move(event));
  }
}

std::string Contacts::event_name(const char* what, int number) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  const std::string& name = pair.law_name;
  if (pair.cable >= 0) return (std::string_view(what) == "lift" ? "slack " : "taut ") + name;
  return name.empty() ? what : std::string(what) + " " + name;
}

// Of the present forces: how far they are outside of what contacts can exert, relative to the largest force of their island.
// Where several contacts share a load, others may carry it as well: only if no forces can, the contacts change.
double Contacts::excess_of_forces() {
  world_->evaluate();
  double worst = -1;
  for (const std::vector<std::size_t>& island : world_->workspace_.contacts->rows.islands())
    worst = std::max(worst, excess_of_island(island));
  return worst;
}

double Contacts::excess_of_island(const std::vector<std::size_t>& island) {
  const std::span<const Contact> closed = world_->tree_.contacts();
  const ContactRows& rows = world_->workspace_.contacts->rows;
  const std::vector<double>& r = rows.forces;
  double size = 1e-300, worst = -1;
  for (const std::size_t i : island)
    for (std::size_t k = 0; k < 3; ++k) size = std::max(size, std::fabs(r[3 * i + k]));
  for (const std::size_t i : island) {
    worst = std::max(worst, -r[3 * i] / size);
    if (closed[i].mode != Contact::Mode::stick) continue;
    const double most = pairs_[static_cast<std::size_t>(closed[i].pair)].law.static_friction * r[3 * i];
    worst = std::max(worst, (std::hypot(r[3 * i + 1], r[3 * i + 2]) - most) / size);
  }
  if (worst <= rounding || island.size() < 2) return worst;
  std::vector<Contact> contacts;
  for (const std::size_t i : island) contacts.push_back(closed[i]);
  rows_ = rows.of(island);
  return excess_of_shared_forces(contacts, worst);
}

// Positive if no forces keep the contacts as they are: the acceleration with which they open or begin to slip, relative to the
// largest one without forces.
double Contacts::excess_of_shared_forces(const std::vector<Contact>& closed, double otherwise) {
  if (!solve_states(closed)) return otherwise;
  system_.velocities(after_);
  const double size = std::max(largest(system_.b), 1e-300);
  double worst = -1;
  const double noise = std::max(1e-10, motion_from_residual * system_.residual());
  for (std::size_t i = 0; i < closed.size(); ++i) {
    worst = std::max(worst, after_[3 * i] / size - noise);
    if (closed[i].mode == Contact::Mode::stick)
      worst = std::max(worst, std::hypot(after_[3 * i + 1], after_[3 * i + 2]) / size - noise);
  }
  if (worst > 0) return worst;
  // Forces were found that keep them. How near they are to where none do is known roughly: from the friction of all points of a
  // pair.
  const double largest_force = std::max(largest(system_.r), 1e-300);
  double near = -1;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (i > 0 && closed[i].pair == closed[i - 1].pair) continue;
    double most = 0;
    Vec3 friction{};
    for (std::size_t k = i; k < closed.size() && closed[k].pair == closed[i].pair; ++k) {
      if (closed[k].mode != Contact::Mode::stick) continue;
      const double side = closed[k].a == closed[i].a ? 1 : -1;
      most += system_.laws[k].friction * system_.r[3 * k];
      for (std::size_t d = 1; d < 3; ++d) friction += side * system_.r[3 * k + d] * along(rows_.touches[k], d);
    }
    if (most > 0) near = std::max(near, (norm(friction) - most) / largest_force);
  }
  return std::min(worst, near);
}

}  // namespace momentree
