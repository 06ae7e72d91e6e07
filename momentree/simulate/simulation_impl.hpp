#pragma once
// Implementation of Simulation: steps from event to event. Included only by the files that implement it.
#include <momentree/simulate/simulation.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/base/periodic.hpp>
#include <momentree/base/restored.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/contact/closed_contacts.hpp>
#include <momentree/simulate/contact/contact_start.hpp>
#include <momentree/simulate/contact/contacts.hpp>
#include <momentree/simulate/events/event_queue.hpp>
#include <momentree/simulate/events/instant.hpp>
#include <momentree/simulate/events/stops.hpp>
#include <momentree/simulate/events/strengths.hpp>
#include <momentree/simulate/events/topology_record.hpp>
#include <momentree/simulate/failure.hpp>
#include <momentree/simulate/run_state.hpp>
#include <momentree/simulate/stepping/contact_steps.hpp>

namespace momentree {

namespace detail {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Events times bodies beyond which a dry run would take too long.
inline constexpr std::size_t most_dry_run = 10'000'000;

// Events at one instant, one after the other, beyond which they are assumed to trigger each other endlessly.
inline constexpr std::size_t most_events_at_once = 10'000;

}  // namespace detail

/// The name of events at which bodies pass through each other, within a step or because they overlap.
inline constexpr const char* passed_through = "pass";

/// The energy (J) that gravity gives to bodies which fall by their own size: the scale of energies where all of them are zero.
double energy_of_heights(const World& world);

struct Simulation::Impl {
  using Clock = detail::Clock;
  Impl(const Model& model, const Integration& how)
      : integration(checked(how)),
        world(model, integration.state_variables(model), integration.loop_variables()),
        evaluate(world.tree_, world.workspace_),
        stops(world, evaluate, std::min(how.event_tolerance, 1e-3 * how.step)),
        geometry(world, evaluate),
        contacts(geometry, std::min(how.event_tolerance, 1e-3 * how.step), how.simultaneous, located_step()),
        between_runs(geometry, located_step()),
        contact_steps(geometry) {
    make_methods();
    if (std::optional<Error> error = undetermined_strength(world)) throw_error(std::move(*error));
    if (std::optional<Error> error = unfit_for_contact(model, how.method)) throw_error(std::move(*error));
    if (how.resolve) separate();
    begin();
  }

  /// The present activity, which determines what a callback may do: see Simulation.
  enum class Doing { nothing, observing, watching, working };
  Doing doing = Doing::nothing;
  using During = detail::Restored<Doing>;
  bool idle() const { return doing == Doing::nothing && !world.workspace_.in_function; }
  bool steady() const { return doing != Doing::working && !world.workspace_.in_function; }

  // The length of steps in which contacts are located (s); 0: the method adapts them.
  double located_step() const { return is_adaptive(integration.method) ? 0 : integration.step; }

  /// Pushes bodies apart that overlap; throws Error if that is impossible.
  void separate();

  // The method of steps, and the one that takes its place while contacts are stepped through.
  void make_methods();
  Integrator& present_method() { return stepping.all ? *stepper : *method; }
  const Integrator& present_method() const { return stepping.all ? *stepper : *method; }

  void begin() {
    unadjusted.reset();
    stepping = {}, balance = {}, ledger = {};
    geometry.stepped.set({});
    evaluate_state();
    const Totals t = world.totals();
    balance.initial = t.kinetic + t.potential;
    balance.largest_kinetic = t.kinetic;
    events.clear();
    history.clear();
    recover();
    look_anew();
    keeps_contacts = false;
    between_runs.forget_former();
    between_runs.find_pending(method_steps);
  }
  void update_pending_contacts();
  // The observer's next instant is the first one from now on.
  void look_anew() {
    observed = false;
    if (every > 0) next_look = Periodic(0, every).first_from(world.time());
  }
  double total_energy() {
    const Totals t = world.totals();
    return t.kinetic + t.potential;
  }
  // Books the work of adjustments, which are evaluated only when the ledger is needed.
  void settle() {
    if (!unadjusted) return;
    balance.work += total_energy() - *std::exchange(unadjusted, std::nullopt);
  }
  // A run that diverged may continue from another state or in another world.
  void recover() {
    diverged = continues = false;
    message.clear();
  }

  // Assigns the time and evaluations since the last call to the phase in which they were spent, before or after the first change.
  void book() {
    const auto p = static_cast<std::size_t>(statistics.changes > 0);
    statistics.evaluations[p] += evaluate.count;
    statistics.evaluation_seconds[p] += evaluate.seconds;
    statistics.total_seconds[p] += detail::seconds_since(lap);
    evaluate.count = 0;
    evaluate.seconds = 0;
    lap = Clock::now();
  }

  void evaluate_state() { evaluate(world.state_); }

