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
#include <momentree/simulate/contact/contact_run.hpp>
#include <momentree/simulate/events/event_queue.hpp>
#include <momentree/simulate/events/instant.hpp>
#include <momentree/simulate/events/stops.hpp>
#include <momentree/simulate/events/strengths.hpp>
#include <momentree/simulate/events/topology_record.hpp>
#include <momentree/simulate/failure.hpp>
#include <momentree/simulate/run_parts.hpp>
#include <momentree/simulate/run_state.hpp>

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

inline constexpr const char* callback_schedules = "of the callbacks, only those of observe() and watch() schedule events";

/// The energy (J) that gravity gives to bodies which fall by their own size: the scale of energies where all of them are zero.
double energy_of_heights(const World& world);

/// True if the motion of a joint is prescribed.
inline bool has_motions(const Tree& tree) { return !tree.joints_with().motions.empty() || tree.loops().motions > 0; }

/// Where the steps up to `end` or to the next bend really end. At a bend of a table, forces are those after the bend: no stage of
/// the step that ends there may use them. The step therefore ends just before it, by so little that no coordinate is affected,
/// and the clock is then corrected.
struct Leg {
  double end;     ///< the time then is set to this (s)
  double target;  ///< steps end here
};
inline Leg leg_to(const World& world, double end) {
  const double bend = next_bend(world.tree(), world.time());
  end = std::min(end, bend);
  return {end, end < bend || end == HUGE_VAL ? end : bend - 4 * (bend - std::nextafter(bend, -HUGE_VAL))};
}

/// The next step towards a target; a step of almost the full length takes the remainder, so that no tiny step follows.
struct NextStep {
  double h;   ///< s; not positive: too short to move the clock
  bool last;  ///< it ends at the target
};
inline NextStep step_from(const Integrator& method, double time, double target) {
  const double left = target - time, usual = method.next_step(left);
  // The state must advance by exactly the rounded advance of the clock: otherwise the two drift apart by up to an ulp of the
  // time per step, always in the same direction.
  return usual == left ? NextStep{left, true} : NextStep{(time + usual) - time, false};
}

struct Simulation::Impl {
  using Doing = Activity::Doing;
  using During = Activity::During;

  Impl(const Model& model, const Integration& how)
      : integration(checked(how)),
        world(model, integration.state_variables(model), integration.loop_variables()),
        evaluate(world.tree(), world.edit().workspace()),
        activity(evaluate.workspace()),
        stops(world, evaluate, tolerance()),
        contact(*this, tolerance(), is_adaptive(integration.method) ? 0 : integration.step) {
    make_methods();
    if (std::optional<Error> error = undetermined_strength(world)) throw_error(std::move(*error));
    if (std::optional<Error> error = unfit_for_contact(model, how.method)) throw_error(std::move(*error));
    if (how.resolve) contact.separate();
    begin();
  }

  // The method of steps, and the one that takes its place while contacts are stepped through.
  void make_methods();
  void begin() {
    energy = {};
    contact.stepping = {};
    contact.geometry.stepped.set({});
    evaluate_state();
    energy.begin(world);
    events.clear();
    history.instants.clear();
    recover();
    observers.look_anew(world.time());
    contact.keeps_closed = false;
    contact.between_runs.forget_former();
    contact.between_runs.find_pending(contact.method_steps);
  }
  // A run that diverged may continue from another state or in another world.
  void recover() {
    outcome.diverged = continues = false;
    outcome.message.clear();
  }

  void evaluate_state() { evaluate(world.edit().state()); }
  // Exact; if the clock is already right, evaluated results stay valid.
  void set_time(double time) {
    if (world.time() != time) world.edit().set_time(time);
  }

