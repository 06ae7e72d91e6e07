#pragma once
// What a Simulation is inside: how it steps from event to event. Included by simulation.cpp alone.
#include <momentree/simulate/simulation.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>

#include <momentree/base/error.hpp>
#include <momentree/base/restored.hpp>
#include <momentree/dynamics/energy.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/agenda.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/instant.hpp>
#include <momentree/simulate/stops.hpp>
#include <momentree/simulate/trouble.hpp>

namespace momentree {

namespace detail {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Events times bodies, beyond which a rehearsal would take longer than it is worth.
inline constexpr std::size_t most_rehearsed = 10'000'000;

// Events of one instant, one after the other, beyond which they are taken to bring about each other without end.
inline constexpr std::size_t most_events_at_once = 10'000;

}  // namespace detail

struct Simulation::Impl {
  using Clock = detail::Clock;
  Impl(const Model& model, const Integration& how)
      : integration(checked(how)),
        world(model),
        evaluate(world.tree_, world.work_),
        method(new_method()),
        stops(world, evaluate, std::min(how.event_tolerance, 1e-3 * how.step)) {
    begin();
  }

  /// What is going on, and so what a callback may do: see Simulation.
  enum class Doing { nothing, observing, working };
  Doing doing = Doing::nothing;
  using During = detail::Restored<Doing>;
  bool idle() const { return doing == Doing::nothing && !world.work_.in_function; }
  bool steady() const { return doing != Doing::working && !world.work_.in_function; }

  std::unique_ptr<Integrator> new_method() const {
    return make_integrator(integration.method, world.tree_,
                           {integration.step, integration.rtol, integration.atol, integration.max_step});
  }

  void begin() {
    evaluate_state();
    balance = {};
    books = {};
    const Totals t = world.totals();
    balance.initial = t.kinetic + t.potential;
    balance.largest_kinetic = t.kinetic;
    events.clear();
    history.clear();
    observed = false;
    recover();
  }
  // What ran away may go on from another state, or in another world.
  void recover() {
    diverged = false;
    message.clear();
  }

  // Clock and evaluations since the last call go to the phase, before or after the first change, in which they were spent.
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

  // Exactly; a clock that is right already leaves what was evaluated as it is.
  void set_time(double time) {
    if (world.time() != time) world.set_time(time);
  }

  // Where a table bends, forces are those of what follows: no stage of the step that ends there may see them. It ends so little
  // before it that no coordinate knows, and the clock is then put right.
  static double just_before(double bend) { return bend - 4 * (bend - std::nextafter(bend, -HUGE_VAL)); }

  void ask_for_generated() {
    if (!generated || asked_for == world.tree_.revision()) return;
    evaluate.use(generated(world.tree_));  // may throw: then it is asked again
    asked_for = world.tree_.revision();
  }

  // One step that ends at `end`; a step of almost the full length takes what is left, so that no sliver follows.
  bool step_towards(double end) {
    const double bend = world.next_bend(world.time());
    end = std::min(end, bend);
    const double left = (end < bend || end == HUGE_VAL ? end : just_before(end)) - world.time();
    if (left <= 0) {
      set_time(end);
      return true;
    }
    const double usual = method->next_step(left);
    const bool last = usual == left;
    // What the clock advances, which is rounded, is what the state advances: else they part by up to an ulp of the time per step,
    // always to the same side.
    const double h = last ? left : (world.time() + usual) - world.time();
    if (!(h > 0)) {
      message = no_progress_at(world.time()) + "a step of " + detail::text(usual) + " s is too short to move the clock";
      stalled = true;
      return false;
    }
    ask_for_generated();
    const auto start = Clock::now();
    evaluate_state();
    note_kinetic_energy();
    if (stops.any() || agenda.watching(world)) return step_and_look(h, last ? end : HUGE_VAL, start);
    const double stepped = method->advance(evaluate, world.state_, books, h);
    if (stepped == 0) {
      report_divergence(h);
      return false;
    }
    if (last && stepped == h) set_time(end);
    ++statistics.steps;
    const double taken = detail::seconds_since(start);
    statistics.worst_step_seconds = std::max(statistics.worst_step_seconds, taken);
    return true;
  }

