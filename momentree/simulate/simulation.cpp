#include <momentree/simulate/simulation.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/energy.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/instant.hpp>
#include <momentree/simulate/stops.hpp>

namespace momentree {

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Events times bodies, beyond which a rehearsal would take longer than it is worth.
constexpr std::size_t most_rehearsed = 10'000'000;

struct Pending {
  double time = 0;
  DueEvent event;
  bool fired = false;
};

std::string text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.9g", x);
  return buffer;
}

}  // namespace

struct Simulation::Impl {
  Impl(const Model& model, const Integration& how)
      : integration(how), world(model), evaluate(world.tree_, world.work_), method(new_method()), stops(world, evaluate) {
    if (method == nullptr)
      fail({"unknown integration method '" + how.method + "'", "", did_you_mean(how.method, integration_methods())});
    if (!(how.step > 0) || !std::isfinite(how.step)) fail({"the step must be a positive time, not " + text(how.step), "", ""});
    if (!(how.rtol > 0 && how.atol > 0 && how.max_step > 0)) fail({"rtol, atol and max_step must be positive", "", ""});
    begin();
  }

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
    events.clear();
    observed = false;
  }

  // Clock and evaluations since the last call go to the phase, before or after the first change, in which they were spent.
  void book() {
    const auto p = static_cast<std::size_t>(statistics.changes > 0);
    statistics.evaluations[p] += evaluate.count;
    statistics.evaluation_seconds[p] += evaluate.seconds;
    statistics.total_seconds[p] += seconds_since(lap);
    evaluate.count = 0;
    evaluate.seconds = 0;
    lap = Clock::now();
  }

  void evaluate_state() { evaluate(world.state_); }

  // Exactly; a clock that is right already leaves what was evaluated as it is.
  void set_time(double time) {
    if (world.time() != time) world.state_.edit().time = time;
  }

  // One step that ends at `end`; a step of almost the full length takes what is left, so that no sliver follows.
  bool step_towards(double end) {
    const double left = end - world.time();
    const double usual = method->next_step(left);
    const bool last = usual == left;
    // What the clock advances, which is rounded, is what the state advances: else they part by up to an ulp of the time per step,
    // always to the same side.
    const double h = last ? left : (world.time() + usual) - world.time();
    const auto start = Clock::now();
    evaluate_state();
    if (stops.any()) return step_between_stops(h, last ? end : HUGE_VAL, start);
    const double stepped = method->advance(evaluate, world.state_, books, h);
    if (stepped == 0) {
      report_divergence(h);
      return false;
    }
    if (last && stepped == h) set_time(end);
    ++statistics.steps;
    const double taken = seconds_since(start);
    statistics.worst_step_seconds = std::max(statistics.worst_step_seconds, taken);
    return true;
  }

  // The same where joints have stops: the step may end earlier, and something happen there. `end`: what a whole step ends at.
  bool step_between_stops(double h, double end, Clock::time_point start) {
    const std::optional<double> stepped = stops.step(*method, books, h, integration.event_tolerance);
    if (!stepped) {
      report_divergence(h);
      return false;
    }
    if (*stepped == h && std::isfinite(end)) set_time(end);
    ++statistics.steps;
    settle();
    statistics.worst_step_seconds = std::max(statistics.worst_step_seconds, seconds_since(start));
    return true;
  }

  // What touches a stop is dealt with, and told.
  void settle() {
    const std::size_t before = events.size();
    stops.settle(events);
    for (std::size_t i = before; i < events.size(); ++i)
      balance.lost_in_impacts += events[i].lost, balance.released += events[i].released;
  }

  void report_divergence(double h) {
    evaluate_state();  // of the last good state
    const Tree& tree = world.tree_;
    int worst = 0;
    double fastest = -1;
    for (const int carrier : tree.order()) {
      const int b = tree.joint_of(carrier);
      for (double v : world.joint({b}).v) {
        const double speed = std::isfinite(v) ? std::fabs(v) : HUGE_VAL;
        if (speed > fastest) fastest = speed, worst = b;
      }
    }
    message = "diverged at t = " + text(world.time()) + " s: joint '" + std::string(world.joint_name({worst})) +
              "' reached a speed of " + text(fastest) + " rad/s or m/s within a step of " + text(h) + " s; use " +
              (method->adaptive() ? "larger tolerances rtol and atol"
                                  : "a smaller step, such as " + text(integration.step / 4) + " s") +
              ", or more damping or inertia at that joint";
    diverged = true;
  }

  // What has happened is passed over, and the next instant at which something is scheduled found.
  void look_ahead() {
    while (first < pending.size() && pending[first].fired) ++first;
    next_time = HUGE_VAL;
    for (std::size_t k = first; k < pending.size(); ++k)
      if (!pending[k].fired) next_time = std::min(next_time, pending[k].time);
  }

  // Everything that is due now. False: it was refused, and nothing happened.
  bool happen() {
    if (next_time > world.time()) return true;
    std::vector<DueEvent> due;
    std::vector<std::size_t> places;
    for (std::size_t k = first; k < pending.size(); ++k) {
      if (pending[k].fired || pending[k].time > world.time()) continue;
      due.push_back(pending[k].event);
      places.push_back(k);
    }
    if (keeps_history) history.push_back({events.size(), snapshot()});
    if (!carry_out_now(due)) {
      if (keeps_history) history.pop_back();
      return false;
    }
    for (const std::size_t k : places) pending[k].fired = true;
    look_ahead();
    return true;
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
      balance.released += event.released;
      balance.lost_in_impacts += event.lost;
      balance.work += event.work;
      events.push_back(std::move(event));
    }
    settle();
    return true;
  }

  // What bodies bring into the world and take out of it is work; the event's certificate says how much.
  template <class Act>
  void populate(std::string what, Act act) {
    Event event;
    event.time = world.time();
    event.name = what.substr(0, what.find(' '));
    event.mechanisms_before = world.mechanism_names();
    event.before = world.totals();
    if (keeps_history) history.push_back({events.size(), snapshot()});
    act();
    method = new_method();
    evaluate_state();
    event.after = world.totals();
    event.mechanisms_after = world.mechanism_names();
    event.work = event.after.kinetic + event.after.potential - event.before.kinetic - event.before.potential;
    event.actions = {std::move(what)};
    balance.work += event.work;
    events.push_back(std::move(event));
    settle();
  }

  Rehearsal rehearse() {
    Rehearsal found;
    const WorldSnapshot start = world.snapshot();
    std::set<std::pair<std::string, Kind>> joints;
    const auto look_at_joints = [&] {
      for (const int b : world.tree_.order())
        joints.emplace(world.names_.joint(world.tree_.joint_of(b)), world.tree_.joint(b).kind);
    };
    look_at_joints();
    std::vector<std::size_t> order;
    for (std::size_t k = first; k < pending.size(); ++k)
      if (!pending[k].fired) order.push_back(k);
    std::stable_sort(order.begin(), order.end(),
                     [this](std::size_t a, std::size_t b) { return pending[a].time < pending[b].time; });
    found.complete = order.size() * static_cast<std::size_t>(world.tree_.bodies()) <= most_rehearsed;
    for (std::size_t i = 0; found.complete && i < order.size();) {
      std::vector<DueEvent> due;
      const std::size_t begin = i;
      const double time = pending[order[i]].time;
      for (; i < order.size() && pending[order[i]].time == time; ++i) due.push_back(pending[order[i]].event);
      world.state_.edit().time = time;
      const InstantReport report = carry_out(world, due);
      for (const ActionReport& action : report.actions)
        if (action.verdict.outcome != Verdict::Outcome::done)
          found.troubles.push_back({order[begin + action.event], action.action, action.verdict,
                                    action.verdict.outcome == Verdict::Outcome::refused ? report.message : ""});
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
    for (const Pending& p : pending) all.fired.push_back(p.fired ? 1 : 0);
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
    for (std::size_t k = 0; k < pending.size(); ++k)
      pending[k].fired = k < to.fired.size() ? to.fired[k] != 0 : pending[k].time < world.time();
    first = 0;
    look_ahead();
    events.resize(std::min(events.size(), to.events));
    while (!history.empty() && history.back().events >= to.events) history.pop_back();
    diverged = false;
    message.clear();
    observed = false;
    if (every > 0) next_look = std::floor(world.time() / every * (1 + 1e-12)) * every;
    evaluate_state();
  }

  // Names that can never be: of no joint that is, was or is to be made, of no body.
  void check_names(const ActionBase& action) const {
    const Model& model = world.model();
    for (const std::string& body : action.bodies()) model.body(body);  // throws
    for (const std::string& joint : action.joints()) {
      if (model.has_joint(joint) || world.find_joint(joint) >= 0) continue;
      const std::size_t tail = joint.rfind("~free");
      if (model.has_body(tail == std::string::npos ? joint : joint.substr(0, tail))) continue;
      const auto made = [&](const Pending& p) {
        for (std::size_t a = 0; a < p.event.actions.size(); ++a)
          if (made_joint_name(p.event, a) == joint) return true;
        return false;
      };
      if (std::none_of(pending.begin(), pending.end(), made)) model.joint(joint);  // throws
    }
  }

  bool look(bool force) {
    if (!observer || (observed && observed_at == world.time())) return true;
    if (!force && every > 0 && world.time() < next_look) return true;
    observed = true;
    observed_at = world.time();
    if (every > 0) next_look = (std::floor(world.time() / every * (1 + 1e-12)) + 1) * every;
    evaluate_state();
    return observer(world);
  }

  Status run(double until) {
    if (diverged) return Status::diverged;
    lap = Clock::now();
    Status status = Status::ok;
    settle();
    if (!happen())
      status = Status::refused;
    else if (!look(!observed))
      status = Status::interrupted;
    while (status == Status::ok && world.time() < until) {
      double end = until;
      end = std::min(end, next_time);
      if (observer && every > 0) end = std::min(end, next_look);
      if (!step_towards(end)) {
        status = Status::diverged;
        break;
      }
      if (!happen()) {
        status = Status::refused;
        break;
      }
      if (!look(false) || (watcher && !watcher(world.time()))) status = Status::interrupted;
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
  std::vector<Pending> pending;  // in the order of scheduling; all before `first` have happened
  std::size_t first = 0;
  double next_time = HUGE_VAL;
  struct Past {
    std::size_t events;  ///< how many had happened before
    SimulationSnapshot before;
  };
  bool keeps_history = false;
  std::vector<Past> history;
  std::vector<Event> events;
  std::string message;
  bool diverged = false;
  double every = 0, next_look = 0, observed_at = 0;
  bool observed = false;
  std::function<bool(const World&)> observer;
  std::function<bool(double)> watcher;
  Clock::time_point lap = Clock::now();
};

Simulation::Simulation(const Model& model, const Integration& integration) : impl_(std::make_unique<Impl>(model, integration)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

Simulation::Scheduled Simulation::at(double time) {
  if (!std::isfinite(time) || time < impl_->world.time())
    fail({"an event at " + text(time) + " s cannot happen: the time is " + text(impl_->world.time()) + " s", "", ""});
  impl_->pending.push_back({time, {"#" + std::to_string(impl_->pending.size() + 1), false, {}}, false});
  impl_->next_time = std::min(impl_->next_time, time);
  return Scheduled(*impl_, impl_->pending.size() - 1);
}

Simulation::Scheduled& Simulation::Scheduled::then(Action action) {
  impl_->check_names(*action);
  impl_->pending[event_].event.actions.push_back(std::move(action));
  return *this;
}

Simulation::Scheduled& Simulation::Scheduled::named(std::string name, bool by_user) {
  impl_->pending[event_].event.name = std::move(name);
  impl_->pending[event_].event.named = by_user;
  return *this;
}

const Event& Simulation::apply(std::span<const Action> actions, std::string name) {
  Impl& impl = *impl_;
  DueEvent due{name.empty() ? "#" + std::to_string(impl.pending.size() + impl.events.size() + 1) : name, !name.empty(), {}};
  for (const Action& action : actions) {
    impl.check_names(*action);
    due.actions.push_back(action);
  }
  const std::size_t place = impl.events.size();  // what its stops do about it comes after it
  if (impl.keeps_history) impl.history.push_back({impl.events.size(), impl.snapshot()});
  if (!impl.carry_out_now({&due, 1})) {
    if (impl.keeps_history) impl.history.pop_back();
    fail({impl.message, "", ""});
  }
  return impl.events[place];
}

Rehearsal Simulation::rehearse() { return impl_->rehearse(); }
Body Simulation::add(BodySpec spec) {
  const std::string name = spec.name;
  Body body;
  impl_->populate("add " + name, [&] { body = impl_->world.add(std::move(spec)); });
  return body;
}
void Simulation::remove(Body body) {
  if (!impl_->world.alive(body)) fail({"the body is not in this world any more", "", ""});
  impl_->populate("remove " + impl_->world.model()[body].name, [&] { impl_->world.remove(body); });
}
SimulationSnapshot Simulation::snapshot() const { return impl_->snapshot(); }
void Simulation::restore(const SimulationSnapshot& snapshot) { impl_->go_back(snapshot); }
void Simulation::keep_history() { impl_->keeps_history = true; }

void Simulation::undo(std::size_t number, bool again) {
  for (const Impl::Past& past : impl_->history) {
    const bool last = &past == &impl_->history.back();
    const std::size_t next = last ? impl_->events.size() : (&past + 1)->events;
    if (number < past.events || number >= next) continue;
    SimulationSnapshot before = past.before;
    if (!again)
      for (std::size_t k = 0; k < before.fired.size(); ++k)
        if (impl_->pending[k].time <= before.world.engine.time) before.fired[k] = 1;
    impl_->go_back(before);
    return;
  }
  fail({"the history of event " + std::to_string(number) + " was not kept", "", "call keep_history() before it happens"});
}

Simulation Simulation::branch() const {
  Simulation other(impl_->world.first_model(), impl_->integration);
  other.impl_->pending = impl_->pending;
  other.impl_->events = impl_->events;
  other.impl_->go_back(impl_->snapshot());
  other.impl_->balance.initial = impl_->balance.initial;
  return other;
}

Status Simulation::run_until(double time) { return impl_->run(time); }
Status Simulation::step(double dt) { return impl_->run(impl_->world.time() + dt); }

void Simulation::observe(double every, std::function<bool(const World&)> observer) {
  impl_->observer = std::move(observer);
  impl_->every = every;
  impl_->observed = false;
}

void Simulation::watch(std::function<bool(double)> watcher) { impl_->watcher = std::move(watcher); }

void Simulation::restore(double time, const Forest& forest, std::span<const JointStart> joints) {
  impl_->world.restore(time, forest, joints);
  impl_->method = impl_->new_method();
  impl_->begin();
}

double Simulation::time() const { return impl_->world.time(); }
const World& Simulation::world() const { return impl_->world; }
const std::vector<Event>& Simulation::events() const { return impl_->events; }
const RunStatistics& Simulation::statistics() const { return impl_->statistics; }
const std::string& Simulation::message() const { return impl_->message; }

EnergyBalance Simulation::energy() const {
  EnergyBalance b = impl_->balance;
  const Totals t = impl_->world.totals();
  b.final = t.kinetic + t.potential;
  b.dissipated = impl_->books.dissipated;
  b.work += impl_->books.work;
  b.error = b.final + b.dissipated + b.lost_in_impacts + b.released - b.initial - b.work;
  return b;
}

}  // namespace momentree