  std::size_t schedule(EventQueue::Entry entry) {
    continues = false;
    entry.event.name = "#" + std::to_string(queue.entries.size() + 1);
    return queue.add(std::move(entry));
  }
  std::optional<Error> unknown_name(const Action& action) const {
    return momentree::unknown_name(world, queue, action->joints(), action->bodies(), action->takes_springs());
  }
  /// Carries out actions from outside, whose names have been checked, as one event of this instant. False, with a message: they
  /// were refused, and nothing has happened.
  bool act(std::span<const Action> actions, const std::string& name);
  /// Adds a body to the world; throws Error, with nothing changed, if it overlaps others for good.
  BodyId add(BodySpec spec, std::vector<contact::Solid> collision);
  void remove(BodyId body);
  DryRun dry_run();
  // Impacts, rests and releases at hard stops.
  void resolve_limits() {
    const std::size_t before = events.size();
    stops.resolve_limits(events);
    if (stops.blocked() >= 0) report_blocked_stop();
    if (events.size() == before) return;
    for (std::size_t i = before; i < events.size(); ++i) energy.add(events[i]);
    queue.forget_looks();
    world.edit().take_own_variables();
  }

  // run_state.cpp
  SimulationSnapshot snapshot();
  void go_back(const SimulationSnapshot& to);
  RunState run_state();
  void continue_from(const RunState& from);

  // A run: start_run(), then to each instant of next_end() by steps that finish_step() follows, then end_run().
  RunResult run(double until) {
    energy.settle(world);
    if (outcome.diverged) return outcome.result = {Status::diverged, outcome.message};
    const During working(activity.doing, Doing::working);
    return end_run(advance(until, start_run(until)));
  }
  Status start_run(double until) {
    outcome.stalled = false;
    lap = Clock::now();
    return std::exchange(continues, false) ? note_progress(until) : begin_run();
  }
  // The instant at which the next steps must end.
  double next_end(double until) const {
    const double end = std::min({until, queue.next_time(), next_rest(contact.geometry.world)});
    return observers.observer && observers.every > 0 ? std::min(end, observers.next_look) : end;
  }
  void note_short_step(double target);
  Status finish_step(double until) {
    contact.find_forces_of_steps();
    Status status = Status::ok;
    if (!happen_between_samples(status)) return status;
    return look(false) && watched() ? note_progress(until) : Status::interrupted;
  }
  Status advance(double until, Status status) {
    while (status == Status::ok && world.time() < until)
      status = step_towards(next_end(until)) ? finish_step(until) : outcome.stalled ? Status::stalled : Status::diverged;
    return status;
  }
  RunResult end_run(Status status) {
    // Some actions of an event that was refused may have changed what acts.
    if (status == Status::refused && contact.geometry.pairs.any() && !contact.steps_through())
      static_cast<void>(contact.resolve_contacts());
    if (status == Status::refused || status == Status::diverged) contact.find_forces_of_steps();
    if (status != Status::interrupted && !look(true)) status = Status::interrupted;
    evaluate_state();
    book();
    const bool explained = status != Status::ok && status != Status::interrupted;
    // Functions may depend on what changes between runs.
    contact.keeps_closed = !explained && !has_functions(world.tree()) && world.tree().loads().functions.empty();
    return outcome.result = {status, explained ? outcome.message : std::string()};
  }

  Integration integration;
  World world;
  Evaluator evaluate;
  Activity activity;
  std::unique_ptr<Integrator> method;
  Stops stops;
  ContactRun contact;
  EnergyBook energy;
  RunStatistics statistics;
  EventQueue queue;
  RunHistory history;
  std::vector<Event> events;
  Outcome outcome;
  Observers observers;
  GeneratedStages generated;
  bool continues = false;  // the next run continues one that was between two steps

 private:
  using Clock = detail::Clock;

