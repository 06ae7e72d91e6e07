// Contacts in the steps of a simulation, and when they are stepped through instead of being located.
//
// Contacts are located one by one as long as that goes on: time stepping begins where no forces are found, or where these grow
// without bounds, where too many points touch, and where contacts change too often. It ends when no bodies have hit each other
// for a while.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include <momentree/simulate/contact/contact_policy.hpp>
#include <momentree/simulate/simulation_impl.hpp>
#include <momentree/simulate/stepping/separate.hpp>

namespace momentree {

namespace {

constexpr double more_overlap = 1 + 1e-6;  // times the former depth: by less, an overlap is the same one

}  // namespace

void Simulation::Impl::separate() {
  if (!geometry.pairs.any()) return;
  if (std::optional<Error> error = Separator(geometry).run().error()) throw_error(std::move(*error));
}

void Simulation::Impl::make_methods() {
  const auto make = [&](const std::string& name) {
    std::unique_ptr<Integrator> made =
        make_integrator(name, world.tree_, {integration.step, integration.rtol, integration.atol, integration.max_step});
    made->use(&contact_steps);
    return made;
  };
  contact_steps.set_usual_step(integration.step);
  method = make(integration.method);
  method_steps = steps_through_contacts(integration.method);
  geometry.stepped.set_all(method_steps && geometry.pairs.any());
  stops.use(contact_steps);
  stepper = world.model_.has_contact() ? make(contact_stepping_method()) : nullptr;
  if (stepper == nullptr) stepping = {}, geometry.stepped.set({});
  if (stepper != nullptr) contact_steps.points.set({}, true);  // their numbers are those of the former bodies
}

// The forces of contacts that are stepped through, where no step has found them yet.
void Simulation::Impl::find_forces_of_steps() {
  if (!geometry.pairs.any() || !(steps_through() || some_step()) || contact_steps.points.has_forces()) return;
  evaluate_state();
  stops.share();
  contact_steps.find_forces();
}

// Events with conditions, and contacts, to be located within a step of at most h seconds, which contacts may shorten.
std::span<const Watch> Simulation::Impl::watches(double& h) {
  if (some_step()) h = std::min(h, integration.step);
  if (geometry.pairs.any() && (steps_through() || some_step())) h = geometry.stepped.limit_step(h);
  if (geometry.pairs.any()) geometry.overlaps.forget_apart();
  const std::span<const Watch> of_events = queue.watches(world);
  if (!geometry.pairs.any() || steps_through()) return of_events;
  const std::span<const Watch> of_contacts = contacts.watches.watches(h);
  all_watches.assign(of_events.begin(), of_events.end());
  all_watches.insert(all_watches.end(), of_contacts.begin(), of_contacts.end());
  return all_watches;
}

// Stops that are hit while contacts are closed, and contacts. Joints that rest on stops take part in these impacts for as long as
// their stops need not pull, in all of them together.
std::optional<Contacts::Unresolved> Simulation::Impl::resolve_stops_and_contacts() {
  const auto start_again = [&] {
    world.take_variables(world.own_variables());
    evaluate_state();
  };
  // Where prescribed motions let nothing else give way.
  if (stops.any() && has_motions() && stops.release_pushed(contacts.rigid_pushes(), events)) start_again();
  std::size_t first = events.size();
  std::optional<WorldSnapshot> before;
  if (stops.any()) before = world.snapshot();
  for (;;) {
    if (before && !world.tree_.contacts().empty() && stops.strike(events)) start_again();
    const std::optional<Contacts::Unresolved> failed = contacts.resolve(events);
    if (!before || events.size() == first) return failed;
    std::vector<Event> happened;  // stops need not pull when slow contacts come to rest
    std::copy_if(events.begin() + static_cast<std::ptrdiff_t>(first), events.end(), std::back_inserter(happened),
                 [](const Event& event) { return event.contact.one.empty() || !(event.contact.impulse == Vec3{}); });
    const WorldSnapshot after = world.snapshot();
    world.restore(*before);
    std::vector<Event> leaves;
    if (failed || !stops.release_pulled(happened, leaves)) {
      world.restore(after);
      evaluate_state();
      return failed;
    }
    start_again();
    before = world.snapshot();  // released joints stay released
    events.resize(first);
    std::ranges::move(leaves, std::back_inserter(events));
    first = events.size();
    contacts.take_lost();
  }
}

// What happens at stops and contacts at the end of a step.
bool Simulation::Impl::resolve_after_step(double h) {
  bool due = false;
  if (geometry.pairs.any() && steps_through()) {
    resolve_limits();
    if (stalled) return false;
    after_contact_step();
    if (steps_through()) return true;
  } else if (geometry.pairs.any()) {
    if (some_step()) step_islands(h);
    due = !steps_through() && contacts.watches.must_resolve();
  }
  return resolve_in_turn(due, true);
}

// Stops and contacts in turn, until nothing changes at this instant: closed contacts take part in what happens at stops, and what
// stops hold decides which contacts close. After a step contacts come first, if they are `due`; otherwise stops do.
bool Simulation::Impl::resolve_in_turn(bool due, bool after_step) {
  constexpr int most_rounds = 100;
  const auto stops_change = [this, after_step] {
    find_forces_of_steps();
    const std::size_t count = events.size();
    stops.report_stepped(events);
    resolve_limits();
    if (events.size() == count) return false;
    if (!after_step && contact_steps.points.has_forces()) contact_steps.points.release();
    return true;
  };
  const auto closed = [this] { return !world.tree_.contacts().empty(); };
  if (!after_step && stops_change()) due = true;
  for (int k = 0; k < most_rounds && !stalled; ++k) {
    if (geometry.pairs.any() && (due || (closed() && stops.would_strike())) && !resolve_contacts(after_step)) return false;
    if (!stops_change() || !geometry.pairs.any()) break;
    due = !after_step || closed();
  }
  return !stalled;
}

bool Simulation::Impl::resolve_contacts(bool after_step) {
  struct Instant {
    Contacts& contacts;
    ~Instant() { contacts.watches.forget_slow_slip(); }
  } const instant{contacts};
  if (stepping.on) update_islands();
  if (some_step()) join_touched_islands();
  if (steps_through()) return true;
  const std::size_t first = events.size();
  const auto same = [](const Contact& x, const Contact& y) {
    return same_contact(x, y) && x.mode == y.mode && x.direction == y.direction && x.keeps_direction == y.keeps_direction &&
           x.settles == y.settles;
  };
  std::vector<Contact> closed;  // before, to see what changes
  if (!after_step) closed.assign(world.tree_.contacts().begin(), world.tree_.contacts().end());
  for (;;) {
    const std::size_t before = events.size();
    const std::optional<Contacts::Unresolved> failed = resolve_stops_and_contacts();
    for (std::size_t i = before; i < events.size(); ++i) add_to_balance(events[i]);
    const double lost = contacts.take_lost();
    ledger.projection -= lost;
    // A run that continues another one, and in which nothing changes, has the memory of that one.
    if (!after_step && !failed && lost == 0 && events.size() == first && std::ranges::equal(closed, world.tree_.contacts(), same))
      return true;
    queue.forget_looks();
    if (!failed) break;
    if (!failed->can_be_stepped && !after_step) {
      report_overlap(failed->why);
      return false;
    }
    begin_stepping(failed->why, failed->bodies);
    if (steps_through()) return true;
  }
  if (flood_of_changes(first)) begin_stepping("contacts change too often", bodies_of_flood());
  return true;
}

// The largest number of closed contacts in an island in which one of the events from `first` on happened.
std::size_t Simulation::Impl::points_at_events(std::size_t first) {
  const std::span<const Contact> closed = world.tree_.contacts();
  if (closed.size() <= policy::crowded || events.size() == first) return 0;
  world.evaluate();
  std::size_t most = 0;
  for (const std::vector<std::size_t>& island : world.workspace_.contacts->rows.islands())
    for (std::size_t i = first; island.size() > most && i < events.size(); ++i) {
      const std::string& one = events[i].contact.one;
      if (one.empty()) continue;
      const int body = world.model_.body(one).index;
      if (std::any_of(island.begin(), island.end(), [&](std::size_t k) { return closed[k].a == body || closed[k].b == body; }))
        most = island.size();
    }
  return most;
}

// Impacts of one pair of bodies after the other are those of a body that bounces until it rests, which is followed to the end.
bool Simulation::Impl::flood_of_changes(std::size_t first) {
  const double now = world.time();
  if (!(now <= stepping.window + policy::window_length)) stepping.window = now, stepping.changes = 0;
  if (!(now <= stepping.instant + policy::instant_length)) stepping.instant = now, stepping.changes_at_once = 0;
  if (first > 0) stepping.one = events[first - 1].contact.one, stepping.other = events[first - 1].contact.other;
  const auto is_last = [&](const Event& e) { return e.contact.one == stepping.one && e.contact.other == stepping.other; };
  const bool bounces = first + 1 == events.size() && is_last(events[first]);
  // A change costs dozens of evaluations, each of which solves for the forces of an island.
  const double crowd = static_cast<double>(points_at_events(first)) / static_cast<double>(policy::crowded);
  const int weight = crowd > 1 ? static_cast<int>(std::ceil(crowd * crowd)) : 1;
  if (!bounces && events.size() > first) stepping.changes += weight;
  stepping.changes_at_once += weight;
  return (stepping.changes > policy::most_changes &&
          stepping.changes * share_of_island(stepping.window) > policy::most_changes) ||
         (stepping.changes_at_once > policy::most_changes_at_once &&
          stepping.changes_at_once * share_of_island(stepping.instant) > policy::most_changes_at_once);
}

// The largest part of the events of contacts since then that happened in one island: many bodies that land each for itself are no
// flood.
double Simulation::Impl::share_of_island(double since) {
  Islands islands(world.tree_);
  geometry.stepped.join_touching(islands);
  std::map<int, int> counts;
  int all = 0, most = 0;
  for (auto event = events.rbegin(); event != events.rend() && event->time >= since; ++event) {
    if (event->contact.one.empty()) continue;
    ++all;
    most = std::max(most, ++counts[islands.of(world.model_.body(event->contact.one).index)]);
  }
  return all == 0 ? 1 : static_cast<double>(most) / all;
}

// Those whose contacts changed most often.
std::vector<int> Simulation::Impl::bodies_of_flood() const {
  std::map<std::string_view, int> changes;
  std::string_view most;
  for (auto event = events.rbegin(); event != events.rend() && event->time >= stepping.window; ++event) {
    const std::string& one = event->contact.one;
    if (one.empty() || geometry.stepped.holds(world.model_.body(one).index)) continue;
    if (++changes[one] > changes[most]) most = one;
  }
  if (!most.empty()) return {world.model_.body(most).index};
  return world.tree_.contacts().empty() ? std::vector<int>() : slowest_slip_of(geometry.world);
}

// Adaptive steps that contacts keep short beyond reason would never reach the end. With many contacts each of them takes long.
void Simulation::Impl::judge_steps() {
  if (steps_through() || !method->adaptive() || world.tree_.contacts().empty()) {
    stepping.steps = 0;
    return;
  }
  const double crowd = static_cast<double>(world.tree_.contacts().size()) / static_cast<double>(policy::crowded);
  const int count =
      crowd > 1 ? std::max(policy::least_steps, static_cast<int>(policy::most_steps / (crowd * crowd))) : policy::most_steps;
  if (stepping.steps == 0) stepping.steps_began = world.time();
  if (++stepping.steps <= count) return;
  stepping.steps = 0;
  if (world.time() - stepping.steps_began < count * policy::shortest_steps * integration.step)
    begin_stepping("steps become too short", slowest_slip_of(geometry.world));
}

void Simulation::Impl::note_before_contact_step() {
  before_step.state = world.state_;
  before_step.ledger = ledger, before_step.energy = total_energy(), before_step.proposal = method->proposal();
  before_step.kinetic = kinetic_by_island(geometry.world);
}

// Where friction leaves hardly any force that keeps a contact closed, forces grow within a step to whatever the arithmetic allows
// (Painlevé). The energy shows it: that of the whole world, or that of an island.
bool Simulation::Impl::contacts_gained_energy() {
  constexpr double rounding = 1e-6;  // of all energies
  const auto brought_in = [](const EnergyLedger& l) { return l.work + l.projection - l.dissipated - l.impacts; };
  const double gained = total_energy() - before_step.energy - (brought_in(ledger) - brought_in(before_step.ledger));
  const Totals now = world.totals();
  const double largest = std::max(balance.largest_kinetic, now.kinetic);
  const double all = largest + std::fabs(now.potential);
  if (gained <= rounding * all) return false;
  double unmoved = 0;  // the energy of slip at the speed below which there is none
  for (const int b : world.tree_.order()) unmoved += world.tree_.link(b).body.m * slowest_slip * slowest_slip;
  if (gained <= std::max(unmoved, rounding * energy_of_heights(world))) return false;
  if (!(gained <= policy::most_gained * largest)) return true;
  if (!(gained > policy::least_height * energy_of_heights(world))) return false;
  const std::vector<double> kinetic = kinetic_by_island(geometry.world);
  for (std::size_t i = 0; i < kinetic.size(); ++i)
    if (gained > policy::most_gained_by_island * kinetic[i] && kinetic[i] - before_step.kinetic[i] > 0.5 * gained) return true;
  return false;
}

void Simulation::Impl::undo_contact_step() {
  world.state_ = before_step.state;
  ledger = before_step.ledger;
  method->set_proposal(before_step.proposal);
}

SteppingState Simulation::Impl::stepping_state() const {
  SteppingState now = stepping;
  now.points = contact_steps.points.all();
  now.released = stepper != nullptr && (some_step() || steps_through()) && contact_steps.points.released();
  now.short_steps = contacts.watches.short_steps();
  if (!world.model_.colliders().empty() || std::ranges::any_of(world.model_.springs(), &Spring::inextensible))
    now.largest_kinetic = balance.largest_kinetic;
  if (!events.empty()) now.one = events.back().contact.one, now.other = events.back().contact.other;
  return now;
}

void Simulation::Impl::continue_stepping(const SteppingState& from) {
  stepping = from;
  stepping.points.clear(), stepping.unloaded = stepping.excess = -1, stepping.overlap = stepping.largest_kinetic = 0;
  if (from.largest_kinetic > 0) balance.largest_kinetic = from.largest_kinetic;
  contacts.watches.set_short_steps(from.short_steps);
  geometry.stepped.set(stepped_bodies());
  if (stepping.on || method_steps || !contact_steps.points.all().empty()) contact_steps.points.set(from.points, from.released);
}

// Forces or the state changed: the contacts that close may be others, and forces of the last step are out of date.
void Simulation::Impl::update_pending_contacts() {
  keeps_contacts = false;
  between_runs.set_former(between_runs.closed());
  if (contact_steps.points.has_forces()) contact_steps.points.release();
  if (steps_through() && stops.any())
    find_forces_of_steps();  // contacts that are located would not know of stops that are not
  else
    between_runs.find_pending(method_steps);
}

// A document may be one of another scenario, in which its contacts are no longer those that close.
void Simulation::Impl::check_contacts_of_document(const SteppingState& from) {
  if (!geometry.pairs.any()) return;
  bool hold = between_runs.excess_of_closed() <= from.excess;
  const bool known = from.unloaded >= 0;
  if (hold && (known || !contact_steps.points.all().empty())) {
    constexpr double same = 1e-9;
    hold = (!from.released || known) && contact_steps.still_near() &&
           (!known || std::fabs(unloaded() - from.unloaded) <= same * std::max(1.0, from.unloaded));
  }
  if (hold && known) find_forces_of_steps();
  if (hold) return;
  if (!from.released) contact_steps.points.set({}, true);  // they are those of another scenario
  update_pending_contacts();
}

// The norm of the rates of all momenta without the forces of contacts that are stepped through.
double Simulation::Impl::unloaded() {
  const auto count = evaluate.count;
  const auto seconds = evaluate.seconds;
  const bool released = contact_steps.points.released(), had_forces = contact_steps.points.has_forces();
  contact_steps.points.release();
  double sum = 0;
  for (const double rate : world.pdot()) sum += rate * rate;
  contact_steps.points.set(contact_steps.points.all(), released);
  if (had_forces) find_forces_of_steps();
  evaluate_state();
  evaluate.count = count, evaluate.seconds = seconds;
  const double norm = std::sqrt(sum), unit = norm > 0 ? std::exp2(std::ilogb(norm) - 40) : 1;
  return unit * std::round(norm / unit);  // without the last bits, which depend on the order of bodies
}

void Simulation::Impl::report_overlap(const std::string& what) {
  overlapped = what;
  message = no_progress_at(world.time()) + what;
  if (statistics.steps == 0 && as_built && !integration.resolve) message += "; resolve = true pushes bodies apart at the start";
  stalled = true;
}

// Bodies that a run could not keep apart, such as those that are locked, are no reason to refuse the run that continues it.
bool Simulation::Impl::overlaps_as_before(double before) {
  return before > 0 && geometry.pairs.any() && geometry.overlaps.deepest() <= more_overlap * before;
}

// Actions must not make bodies overlap: pushing them apart would bring in energy. Where contacts are located, resolve_contacts()
// finds out unless bodies cross each other. `before`: what time stepping had left (m).
bool Simulation::Impl::overlaps_more_than(double before) {
  const std::optional<Overlap> worst = geometry.overlaps.of_all();
  if (!worst || worst->depth <= std::max(left_by_steps, more_overlap * before)) return false;
  report_overlap(worst->text());
  return true;
}

// The same for a state that was set.
bool Simulation::Impl::overlaps_at_start() {
  if (!std::exchange(stepping.placed, false) || !geometry.pairs.any()) return false;
  const std::optional<Overlap> worst = geometry.overlaps.of_all();
  if (!worst || worst->depth <= left_by_steps) return false;
  stepping.placed = true;
  report_overlap(worst->text());
  return true;
}

}  // namespace momentree