  // For steps made elsewhere.
  State::Edit edit_state() { return world.state_.edit(); }
  void set_turns(std::span<const Turns> turns) { world.state_.set_turns(turns); }

  // Exact; if the clock is already right, evaluated results stay valid.
  void set_time(double time) {
    if (world.time() != time) world.set_time(time);
  }

  // At a bend of a table, forces are those after the bend: no stage of the step that ends there may use them. The step therefore
  // ends just before it, by so little that no coordinate is affected, and the clock is then corrected.
  static double just_before(double bend) { return bend - 4 * (bend - std::nextafter(bend, -HUGE_VAL)); }

  void ask_for_generated() {
    if (!generated) return;
    const bool loops = stages_take_loop_rates(world.tree_, world.state_.variables());
    if (loops) evaluate_state();  // chooses rows
    const std::span<const int> rows = loops ? chosen_rows(world.tree_, evaluate.workspace()) : std::span<const int>();
    if (asked_for == world.tree_.revision() && std::ranges::equal(rows, asked_for_rows)) return;
    evaluate.use(generated(world.tree_, world.state_.variables(), rows));  // may throw: the provider is then asked again
    asked_for = world.tree_.revision(), asked_for_rows.assign(rows.begin(), rows.end());
  }

  // Where the steps up to `end` or to the next bend really end.
  struct Leg {
    double end;     // the time then is set to this (s)
    double target;  // steps end here
  };
  Leg leg_to(double end) const {
    const double bend = world.next_bend(world.time());
    end = std::min(end, bend);
    return {end, end < bend || end == HUGE_VAL ? end : just_before(end)};
  }
  // The next step towards a target; a step of almost the full length takes the remainder, so that no tiny step follows.
  struct NextStep {
    double h;   // s; not positive: too short to move the clock
    bool last;  // it ends at the target
  };
  NextStep step_from(double time, double target) const {
    const double left = target - time, usual = present_method().next_step(left);
    // The state must advance by exactly the rounded advance of the clock: otherwise the two drift apart by up to an ulp of the
    // time per step, always in the same direction.
    return usual == left ? NextStep{left, true} : NextStep{(time + usual) - time, false};
  }
  void note_short_step(double target);
  bool step_towards(double end);
  bool step_and_look(double h, double end, Clock::time_point start);

  /// The number of a joint that a function may drive; throws Error.
  int to_drive(std::string_view joint, bool function) const;

  std::size_t schedule(EventQueue::Entry entry) {
    continues = false;
    entry.event.name = "#" + std::to_string(queue.entries.size() + 1);
    return queue.add(std::move(entry));
  }

  // Impacts, rests and releases at hard stops.
  void resolve_limits() {
    const std::size_t before = events.size();
    stops.resolve_limits(events);
    if (stops.blocked() >= 0) report_blocked_stop();
    if (events.size() == before) return;
    for (std::size_t i = before; i < events.size(); ++i) add_to_balance(events[i]);
    queue.forget_looks();
    world.take_variables(world.own_variables());
  }

  // Impacts of bodies, and contacts that close, open, slip or stick. False: there is no solution, and the run ends.
  // `after_step`: not at the start, nor after an action, where an overlap is a mistake.
  bool resolve_contacts(bool after_step = false);
  std::optional<Contacts::Unresolved> resolve_stops_and_contacts();
  bool resolve_after_step(double h);
  bool resolve_in_turn(bool due, bool after_step = false);
  std::span<const Watch> watches(double& h);

  // Contacts that are stepped through instead of being located: of all bodies, or of some islands.
  bool steps_through() const { return stepping.all || method_steps; }
  bool some_step() const { return stepping.on && !stepping.all; }
  void report_passes();
  void note_overlaps();
  Event pass_of(int one, int other, const Vec3& point, const Vec3& normal) const;
  void begin_stepping(const std::string& why, const std::vector<int>& at);
  std::vector<bool> stepped_bodies() const;
  void update_islands();
  void join_touched_islands();
  void step_islands(double h);
  void find_forces_of_steps();
  void try_to_locate(const Islands& islands, int number);
  void after_contact_step();
  void report_stepping(const char* what, const std::string& why, const std::vector<int>& bodies);
  bool flood_of_changes(std::size_t first);
  double share_of_island(double since);
  std::size_t points_at_events(std::size_t first);
  std::vector<int> bodies_of_flood() const;
  void judge_steps();
  void note_before_contact_step();
  bool contacts_gained_energy();
  void undo_contact_step();
  SteppingState stepping_state() const;
  void continue_stepping(const SteppingState& from);
  void check_contacts_of_document(const SteppingState& from);
  double unloaded();
  void report_overlap(const std::string& what);
  std::string moving_joints() const;
  bool has_motions() const { return !world.tree_.driven_joints().empty() || world.tree_.loop_motions() > 0; }
  void report_blocked_stop();
  void report_pressing(double gained);
  double energy_scale();
  bool overlaps_more_than(double depth);
  bool overlaps_as_before(double before);
  bool overlaps_at_start();

