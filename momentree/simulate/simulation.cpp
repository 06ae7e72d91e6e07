#include <momentree/simulate/simulation.hpp>

#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

Simulation::Simulation(const Model& model, const Integration& integration) : impl_(std::make_unique<Impl>(model, integration)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

Simulation::Scheduled Simulation::at(double time) {
  if (!std::isfinite(time) || time < impl_->world.time())
    fail({"an event at " + detail::text(time) + " s cannot happen: the time is " + detail::text(impl_->world.time()) + " s", "",
          ""});
  Agenda::Entry entry;
  entry.time = time;
  return Scheduled(*impl_, impl_->schedule(std::move(entry)));
}

Simulation::Scheduled Simulation::when(Condition condition) {
  impl_->check_names(condition.what->joints(), condition.what->bodies());
  if (!std::isfinite(condition.threshold)) fail({"the threshold must be finite", "", ""});
  if (condition.what->is_load() && condition.above && condition.what->key() != "reaction" && !(condition.threshold > 0))
    fail({"a threshold of " + detail::text(condition.threshold) + " for a load, which is never negative, must be positive", "",
          ""});
  if (!(condition.duration >= 0)) fail({"a duration can't be negative", "", ""});
  Agenda::Entry entry;
  entry.condition = std::move(condition);
  return Scheduled(*impl_, impl_->schedule(std::move(entry)));
}

Simulation::Scheduled Simulation::after(std::string event, double delay) {
  std::vector<std::string> names;
  for (const Agenda::Entry& e : impl_->agenda.entries) names.push_back(e.event.name);
  for (const Strength& s : strengths(impl_->world)) names.push_back(event_name(impl_->world, s));
  // A joint whose strength an event will give, or one that broke before this run began.
  const std::string_view prefix = "strength of ";
  const bool of_joint =
      event.starts_with(prefix) && impl_->world.model().has_joint(std::string_view(event).substr(prefix.size()));
  if (!of_joint && std::find(names.begin(), names.end(), event) == names.end())
    fail({"there is no event '" + event + "' to come after", "", did_you_mean(event, names)});
  if (!(delay >= 0) || !std::isfinite(delay)) fail({"the delay after an event can't be " + detail::text(delay) + " s", "", ""});
  Agenda::Entry entry;
  entry.after = std::move(event), entry.delay = delay;
  return Scheduled(*impl_, impl_->schedule(std::move(entry)));
}

Simulation::Scheduled Simulation::every(double period, double from) {
  if (!(period > 0) || !std::isfinite(period)) fail({"a period of " + detail::text(period) + " s is none", "", ""});
  if (!std::isfinite(from) || from < impl_->world.time())
    fail({"an event from " + detail::text(from) + " s on cannot happen: the time is " + detail::text(impl_->world.time()) + " s",
          "", ""});
  Agenda::Entry entry;
  entry.time = from, entry.period = period;
  return Scheduled(*impl_, impl_->schedule(std::move(entry)));
}

void Simulation::expect_joints(const std::vector<std::string>& names) { impl_->expected.insert(names.begin(), names.end()); }

Simulation::Scheduled& Simulation::Scheduled::then(Action action) {
  impl_->check_names(action->joints(), action->bodies());
  impl_->agenda.entries[event_].event.actions.push_back(std::move(action));
  return *this;
}

Simulation::Scheduled& Simulation::Scheduled::named(std::string name, bool by_user) {
  impl_->agenda.entries[event_].event.name = std::move(name);
  impl_->agenda.entries[event_].event.named = by_user;
  return *this;
}

const Event& Simulation::apply(std::span<const Action> actions, std::string name) {
  for (const Action& action : actions) impl_->check_names(action->joints(), action->bodies());
  const std::size_t place = impl_->events.size();  // what its stops do about it comes after it
  if (!impl_->act(actions, name)) fail({impl_->message, "", ""});
  return impl_->events[place];
}

Status Simulation::attempt(std::span<const Action> actions, std::string name) {
  for (const Action& action : actions)
    if (const std::optional<Error> error = unknown_name(action)) {
      impl_->message = std::string(action->key()) + ": " + error->what + (error->hint.empty() ? "" : "; " + error->hint);
      return Status::refused;
    }
  return impl_->act(actions, name) ? Status::ok : Status::refused;
}

std::optional<Error> Simulation::unknown_name(const Action& action) const {
  return impl_->unknown_name(action->joints(), action->bodies());
}

void Simulation::set_gravity(Vec3 gravity) {
  if (!std::isfinite(gravity.x) || !std::isfinite(gravity.y) || !std::isfinite(gravity.z))
    fail({"gravity must be finite numbers", "", ""});
  Model model = impl_->world.first_model();
  model.set_gravity(gravity);
  const SimulationSnapshot now = impl_->snapshot();
  auto other = std::make_unique<Impl>(model, impl_->integration);
  other->agenda = std::move(impl_->agenda);
  other->expected = std::move(impl_->expected);
  other->events = std::move(impl_->events);
  const Totals before = impl_->world.totals();
  other->go_back(now);
  other->balance.work += other->world.totals().potential - before.potential;
  other->statistics = impl_->statistics;
  other->keeps_history = impl_->keeps_history;
  other->every = impl_->every, other->next_look = impl_->next_look;
  other->observed = impl_->observed, other->observed_at = impl_->observed_at;
  other->observer = std::move(impl_->observer);
  other->watcher = std::move(impl_->watcher);
  other->generated = std::move(impl_->generated);
  impl_ = std::move(other);
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

bool Simulation::can_undo(std::size_t number) const { return impl_->before(number) != nullptr; }

void Simulation::undo(std::size_t number, bool again) {
  const Impl::Past* past = impl_->before(number);
  if (past == nullptr)
    fail({"the history of event " + std::to_string(number) + " was not kept", "", "call keep_history() before it happens"});
  SimulationSnapshot before = past->before;
  if (!again)
    for (const std::size_t k : past->places)
      if (k < before.armed.size()) before.armed[k].done = true;  // a joint's strength stays what it is
  impl_->go_back(before);
}

Simulation Simulation::branch() const {
  Simulation other(impl_->world.first_model(), impl_->integration);
  other.impl_->agenda = impl_->agenda;
  other.impl_->expected = impl_->expected;
  other.impl_->events = impl_->events;
  other.impl_->go_back(impl_->snapshot());
  other.impl_->balance.initial = impl_->balance.initial;
  other.impl_->generated = impl_->generated;
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

void Simulation::use_generated(RatesProvider provider) {
  impl_->generated = std::move(provider);
  impl_->asked_for.reset();
  impl_->evaluate.use(nullptr);
}

void Simulation::drive(std::string_view joint, std::function<double(const Moment&)> effort) {
  const int number = impl_->world.find_joint(joint);
  if (const std::size_t freedoms = number < 0 ? 1 : impl_->world.joint({number}).v.size(); freedoms > 1)
    fail({"the joint '" + std::string(joint) + "' has " + std::to_string(freedoms) + " freedoms, which one function can't drive",
          "", "use drive_all()"});
  JointFunction function;
  if (effort) function = [effort = std::move(effort)](const Moment& m, std::span<double> efforts) { efforts[0] = effort(m); };
  drive_all(joint, std::move(function));
}
void Simulation::drive_all(std::string_view joint, JointFunction efforts) {
  drive_all({{std::string(joint), std::move(efforts)}});
}
void Simulation::drive_all(std::vector<JointDriver> drivers) {
  std::vector<int> joints;
  for (const JointDriver& each : drivers) joints.push_back(impl_->to_drive(each.joint, each.efforts != nullptr));
  for (std::size_t i = 0; i < joints.size(); ++i) impl_->world.drive(joints[i], std::move(drivers[i].efforts));
  impl_->evaluate_state();
}

void Simulation::force(std::string_view body, BodyFunction wrench) {
  const Body b = impl_->world.model().body(body);  // or throws
  if (!impl_->world.alive(b)) fail({"the body '" + std::string(body) + "' is not in this world any more", "", ""});
  impl_->world.load(b.index, std::move(wrench));
  impl_->evaluate_state();
}

void Simulation::restore(double time, const Forest& forest, std::span<const JointStart> joints) {
  impl_->world.restore(time, forest, joints);
  impl_->method = impl_->new_method();
  impl_->begin();
}

StepMemory Simulation::step_memory() const { return {impl_->method->proposal(), impl_->books.work}; }
void Simulation::resume(std::span<const Agenda::Armed> armed, const StepMemory& memory) {
  if (impl_->method->adaptive() && memory.next_step > 0) {
    impl_->method->set_proposal(memory.next_step);
    impl_->balance.work -= memory.work - impl_->books.work;  // it was done before this run
    impl_->books.work = memory.work;
  }
  std::vector<Agenda::Armed> all = impl_->agenda.armed();
  std::copy_n(armed.begin(), std::min(armed.size(), all.size()), all.begin());
  impl_->agenda.restore(all, impl_->world.time());
}

double Simulation::time() const { return impl_->world.time(); }
const World& Simulation::world() const { return impl_->world; }
const std::vector<Event>& Simulation::events() const { return impl_->events; }
const RunStatistics& Simulation::statistics() const { return impl_->statistics; }
const std::string& Simulation::message() const { return impl_->message; }

std::vector<MissedEvent> Simulation::missed() const {
  std::vector<MissedEvent> all;
  for (const Agenda::Entry& e : impl_->agenda.entries) {
    if (e.fired > 0) continue;
    MissedEvent missed;
    missed.name = e.event.name, missed.time = e.time, missed.after = e.after;
    if (e.condition) {
      const Condition& c = *e.condition;
      missed.quantity = c.what->key();
      missed.threshold = c.threshold, missed.exceeds = c.above;
      missed.lasts = c.duration, missed.held = e.nearest.held;
      if (std::isfinite(e.nearest.excess)) {
        missed.nearest = c.threshold + (c.above ? e.nearest.excess : -e.nearest.excess);
        missed.nearest_time = e.nearest.time;
      }
    }
    all.push_back(std::move(missed));
  }
  return all;
}

EnergyBalance Simulation::energy() const {
  EnergyBalance b = impl_->balance;
  const Totals t = impl_->world.totals();
  b.final = t.kinetic + t.potential;
  b.largest_kinetic = std::max(b.largest_kinetic, t.kinetic);
  b.dissipated = impl_->books.dissipated;
  b.work += impl_->books.work;
  b.error = b.final + b.dissipated + b.lost_in_impacts + b.released - b.initial - b.work;
  return b;
}

}  // namespace momentree