  // The same where joints have stops or events conditions: the step may end earlier, and something happen there. `end`: what a
  // whole step ends at.
  bool step_and_look(double h, double end, Clock::time_point start) {
    const std::optional<double> stepped = stops.step(*method, books, h, agenda.watches(world));
    if (!stepped) {
      report_divergence(h);
      return false;
    }
    if (*stepped == h && std::isfinite(end)) set_time(end);
    ++statistics.steps;
    settle();
    statistics.worst_step_seconds = std::max(statistics.worst_step_seconds, detail::seconds_since(start));
    return true;
  }

  // The number of a joint that a function may drive, or an error.
  int to_drive(std::string_view joint, bool function) const {
    const int number = world.find_joint(joint);
    if (number < 0) {
      world.model().joint(joint);  // throws where there never was one
      fail({"the joint '" + std::string(joint) + "' is not there any more", "", ""});
    }
    const JointView view = world.joint({number});
    if (view.v.empty()) fail({"the joint '" + std::string(joint) + "' has no freedom to drive", "", ""});
    const JointDrive* drive = view.parameters != nullptr ? view.parameters->drive.get() : nullptr;
    if (function && drive != nullptr && drive->moves())
      fail({"the motion of joint '" + std::string(joint) + "' is prescribed", "", "take its drive away first"});
    return number;
  }

  std::size_t schedule(Agenda::Entry entry) {
    entry.event.name = "#" + std::to_string(agenda.entries.size() + 1);
    return agenda.add(std::move(entry));
  }

  // Impacts, rests and releases at hard stops.
  void settle() {
    const std::size_t before = events.size();
    stops.settle(events);
    for (std::size_t i = before; i < events.size(); ++i) add_to_balance(events[i]);
    if (events.size() != before) agenda.forget_looks();
  }

