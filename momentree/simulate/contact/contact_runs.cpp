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

ContactRun::ContactRun(Simulation::Impl& run, double tolerance, double located_step)
    : geometry(run.world, run.evaluate),
      contacts(geometry, tolerance, run.integration.simultaneous, located_step),
      between_runs(geometry, located_step),
      steps(geometry),
      run_(run) {}

void ContactRun::separate() {
  if (!geometry.pairs.any()) return;
  if (std::optional<Error> error = Separator(geometry).run().error()) throw_error(std::move(*error));
}

// The forces of contacts that are stepped through, where no step has found them yet.
void ContactRun::find_forces_of_steps() {
  if (!geometry.pairs.any() || !(steps_through() || some_step()) || steps.points.has_forces()) return;
  run_.evaluate_state();
  run_.stops.share();
  steps.find_forces();
}

// Events with conditions, and contacts, to be located within a step of at most h seconds, which contacts may shorten.
std::span<const Watch> ContactRun::watches(double& h) {
  if (some_step()) h = std::min(h, run_.integration.step);
  if (geometry.pairs.any() && (steps_through() || some_step())) h = geometry.stepped.limit_step(h);
  if (geometry.pairs.any()) geometry.overlaps.forget_apart();
  const std::span<const Watch> of_events = run_.queue.watches(run_.world);
  if (!geometry.pairs.any() || steps_through()) return of_events;
  const std::span<const Watch> of_contacts = contacts.watches.watches(h);
  all_watches_.assign(of_events.begin(), of_events.end());
  all_watches_.insert(all_watches_.end(), of_contacts.begin(), of_contacts.end());
  return all_watches_;
}

// Stops that are hit while contacts are closed, and contacts. Joints that rest on stops take part in these impacts for as long as
// their stops need not pull, in all of them together.
std::optional<Contacts::Unresolved> ContactRun::resolve_stops_and_contacts() {
  const auto start_again = [&] {
    run_.world.edit().take_own_variables();
    run_.evaluate_state();
  };
  // Where prescribed motions let nothing else give way.
  if (run_.stops.any() && has_motions(run_.world.tree()) && run_.stops.release_pushed(contacts.rigid_pushes(), run_.events))
    start_again();
  std::size_t first = run_.events.size();
  std::optional<WorldSnapshot> before;
  if (run_.stops.any()) before = run_.world.snapshot();
  for (;;) {
    if (before && !run_.world.tree().contacts().empty() && run_.stops.strike(run_.events)) start_again();
    const std::optional<Contacts::Unresolved> failed = contacts.resolve(run_.events);
    if (!before || run_.events.size() == first) return failed;
    std::vector<Event> happened;  // stops need not pull when slow contacts come to rest
    std::copy_if(run_.events.begin() + static_cast<std::ptrdiff_t>(first), run_.events.end(), std::back_inserter(happened),
                 [](const Event& event) { return event.contact.one.empty() || !(event.contact.impulse == Vec3{}); });
    const WorldSnapshot after = run_.world.snapshot();
    run_.world.restore(*before);
    std::vector<Event> leaves;
    if (failed || !run_.stops.release_pulled(happened, leaves)) {
      run_.world.restore(after);
      run_.evaluate_state();
      return failed;
    }
    start_again();
    before = run_.world.snapshot();  // released joints stay released
    run_.events.resize(first);
    std::ranges::move(leaves, std::back_inserter(run_.events));
    first = run_.events.size();
    contacts.take_lost();
  }
}