  // Kinetic energy at the beginning of a step, which has been evaluated: as p·u/2 it costs next to nothing.
  void note_kinetic_energy() {
    double kinetic = 0;
    if (world.tree_.driven_joints().empty() && world.tree_.loop_armatures() + world.tree_.loop_motions() == 0) {
      const auto p = world.p();
      for (std::size_t i = 0; i < p.size(); ++i) kinetic += p[i] * world.workspace_.v[i];
      kinetic *= 0.5;
    } else {  // driven DoFs and armatures of loop joints have no momentum there
      kinetic = world.totals().kinetic;
    }
    balance.largest_kinetic = std::max(balance.largest_kinetic, kinetic);
  }

  void add_to_balance(const Event& event) {
    balance.largest_kinetic = std::max({balance.largest_kinetic, event.before.kinetic, event.after.kinetic});
    balance.released += event.released;
    balance.lost_in_impacts += event.lost;
    balance.work += event.work;
  }

  void report_divergence(double h) {
    evaluate_state();  // of the last good state
    message = divergence_text(world, present_method(), integration, h);
    diverged = true;
  }

  // carry_out.cpp
  /// Carries out everything that is due now, then one by one the events that it triggers. False: an action was refused; the
  /// events before it at this instant have happened.
  bool happen();
  /// Carries out actions from outside, whose names have been checked, as one event of this instant. False, with a message: they
  /// were refused, and nothing has happened.
  bool act(std::span<const Action> actions, const std::string& name);
  bool carry_out_now(std::span<const DueEvent> due);
  bool try_now(std::span<const DueEvent> due);
  InstantReport carry_out_with_passes(std::span<const DueEvent> due, bool dry_run);
  std::pair<std::size_t, std::size_t> overlapping_action(std::span<const DueEvent> due);
  static ActionResult refused_overlap(const std::string& what);

  std::span<const Event> events_now() const {
    std::size_t first = events.size();
    while (first > 0 && events[first - 1].time == world.time()) --first;
    return {events.data() + first, events.size() - first};
  }

  /// Runs `act`, which adds or removes bodies, and records it as an event named `what`.
  template <class Act>
  void populate(const char* what, const std::string& body, Act act);
  /// Adds a body to the world; throws Error, with nothing changed, if it overlaps others for good.
  BodyId add(BodySpec spec, std::vector<contact::Solid> collision);
  std::optional<Error> find_room(BodyId body);

  DryRun dry_run();

  // run_state.cpp
  SimulationSnapshot snapshot();
  void restore_run(const SimulationSnapshot& to);
  void go_back(const SimulationSnapshot& to);
  RunState run_state();
  void continue_from(const RunState& from);

  std::optional<Error> unknown_name(const Action& action) const {
    return momentree::unknown_name(world, queue, action->joints(), action->bodies(), action->takes_springs());
  }
  void check_names(const Action& action) const {
    if (std::optional<Error> error = unknown_name(action)) throw_error(std::move(*error));
  }

  bool look(bool force) {
    if (!observer || (observed && observed_at == world.time())) return true;
    if (!force && every > 0 && world.time() < next_look) return true;
    observed = true;
    observed_at = world.time();
    if (every > 0) next_look = Periodic(0, every).first_after(world.time());
    evaluate_state();
    const During observing(doing, Doing::observing);
    return observer(world);
  }
  bool sampled() {
    if (!sampler) return true;
    evaluate_state();
    const During observing(doing, Doing::observing);
    return sampler(world);
  }
  // Events of the instant, with samples of the states before and after them.
  bool happen_between_samples(Status& status) {
    if (!sampled()) status = Status::interrupted;
    const std::size_t before = events.size();
    if (status == Status::ok && !happen()) status = Status::refused;
    if (status == Status::ok && events.size() != before && !sampled()) status = Status::interrupted;
    return status == Status::ok;
  }
  bool watched() {
    const During watching(doing, Doing::watching);
    return !watcher || watcher(world.time());
  }

  // What happens at the present instant before the first step.
  Status begin_run() {
    progress.begin(world.time(), events.size());
    if (overlaps_at_start()) return Status::stalled;
    const bool may_keep = std::exchange(keeps_contacts, false) && !between_runs.has_former();
    between_runs.open_pending();
    const bool kept = may_keep && (stepping.on || !between_runs.closed().empty());
    if (!resolve_in_turn(!kept)) return Status::stalled;
    between_runs.forget_former();
    Status status = Status::ok;
    return happen_between_samples(status) && !look(!observed) ? Status::interrupted : status;
  }
  EventSources event_sources() {
    EventSources from{world.model_.colliders().size() + world.model_.springs().size() + stops.count() + queue.count()};
    for (const EventQueue::Entry& entry : queue.entries)
      if (entry.period > 0) from.repeated += 1 / entry.period;
    return from;
  }
  // After each step.
  Status note_progress(double until) {
    auto why = progress.step(world, present_method(), integration, events, until);
    if (!why && may_be_flood(events, world.time(), integration.step))
      why = flood_text(events, world.time(), integration.step, event_sources());
    if (why) message = *why;
    return why ? Status::stalled : Status::ok;
  }