  // Kinetic energy at the beginning of a step, which was evaluated: by p·u/2 it costs next to nothing.
  void note_kinetic_energy() {
    double kinetic = 0;
    if (world.tree_.driven_joints().empty()) {
      const auto p = world.state_.p();
      for (std::size_t i = 0; i < p.size(); ++i) kinetic += p[i] * world.work_.v[i];
      kinetic *= 0.5;
    } else {  // what is driven has no momentum
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
    message = divergence_text(world, *method, integration, h);
    diverged = true;
  }

  // Everything that is due now, then one by one what comes true by it. False: something was refused; what came before it at this
  // instant has happened.
  bool happen() {
    for (std::size_t count = 0;; ++count) {
      std::vector<std::size_t> places = agenda.due(world.time());
      if (places.empty() && agenda.watching(world)) {
        evaluate_state();
        if (const std::optional<std::size_t> place = agenda.urgent(world, events_now())) places = {*place};
      }
      if (places.empty()) return true;
      if (count > detail::most_events_at_once) {
        message = "more than " + std::to_string(detail::most_events_at_once) + " events at t = " + detail::text(world.time()) +
                  " s, the last of them " + last_events(events) + "; does one bring about the other, at no delay?";
        return false;
      }
      std::vector<DueEvent> due;
      for (const std::size_t k : places) due.push_back(agenda.at(k).event);
      if (keeps_history) history.push_back({events.size(), snapshot(), places});
      if (!carry_out_now(due)) {
        if (keeps_history) history.pop_back();
        return false;
      }
      for (const std::size_t k : places) agenda.happened(k, world.time());
    }
  }

  /// Actions from outside, whose names are known, as one event of this instant. False, with a message: refused.
  bool act(std::span<const Action> actions, const std::string& name) {
    const During working(doing, Doing::working);
    DueEvent due{name.empty() ? "#" + std::to_string(agenda.entries.size() + events.size() + 1) : name, !name.empty(), {}};
    due.actions.assign(actions.begin(), actions.end());
    if (keeps_history) history.push_back({events.size(), snapshot(), {}});
    if (carry_out_now({&due, 1})) return true;
    if (keeps_history) history.pop_back();
    return false;
  }

  std::span<const Event> events_now() const {
    std::size_t first = events.size();
    while (first > 0 && events[first - 1].time == world.time()) --first;
    return {events.data() + first, events.size() - first};
  }

  bool carry_out_now(std::span<const DueEvent> due) {
    evaluate_state();
    if (statistics.changes == 0) book();
    WorldSnapshot before;
    const bool stopped = stops.any();
    if (stopped) before = world.snapshot();
    InstantReport report = carry_out(world, due);
    // A stop that would have had to pull in an impact was let go of before it: once more, without it.
    for (bool again = stopped; again && !report.refused;) {
      const WorldSnapshot after = world.snapshot();
      world.restore(before);
      again = stops.release_pulled(report.events);
      if (again) {
        before = world.snapshot();
        report = carry_out(world, due);
      } else {
        world.restore(after);
      }
    }
    statistics.changes += report.changes;
    statistics.topology_seconds += report.seconds;
    if (report.refused) {
      message = report.message;
      return false;
    }
    evaluate_state();
    for (Event& event : report.events) {
      add_to_balance(event);
      events.push_back(std::move(event));
    }
    agenda.forget_looks();
    settle();
    return true;
  }

  // What bodies bring into the world and take out of it is work; the event's certificate says how much.
  template <class Act>
  void populate(std::string what, Act act) {
    const During working(doing, Doing::working);
    Event event;
    event.time = world.time();
    event.name = what.substr(0, what.find(' '));
    event.mechanisms_before = world.mechanism_names();
    event.before = world.totals();
    std::optional<SimulationSnapshot> past;
    if (keeps_history) past = snapshot();
    act();  // or throws, and nothing happened
    if (past) history.push_back({events.size(), std::move(*past), {}});
    method = new_method();
    evaluate_state();
    event.after = world.totals();
    event.mechanisms_after = world.mechanism_names();
    event.work = event.after.kinetic + event.after.potential - event.before.kinetic - event.before.potential;
    event.actions = {std::move(what)};
    balance.work += event.work;
    events.push_back(std::move(event));
    agenda.forget_looks();
    settle();
  }

  Rehearsal rehearse() {
    const During working(doing, Doing::working);
    Rehearsal found;
    const WorldSnapshot start = world.snapshot();
    std::set<std::pair<std::string, Kind>> joints;
    const auto look_at_joints = [&, &tree = world.tree_] {
      for (const int b : tree.order()) joints.emplace(world.names_.joint(tree.joint_of(b)), tree.joint(b).kind);
    };
    look_at_joints();
    // Instants that are known come first, in their order; the others follow one by one, where nothing can be said of troubles.
    using Turn = Agenda::Turn;
    std::vector<Turn> order;
    bool certain = true;
    for (std::size_t k = 0; k < agenda.entries.size(); ++k) {
      const Agenda::Entry& e = agenda.entries[k];
      if (e.done) continue;
      double time = e.time;
      for (const Agenda::Entry& other : agenda.entries)
        if (!e.after.empty() && other.event.name == e.after) time = std::min(time, other.time + e.delay);
      certain = certain && std::isfinite(time);
      order.push_back({time, !e.after.empty() && e.delay == 0, k});
    }
    std::stable_sort(order.begin(), order.end(), [this](const Turn& a, const Turn& b) {
      if (a.time != b.time || !std::isfinite(a.time)) return a.time < b.time;
      return std::pair(a.follows, agenda.entries[a.entry].rank) < std::pair(b.follows, agenda.entries[b.entry].rank);
    });
    std::vector<DueEvent> breaks;  // of joints that can break by themselves, those that events make or make weaker among them
    const auto add_breaks = [&] {
      for (const Strength& s : strengths(world)) {
        std::string name = event_name(world, s);
        if (std::any_of(breaks.begin(), breaks.end(), [&](const DueEvent& known) { return known.name == name; })) continue;
        breaks.push_back({std::move(name), false, {break_joint(std::string(world.joint_name({s.joint})))}});
        order.push_back({HUGE_VAL, false, agenda.entries.size() + breaks.size() - 1});
        certain = false;
      }
    };
    add_breaks();
    const std::size_t n = agenda.entries.size();
    const auto event_at = [&](std::size_t k) { return k < n ? agenda.entries[k].event : breaks[k - n]; };
    found.complete = order.size() * static_cast<std::size_t>(world.tree_.bodies()) <= detail::most_rehearsed;
    for (std::size_t i = 0; found.complete && i < order.size();) {
      std::vector<DueEvent> due;
      const std::size_t begin = i;
      const double time = order[i].time;
      do {
        due.push_back(event_at(order[i].entry));
      } while (++i < order.size() && order[i].time == time && order[i].follows == order[begin].follows && std::isfinite(time));
      if (std::isfinite(time)) world.set_time(time);
      const InstantReport report = carry_out(world, due, true);
      for (const ActionReport& action : report.actions)
        if (certain && action.verdict.outcome != Verdict::Outcome::done)
          found.troubles.push_back({order[begin + action.event].entry, action.action, action.verdict,
                                    action.verdict.outcome == Verdict::Outcome::refused ? report.message : ""});
      found.complete = !report.lost;
      add_breaks();
      look_at_joints();
    }
    world.restore(start);
    found.joints.assign(joints.begin(), joints.end());
    return found;
  }

  SimulationSnapshot snapshot() const {
    SimulationSnapshot all{world.snapshot(), {}, events.size(), balance};
    all.proposal = method->proposal();
    all.balance.dissipated = books.dissipated;
    all.balance.work = books.work;
    all.impulsive_work = balance.work;
    all.armed = agenda.armed();
    return all;
  }

  void go_back(const SimulationSnapshot& to) {
    const int bodies = world.tree_.bodies();
    world.restore(to.world);
    if (world.tree_.bodies() != bodies) method = new_method();
    method->set_proposal(to.proposal);
    balance = to.balance;
    books.dissipated = to.balance.dissipated;
    books.work = to.balance.work;
    balance.dissipated = 0;
    balance.work = to.impulsive_work;
    agenda.restore(to.armed, world.time());
    events.resize(std::min(events.size(), to.events));
    while (!history.empty() && history.back().events >= to.events) history.pop_back();
    recover();
    observed = false;
    if (every > 0) next_look = std::floor(world.time() / every * (1 + 1e-12)) * every;
    evaluate_state();
  }

  std::optional<Error> unknown_name(const std::vector<std::string>& joints, const std::vector<std::string>& bodies) const {
    return momentree::unknown_name(world, agenda, joints, bodies);
  }
  void check_names(const std::vector<std::string>& joints, const std::vector<std::string>& bodies) const {
    if (std::optional<Error> error = unknown_name(joints, bodies)) fail(std::move(*error));
  }

  bool look(bool force) {
    if (!observer || (observed && observed_at == world.time())) return true;
    if (!force && every > 0 && world.time() < next_look) return true;
    observed = true;
    observed_at = world.time();
    if (every > 0) {
      next_look = (std::floor(world.time() / every * (1 + 1e-12)) + 1) * every;
      if (!(next_look > world.time())) next_look = std::nextafter(world.time(), HUGE_VAL);
    }
    evaluate_state();
    const During observing(doing, Doing::observing);
    return observer(world);
  }
  bool watched() {
    const During observing(doing, Doing::observing);
    return !watcher || watcher(world.time());
  }

  Status run(double until) {
    if (diverged) return Status::diverged;
    progress.begin(world.time(), events.size());
    stalled = false;
    const During working(doing, Doing::working);
    lap = Clock::now();
    Status status = Status::ok;
    settle();
    if (!happen())
      status = Status::refused;
    else if (!look(!observed))
      status = Status::interrupted;
    while (status == Status::ok && world.time() < until) {
      double end = std::min(until, agenda.next_time());
      if (observer && every > 0) end = std::min(end, next_look);
      if (!step_towards(end)) {
        status = stalled ? Status::stalled : Status::diverged;
        break;
      }
      if (!happen()) {
        status = Status::refused;
        break;
      }
      if (!look(false) || !watched())
        status = Status::interrupted;
      else if (const auto why = progress.step(world, *method, integration, events, until))
        status = Status::stalled, message = *why;
    }
    if (status != Status::interrupted && !look(true)) status = Status::interrupted;
    evaluate_state();
    book();
    return status;
  }

  Integration integration;
  World world;
  Evaluator evaluate;
  std::unique_ptr<Integrator> method;
  Stops stops;
  Books books;
  EnergyBalance balance;
  RunStatistics statistics;
  Agenda agenda;
  struct Past {
    std::size_t events;  ///< how many had happened before
    SimulationSnapshot before;
    std::vector<std::size_t> places;  ///< of what was due, in the agenda
  };
  // What was kept from before the instant of that event; null: nothing was.
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
  std::string message;
  bool diverged = false, stalled = false;
  ProgressMonitor progress;
  double every = 0, next_look = 0, observed_at = 0;
  bool observed = false;
  std::function<bool(const World&)> observer;
  std::function<bool(double)> watcher;
  RatesProvider generated;
  std::optional<std::uint64_t> asked_for;  // the revision of the tree that the provider was last asked about
  Clock::time_point lap = Clock::now();
};

}  // namespace momentree