// What happens at stops and contacts at the end of a step.
bool ContactRun::resolve_after_step(double h) {
  bool due = false;
  if (geometry.pairs.any() && steps_through()) {
    run_.resolve_limits();
    if (run_.outcome.stalled) return false;
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
bool ContactRun::resolve_in_turn(bool due, bool after_step) {
  constexpr int most_rounds = 100;
  const auto stops_change = [this, after_step] {
    find_forces_of_steps();
    const std::size_t count = run_.events.size();
    run_.stops.report_stepped(run_.events);
    run_.resolve_limits();
    if (run_.events.size() == count) return false;
    if (!after_step && steps.points.has_forces()) steps.points.release();
    return true;
  };
  const auto closed = [this] { return !run_.world.tree().contacts().empty(); };
  if (!after_step && stops_change()) due = true;
  for (int k = 0; k < most_rounds && !run_.outcome.stalled; ++k) {
    if (geometry.pairs.any() && (due || (closed() && run_.stops.would_strike())) && !resolve_contacts(after_step)) return false;
    if (!stops_change() || !geometry.pairs.any()) break;
    due = !after_step || closed();
  }
  return !run_.outcome.stalled;
}

bool ContactRun::resolve_contacts(bool after_step) {
  struct Instant {
    Contacts& contacts;
    ~Instant() { contacts.watches.forget_slow_slip(); }
  } const instant{contacts};
  if (stepping.on) update_islands();
  if (some_step()) join_touched_islands();
  if (steps_through()) return true;
  const std::size_t first = run_.events.size();
  const auto same = [](const Contact& x, const Contact& y) {
    return same_contact(x, y) && x.mode == y.mode && x.direction == y.direction && x.keeps_direction == y.keeps_direction &&
           x.settles == y.settles;
  };
  std::vector<Contact> closed;  // before, to see what changes
  if (!after_step) closed.assign(run_.world.tree().contacts().begin(), run_.world.tree().contacts().end());
  for (;;) {
    const std::size_t before = run_.events.size();
    const std::optional<Contacts::Unresolved> failed = resolve_stops_and_contacts();
    for (std::size_t i = before; i < run_.events.size(); ++i) run_.energy.add(run_.events[i]);
    const double lost = contacts.take_lost();
    run_.energy.ledger.projection -= lost;
    // A run that continues another one, and in which nothing changes, has the memory of that one.
    if (!after_step && !failed && lost == 0 && run_.events.size() == first &&
        std::ranges::equal(closed, run_.world.tree().contacts(), same))
      return true;
    run_.queue.forget_looks();
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
std::size_t ContactRun::points_at_events(std::size_t first) {
  const std::span<const Contact> closed = run_.world.tree().contacts();
  if (closed.size() <= policy::crowded || run_.events.size() == first) return 0;
  run_.world.edit().evaluate();
  std::size_t most = 0;
  for (const std::vector<std::size_t>& island : run_.world.edit().workspace().contacts->rows.islands())
    for (std::size_t i = first; island.size() > most && i < run_.events.size(); ++i) {
      const std::string& one = run_.events[i].contact.one;
      if (one.empty()) continue;
      const int body = run_.world.model().body(one).index;
      if (std::any_of(island.begin(), island.end(), [&](std::size_t k) { return closed[k].a == body || closed[k].b == body; }))
        most = island.size();
    }
  return most;
}

// Impacts of one pair of bodies after the other are those of a body that bounces until it rests, which is followed to the end.
bool ContactRun::flood_of_changes(std::size_t first) {
  const double now = run_.world.time();
  if (!(now <= stepping.window + policy::window_length)) stepping.window = now, stepping.changes = 0;
  if (!(now <= stepping.instant + policy::instant_length)) stepping.instant = now, stepping.changes_at_once = 0;
  if (first > 0) stepping.last = {run_.events[first - 1].contact.one, run_.events[first - 1].contact.other};
  const auto is_last = [&](const Event& e) { return e.contact.one == stepping.last[0] && e.contact.other == stepping.last[1]; };
  const bool bounces = first + 1 == run_.events.size() && is_last(run_.events[first]);
  // A change costs dozens of evaluations, each of which solves for the forces of an island.
  const double crowd = static_cast<double>(points_at_events(first)) / static_cast<double>(policy::crowded);
  const int weight = crowd > 1 ? static_cast<int>(std::ceil(crowd * crowd)) : 1;
  if (!bounces && run_.events.size() > first) stepping.changes += weight;
  stepping.changes_at_once += weight;
  return (stepping.changes > policy::most_changes &&
          stepping.changes * share_of_island(stepping.window) > policy::most_changes) ||
         (stepping.changes_at_once > policy::most_changes_at_once &&
          stepping.changes_at_once * share_of_island(stepping.instant) > policy::most_changes_at_once);
}

// The largest part of the events of contacts since then that happened in one island: many bodies that land each for itself are no
// flood.
double ContactRun::share_of_island(double since) {
  Islands islands(run_.world.tree());
  geometry.stepped.join_touching(islands);
  std::map<int, int> counts;
  int all = 0, most = 0;
  for (auto event = run_.events.rbegin(); event != run_.events.rend() && event->time >= since; ++event) {
    if (event->contact.one.empty()) continue;
    ++all;
    most = std::max(most, ++counts[islands.of(run_.world.model().body(event->contact.one).index)]);
  }
  return all == 0 ? 1 : static_cast<double>(most) / all;
}

// Those whose contacts changed most often.
std::vector<int> ContactRun::bodies_of_flood() const {
  std::map<std::string_view, int> changes;
  std::string_view most;
  for (auto event = run_.events.rbegin(); event != run_.events.rend() && event->time >= stepping.window; ++event) {
    const std::string& one = event->contact.one;
    if (one.empty() || geometry.stepped.holds(run_.world.model().body(one).index)) continue;
    if (++changes[one] > changes[most]) most = one;
  }
  if (!most.empty()) return {run_.world.model().body(most).index};
  return run_.world.tree().contacts().empty() ? std::vector<int>() : slowest_slip_of(geometry.world);
}

// Adaptive steps that contacts keep short beyond reason would never reach the end. With many contacts each of them takes long.
void ContactRun::judge_steps() {
  if (steps_through() || !run_.method->adaptive() || run_.world.tree().contacts().empty()) {
    stepping.steps = 0;
    return;
  }
  const double crowd = static_cast<double>(run_.world.tree().contacts().size()) / static_cast<double>(policy::crowded);
  const int count =
      crowd > 1 ? std::max(policy::least_steps, static_cast<int>(policy::most_steps / (crowd * crowd))) : policy::most_steps;
  if (stepping.steps == 0) stepping.steps_began = run_.world.time();
  if (++stepping.steps <= count) return;
  stepping.steps = 0;
  if (run_.world.time() - stepping.steps_began < count * policy::shortest_steps * run_.integration.step)
    begin_stepping("steps become too short", slowest_slip_of(geometry.world));
}

void ContactRun::note_before_step() {
  before_step_.state = run_.world.edit().state();
  before_step_.ledger = run_.energy.ledger, before_step_.energy = total_energy(run_.world),
  before_step_.proposal = run_.method->proposal();
  before_step_.kinetic = kinetic_by_island(geometry.world);
}

// Where friction leaves hardly any force that keeps a contact closed, forces grow within a step to whatever the arithmetic allows
// (Painlevé). The energy shows it: that of the whole world, or that of an island.
bool ContactRun::gained_energy() {
  constexpr double rounding = 1e-6;  // of all energies
  const auto brought_in = [](const EnergyLedger& l) { return l.work + l.projection - l.dissipated - l.impacts; };
  const double gained =
      total_energy(run_.world) - before_step_.energy - (brought_in(run_.energy.ledger) - brought_in(before_step_.ledger));
  const Totals now = run_.world.totals();
  const double largest = std::max(run_.energy.balance.largest_kinetic, now.kinetic);
  const double all = largest + std::fabs(now.potential);
  if (gained <= rounding * all) return false;
  double unmoved = 0;  // the energy of slip at the speed below which there is none
  for (const int b : run_.world.tree().order()) unmoved += run_.world.tree().link(b).body.m * slowest_slip * slowest_slip;
  if (gained <= std::max(unmoved, rounding * energy_of_heights(run_.world))) return false;
  if (!(gained <= policy::most_gained * largest)) return true;
  if (!(gained > policy::least_height * energy_of_heights(run_.world))) return false;
  const std::vector<double> kinetic = kinetic_by_island(geometry.world);
  for (std::size_t i = 0; i < kinetic.size(); ++i)
    if (gained > policy::most_gained_by_island * kinetic[i] && kinetic[i] - before_step_.kinetic[i] > 0.5 * gained) return true;
  return false;
}

void ContactRun::undo_step() {
  run_.world.edit().state() = before_step_.state;
  run_.energy.ledger = before_step_.ledger;
  run_.method->set_proposal(before_step_.proposal);
}

SteppingState ContactRun::stepping_state() const {
  SteppingState now = stepping;
  now.points = steps.points.all();
  now.released = stepper != nullptr && (some_step() || steps_through()) && steps.points.released();
  now.short_steps = contacts.watches.short_steps();
  if (!run_.world.model().colliders().empty() || std::ranges::any_of(run_.world.model().springs(), &Spring::inextensible))
    now.largest_kinetic = run_.energy.balance.largest_kinetic;
  if (!run_.events.empty()) now.last = {run_.events.back().contact.one, run_.events.back().contact.other};
  return now;
}

void ContactRun::continue_stepping(const SteppingState& from) {
  stepping = from;
  stepping.points.clear(), stepping.unloaded = stepping.excess = -1, stepping.overlap = stepping.largest_kinetic = 0;
  if (from.largest_kinetic > 0) run_.energy.balance.largest_kinetic = from.largest_kinetic;
  contacts.watches.set_short_steps(from.short_steps);
  geometry.stepped.set(stepped_bodies());
  if (stepping.on || method_steps || !steps.points.all().empty()) steps.points.set(from.points, from.released);
}

// Forces or the state changed: the contacts that close may be others, and forces of the last step are out of date.
void ContactRun::update_pending() {
  keeps_closed = false;
  between_runs.set_former(between_runs.closed());
  if (steps.points.has_forces()) steps.points.release();
  if (steps_through() && run_.stops.any())
    find_forces_of_steps();  // contacts that are located would not know of stops that are not
  else
    between_runs.find_pending(method_steps);
}

// A document may be one of another scenario, in which its contacts are no longer those that close.
void ContactRun::check_contacts_of_document(const SteppingState& from) {
  if (!geometry.pairs.any()) return;
  bool hold = between_runs.excess_of_closed() <= from.excess;
  const bool known = from.unloaded >= 0;
  if (hold && (known || !steps.points.all().empty())) {
    constexpr double same = 1e-9;
    hold = (!from.released || known) && steps.still_near() &&
           (!known || std::fabs(unloaded() - from.unloaded) <= same * std::max(1.0, from.unloaded));
  }
  if (hold && known) find_forces_of_steps();
  if (hold) return;
  if (!from.released) steps.points.set({}, true);  // they are those of another scenario
  update_pending();
}

// The norm of the rates of all momenta without the forces of contacts that are stepped through.
double ContactRun::unloaded() {
  const auto count = run_.evaluate.count;
  const auto seconds = run_.evaluate.seconds;
  const bool released = steps.points.released(), had_forces = steps.points.has_forces();
  steps.points.release();
  double sum = 0;
  for (const double rate : run_.world.pdot()) sum += rate * rate;
  steps.points.set(steps.points.all(), released);
  if (had_forces) find_forces_of_steps();
  run_.evaluate_state();
  run_.evaluate.count = count, run_.evaluate.seconds = seconds;
  const double norm = std::sqrt(sum), unit = norm > 0 ? std::exp2(std::ilogb(norm) - 40) : 1;
  return unit * std::round(norm / unit);  // without the last bits, which depend on the order of bodies
}

void ContactRun::report_overlap(const std::string& what) {
  run_.outcome.overlapped = what;
  run_.outcome.message = no_progress_at(run_.world.time()) + what;
  if (run_.statistics.steps == 0 && as_built && !run_.integration.resolve)
    run_.outcome.message += "; resolve = true pushes bodies apart at the start";
  run_.outcome.stalled = true;
}

// Bodies that a run could not keep apart, such as those that are locked, are no reason to refuse the run that continues it.
bool ContactRun::overlaps_as_before(double before) {
  return before > 0 && geometry.pairs.any() && geometry.overlaps.deepest() <= more_overlap * before;
}

// Actions must not make bodies overlap: pushing them apart would bring in energy. Where contacts are located, resolve_contacts()
// finds out unless bodies cross each other. `before`: what time stepping had left (m).
bool ContactRun::overlaps_more_than(double before) {
  const std::optional<Overlap> worst = geometry.overlaps.of_all();
  if (!worst || worst->depth <= std::max(left_by_steps, more_overlap * before)) return false;
  report_overlap(worst->text());
  return true;
}

// The same for a state that was set.
bool ContactRun::overlaps_at_start() {
  if (!std::exchange(stepping.placed, false) || !geometry.pairs.any()) return false;
  const std::optional<Overlap> worst = geometry.overlaps.of_all();
  if (!worst || worst->depth <= left_by_steps) return false;
  stepping.placed = true;
  report_overlap(worst->text());
  return true;
}

}  // namespace momentree