  // A run: start_run(), then to each instant of next_end() by steps that finish_step() follows, then end_run().
  Status start_run(double until) {
    stalled = false;
    lap = Clock::now();
    return std::exchange(continues, false) ? note_progress(until) : begin_run();
  }
  // The instant at which the next steps must end.
  double next_end(double until) const {
    const double end = std::min({until, queue.next_time(), next_rest(geometry.world)});
    return observer && every > 0 ? std::min(end, next_look) : end;
  }
  Status finish_step(double until) {
    find_forces_of_steps();
    Status status = Status::ok;
    if (!happen_between_samples(status)) return status;
    return look(false) && watched() ? note_progress(until) : Status::interrupted;
  }
  Status advance(double until, Status status) {
    while (status == Status::ok && world.time() < until)
      status = step_towards(next_end(until)) ? finish_step(until) : stalled ? Status::stalled : Status::diverged;
    return status;
  }
  RunResult end_run(Status status) {
    // Some actions of an event that was refused may have changed what acts.
    if (status == Status::refused && geometry.pairs.any() && !steps_through()) static_cast<void>(resolve_contacts());
    if (status == Status::refused || status == Status::diverged) find_forces_of_steps();
    if (status != Status::interrupted && !look(true)) status = Status::interrupted;
    evaluate_state();
    book();
    const bool explained = status != Status::ok && status != Status::interrupted;
    // Functions may depend on what changes between runs.
    keeps_contacts = !explained && !world.tree_.has_functions() && world.tree_.body_functions().empty();
    return result = {status, explained ? message : std::string()};
  }

  RunResult run(double until) {
    settle();
    if (diverged) return result = {Status::diverged, message};
    const During working(doing, Doing::working);
    return end_run(advance(until, start_run(until)));
  }

  Integration integration;
  World world;
  Evaluator evaluate;
  std::unique_ptr<Integrator> method;
  Stops stops;
  ContactGeometry geometry;
  Contacts contacts;
  ContactsBetweenRuns between_runs;
  ContactSteps contact_steps;
  std::unique_ptr<Integrator> stepper;  // only with contacts
  bool method_steps = false;            // the method itself steps through contacts
  SteppingState stepping;
  struct BeforeStep {
    State state{};
    EnergyLedger ledger{};
    double energy = 0, proposal = 0;
    std::vector<double> kinetic;  // by island
  };
  BeforeStep before_step;  // of a step with closed contacts
  std::vector<Watch> all_watches;
  EnergyLedger ledger;
  EnergyBalance balance;
  std::optional<double> unadjusted;  // total energy (J) before adjustments that are not in the ledger yet
  RunStatistics statistics;
  EventQueue queue;
  struct Past {
    std::size_t events;  ///< number of events that had happened before
    SimulationSnapshot before;
    std::vector<std::size_t> places;  ///< places in the queue of the events that were due
  };
  // The snapshot from before the instant of that event; null: none was kept.
  const Past* before(std::size_t event) const {
    for (const Past& past : history) {
      const bool last = &past == &history.back();
      if (event >= past.events && event < (last ? events.size() : (&past + 1)->events)) return &past;
    }
    return nullptr;
  }
  bool keeps_history = false;
  std::vector<Past> history;
  std::vector<Event> events;
  std::string message;                    // the reason, as soon as it is known
  RunResult result;                       // of the last call that returned one
  std::optional<std::string> overlapped;  // which bodies, when report_overlap() was called last
  bool as_built = true;                   // the state is that of the model, in which `resolve` pushes bodies apart
  bool diverged = false, stalled = false;
  bool continues = false;       // the next run continues one that was between two steps
  bool keeps_contacts = false;  // the next run may begin with the closed contacts
  ProgressMonitor progress;
  double every = 0, next_look = 0, observed_at = 0;
  bool observed = false;
  std::function<bool(const World&)> observer;
  std::function<bool(const World&)> sampler;
  std::function<bool(double)> watcher;
  RatesProvider generated;
  std::optional<std::uint64_t> asked_for;  // the revision of the tree for which the provider was last called
  std::vector<int> asked_for_rows;         // and the chosen rows of its loops
  Clock::time_point lap = Clock::now();
};

}  // namespace momentree