  double tolerance() const { return std::min(integration.event_tolerance, 1e-3 * integration.step); }
  Integrator& present_method() { return contact.stepping.all ? *contact.stepper : *method; }

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
  void ask_for_generated() {
    if (!generated.provider) return;
    const bool loops = stages_take_loop_rates(world.tree(), world.state().variables());
    if (loops) evaluate_state();  // chooses rows
    const std::span<const int> rows = loops ? chosen_rows(world.tree(), evaluate.workspace()) : std::span<const int>();
    if (generated.asked_for == world.tree().revision() && std::ranges::equal(rows, generated.rows)) return;
    // May throw: the provider is then asked again.
    evaluate.use(generated.provider(world.tree(), world.state().variables(), rows));
    generated.asked_for = world.tree().revision(), generated.rows.assign(rows.begin(), rows.end());
  }
  bool step_towards(double end);
  bool step_and_look(double h, double end, Clock::time_point start);
  // Kinetic energy at the beginning of a step, which has been evaluated: as p·u/2 it costs next to nothing.
  void note_kinetic_energy() {
    double kinetic = 0;
    if (world.tree().joints_with().motions.empty() && world.tree().loops().armatures + world.tree().loops().motions == 0) {
      const auto p = world.p();
      for (std::size_t i = 0; i < p.size(); ++i) kinetic += p[i] * evaluate.workspace().v[i];
      kinetic *= 0.5;
    } else {  // driven DoFs and armatures of loop joints have no momentum there
      kinetic = world.totals().kinetic;
    }
    energy.balance.largest_kinetic = std::max(energy.balance.largest_kinetic, kinetic);
  }
  double energy_scale();
  void report_divergence(double h) {
    evaluate_state();  // of the last good state
    outcome.message = divergence_text(world, present_method(), integration, h);
    outcome.diverged = true;
  }
  std::string moving_joints() const;
  void report_blocked_stop();
  void report_pressing(double gained);

  // carry_out.cpp
  /// Carries out everything that is due now, then one by one the events that it triggers. False: an action was refused; the
  /// events before it at this instant have happened.
  bool happen();
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
  BodyId add_with_room(BodySpec spec, std::vector<contact::Solid> collision);
  std::optional<Error> find_room(BodyId body);

  void restore_run(const SimulationSnapshot& to);

  bool look(bool force) {
    if (!observers.is_due(world.time(), force)) return true;
    observers.note_look(world.time());
    evaluate_state();
    const During observing(activity.doing, Doing::observing);
    return observers.observer(world);
  }
  bool sampled() {
    if (!observers.sampler) return true;
    evaluate_state();
    const During observing(activity.doing, Doing::observing);
    return observers.sampler(world);
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
    const During watching(activity.doing, Doing::watching);
    return !observers.watcher || observers.watcher(world.time());
  }

  // What happens at the present instant before the first step.
  Status begin_run() {
    progress.begin(world.time(), events.size());
    if (contact.overlaps_at_start()) return Status::stalled;
    const bool may_keep = std::exchange(contact.keeps_closed, false) && !contact.between_runs.has_former();
    contact.between_runs.open_pending();
    const bool kept = may_keep && (contact.stepping.on || !contact.between_runs.closed().empty());
    if (!contact.resolve_in_turn(!kept)) return Status::stalled;
    contact.between_runs.forget_former();
    Status status = Status::ok;
    return happen_between_samples(status) && !look(!observers.observed) ? Status::interrupted : status;
  }
  EventSources event_sources() {
    EventSources from{world.model().colliders().size() + world.model().springs().size() + stops.count() + queue.count()};
    for (const EventQueue::Entry& entry : queue.entries)
      if (entry.period > 0) from.repeated += 1 / entry.period;
    return from;
  }
  // After each step.
  Status note_progress(double until) {
    auto why = progress.step(world, present_method(), integration, events, until);
    if (!why && may_be_flood(events, world.time(), integration.step))
      why = flood_text(events, world.time(), integration.step, event_sources());
    if (why) outcome.message = *why;
    return why ? Status::stalled : Status::ok;
  }

  ProgressMonitor progress;
  Clock::time_point lap = Clock::now();
};

}  // namespace momentree
