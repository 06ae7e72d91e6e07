#include <momentree/simulate/simulation.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/energy.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Pending {
  double time = 0;
  std::string name;
  std::vector<Action> actions;
};

std::string text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.9g", x);
  return buffer;
}

}  // namespace

struct Simulation::Impl {
  Impl(const Model& model, const Integration& how)
      : integration(how), world(model), evaluate(world.tree_, world.work_), method(make_integrator(how.method, world.tree_)) {
    if (method == nullptr)
      fail({"unknown integration method '" + how.method + "'", "", did_you_mean(how.method, integration_methods())});
    if (!(how.step > 0) || !std::isfinite(how.step)) fail({"the step must be a positive time, not " + text(how.step), "", ""});
    begin();
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

  // One step that ends at `end`; a step of almost the full length takes what is left, so that no sliver follows.
  bool step_towards(double end) {
    const double left = end - world.time();
    const bool last = left <= integration.step * (1 + 1e-9);
    // What the clock advances, which is rounded, is what the state advances: else they part by up to an ulp of the time per step,
    // always to the same side.
    const double h = last ? left : (world.time() + integration.step) - world.time();
    const auto start = Clock::now();
    evaluate_state();
    if (!method->step(evaluate, world.state_, books, h)) {
      report_divergence(h);
      return false;
    }
    if (last) world.state_.edit().time = end;  // exactly
    ++statistics.steps;
    const double taken = seconds_since(start);
    statistics.worst_step_seconds = std::max(statistics.worst_step_seconds, taken);
    return true;
  }

  void report_divergence(double h) {
    evaluate_state();  // of the last good state
    const Tree& tree = world.tree_;
    int worst = 0;
    double fastest = -1;
    for (int b = 0; b < tree.bodies(); ++b) {
      for (double v : world.joint({b}).v) {
        const double speed = std::isfinite(v) ? std::fabs(v) : HUGE_VAL;
        if (speed > fastest) fastest = speed, worst = b;
      }
    }
    message = "diverged at t = " + text(world.time()) + " s: joint '" + std::string(world.joint_name({worst})) +
              "' reached a speed of " + text(fastest) + " rad/s or m/s within a step of " + text(h) +
              " s; use a smaller step, such as " + text(integration.step / 4) + " s, or more damping or inertia at that joint";
    diverged = true;
  }

  // Events due now, in the order in which they were scheduled.
  void happen() {
    while (next < pending.size() && pending[next]->time <= world.time()) apply_event(*pending[next++]);
  }

  void apply_event(const Pending& due) {
    evaluate_state();
    Event e;
    e.time = world.time();
    e.name = due.name;
    e.mechanisms_before = world.mechanism_names();
    e.before = world.totals();
    for (const Action& action : due.actions)
      for (const std::string& target : action.targets) apply_break(target, e);
    evaluate_state();
    e.mechanisms_after = world.mechanism_names();
    e.after = world.totals();
    balance.released += e.released;
    events.push_back(std::move(e));
  }

  void apply_break(const std::string& target, Event& e) {
    const Body body = world.model_.joint(target);
    if (world.tree_.detached(body.index) || !can_break(world.tree_, body)) {
      e.actions.push_back("break " + target + " skipped: the joint is not there any more");
      return;
    }
    evaluate_state();
    if (statistics.changes == 0) book();
    const auto start = Clock::now();
    const Released released = apply(Break{body}, world.tree_, world.state_, world.work_);
    const double taken = seconds_since(start);
    ++statistics.changes;
    statistics.topology_seconds += taken;
    e.duration_ns += taken * 1e9;
    e.released += released.energy;
    e.actions.push_back("break " + target);
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
    happen();
    Status status = look(!observed) ? Status::ok : Status::interrupted;
    while (status == Status::ok && world.time() < until) {
      double end = until;
      if (next < pending.size()) end = std::min(end, pending[next]->time);
      if (observer && every > 0) end = std::min(end, next_look);
      if (!step_towards(end)) {
        status = Status::diverged;
        break;
      }
      happen();
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
  Books books;
  EnergyBalance balance;
  RunStatistics statistics;
  std::vector<std::unique_ptr<Pending>> pending;  // by time; `next` is the first that has not happened
  std::size_t next = 0;
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
  auto& pending = impl_->pending;
  auto event = std::make_unique<Pending>();
  event->time = time;
  event->name = "#" + std::to_string(pending.size() + 1);
  Pending* place = event.get();
  const auto later = [](double t, const std::unique_ptr<Pending>& p) { return t < p->time; };
  const auto first = pending.begin() + static_cast<std::ptrdiff_t>(impl_->next);
  pending.insert(std::upper_bound(first, pending.end(), time, later), std::move(event));
  return Scheduled(*impl_, place);
}

Simulation::Scheduled& Simulation::Scheduled::then(Action action) {
  if (action.key != "break") fail({"unknown action '" + action.key + "'", "", did_you_mean(action.key, {"break"})});
  for (const std::string& target : action.targets) impl_->world.model().joint(target);  // throws for an unknown name
  static_cast<Pending*>(event_)->actions.push_back(std::move(action));
  return *this;
}

Simulation::Scheduled& Simulation::Scheduled::named(std::string name) {
  static_cast<Pending*>(event_)->name = std::move(name);
  return *this;
}

Status Simulation::run_until(double time) { return impl_->run(time); }
Status Simulation::step(double dt) { return impl_->run(impl_->world.time() + dt); }

void Simulation::observe(double every, std::function<bool(const World&)> observer) {
  impl_->observer = std::move(observer);
  impl_->every = every;
  impl_->observed = false;
}

void Simulation::watch(std::function<bool(double)> watcher) { impl_->watcher = std::move(watcher); }

void Simulation::restore(double time, std::span<const Body> broken, std::span<const JointStart> joints) {
  impl_->world.restore(time, broken, joints);
  impl_->method = make_integrator(impl_->integration.method, impl_->world.tree_);
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
  b.work = impl_->books.work;
  b.error = b.final + b.dissipated + b.lost_in_impacts + b.released - b.initial - b.work;
  return b;
}

}  // namespace momentree
