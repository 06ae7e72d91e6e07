#include <momentree/simulate/simulation.hpp>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

namespace {

constexpr const char* moved_from = "the simulation has not been moved from";
constexpr const char* callback_changes =
    "callbacks do not change their simulation: schedule the change with at(), or return false from observe() or watch() and "
    "change it after run_until()";

// The number of a joint that a function may drive; throws Error.
int to_drive(const World& world, std::string_view joint, bool function) {
  const int number = world.find_joint(joint);
  if (number < 0) {
    world.model().joint(joint);  // throws if it never existed
    throw_error({"the joint '" + std::string(joint) + "' no longer exists", "", ""});
  }
  const JointView view = world.joint({number});
  if (view.v.empty()) throw_error({"the joint '" + std::string(joint) + "' has no degree of freedom to drive", "", ""});
  const JointDrive* drive = view.parameters != nullptr ? view.parameters->drive.get() : nullptr;
  if (function && drive != nullptr && drive->moves())
    throw_error({"the motion of joint '" + std::string(joint) + "' is prescribed", "", "remove its drive first"});
  return number;
}

}  // namespace

Simulation::Simulation(const Model& model, const Integration& integration) : impl_(std::make_shared<Impl>(model, integration)) {}
Simulation::~Simulation() {
  if (impl_ != nullptr) MT_REQUIRE(impl_->activity.idle(), "callbacks do not destroy their simulation");
}
Simulation::Simulation(Simulation&& other) noexcept : impl_(std::move(other.impl_)) {
  if (impl_ != nullptr) MT_REQUIRE(impl_->activity.idle(), "callbacks do not move their simulation");
}
Simulation& Simulation::operator=(Simulation&& other) noexcept {
  for (const auto* each : {this, &other})
    if (each->impl_ != nullptr) MT_REQUIRE(each->impl_->activity.idle(), "callbacks do not move their simulation");
  impl_.swap(other.impl_);
  if (this != &other) other.impl_.reset();
  return *this;
}

Simulation::Impl& Simulation::impl() const {
  MT_REQUIRE(impl_ != nullptr, moved_from);
  return *impl_;
}
Simulation::Impl& Simulation::changing() const {
  MT_REQUIRE(impl().activity.idle(), callback_changes);
  return *impl_;
}
Simulation::Impl& Simulation::scheduling() const {
  MT_REQUIRE(impl().activity.steady(), callback_schedules);
  return *impl_;
}
Simulation::Impl& Simulation::steady() const {
  MT_REQUIRE(impl().activity.steady(), "of the callbacks, only those of observe() and watch() are called between two steps");
  return *impl_;
}

Simulation::Scheduled Simulation::at(double time) {
  const double now = scheduling().world.time();
  if (!std::isfinite(time) || time < now)
    throw_error({"an event at " + detail::text(time) + " s cannot happen: the time is " + detail::text(now) + " s", "", ""});
  EventQueue::Entry entry;
  entry.time = time;
  return Scheduled(impl_, impl_->schedule(std::move(entry)));
}

Simulation::Scheduled Simulation::when(Condition condition) {
  check_condition(scheduling().world, impl_->queue, condition);
  EventQueue::Entry entry;
  entry.condition = std::move(condition);
  return Scheduled(impl_, impl_->schedule(std::move(entry)));
}

Simulation::Scheduled Simulation::after(std::string event, double delay) {
  std::vector<std::string> names;
  for (const EventQueue::Entry& e : scheduling().queue.entries) names.push_back(e.event.name);
  for (const Strength& s : strengths(impl_->world)) names.push_back(event_name(impl_->world, s));
  // A joint or spring that an event will give a strength, or that broke before this run began.
  const std::string_view prefix = "strength of ";
  const bool of_joint =
      event.starts_with(prefix) && (impl_->world.model().has_joint(std::string_view(event).substr(prefix.size())) ||
                                    impl_->world.model().has_spring(std::string_view(event).substr(prefix.size())));
  if (!of_joint && std::find(names.begin(), names.end(), event) == names.end())
    throw_error({"there is no event '" + event + "' to follow", "", did_you_mean(event, names)});
  if (!(delay >= 0) || !std::isfinite(delay))
    throw_error({"the delay after an event can't be " + detail::text(delay) + " s", "", ""});
  EventQueue::Entry entry;
  entry.after = std::move(event), entry.delay = delay;
  return Scheduled(impl_, impl_->schedule(std::move(entry)));
}

Simulation::Scheduled Simulation::every(double period, double from) {
  const double now = scheduling().world.time();
  if (!std::isfinite(from) || from < std::min(now, 0.0))
    throw_error({"an event from " + detail::text(from) + " s on cannot happen: the time is " + detail::text(now) + " s", "", ""});
  const double clock = std::max({now, from, impl_->integration.step});
  if (std::optional<Error> wrong = wrong_period(period, clock, "the period of an event")) throw_error(std::move(*wrong));
  EventQueue::Entry entry;
  entry.time = std::max(from, Periodic(from, period).first_from(now)), entry.from = from, entry.period = period;
  return Scheduled(impl_, impl_->schedule(std::move(entry)));
}

std::shared_ptr<Simulation::Impl> Simulation::Scheduled::impl() const {
  std::shared_ptr<Impl> impl = impl_.lock();
  MT_REQUIRE(impl != nullptr, "the simulation in which the event was scheduled still exists");
  MT_REQUIRE(impl->activity.steady(), callback_schedules);
  return impl;
}

Simulation::Scheduled& Simulation::Scheduled::then(Action action) {
  const std::shared_ptr<Impl> all = impl();
  EventQueue::Entry& entry = all->queue.entries[event_];
  if (entry.done)
    throw_error({"event '" + entry.event.name + "' has already happened: " + action.text() + " would not happen", "",
                 "schedule another event"});
  if (std::optional<Error> error = all->unknown_name(action)) throw_error(std::move(*error));
  entry.event.actions.push_back(std::move(action));
  return *this;
}

Simulation::Scheduled& Simulation::Scheduled::named(std::string name, bool by_user) {
  const std::shared_ptr<Impl> all = impl();
  DueEvent& event = all->queue.entries[event_].event;
  event.name = std::move(name);
  event.named = by_user;
  return *this;
}

Simulation::Scheduled& Simulation::Scheduled::ranked(std::size_t rank) {
  impl()->queue.entries[event_].rank = rank;
  return *this;
}

Event Simulation::apply(std::span<const Action> actions, std::string name) {
  for (const Action& action : actions)
    if (std::optional<Error> error = changing().unknown_name(action)) throw_error(std::move(*error));
  const std::size_t place = changing().events.size();  // events of its stops follow it
  if (!impl_->act(actions, name)) throw_error({impl_->outcome.message, "", ""});
  return impl_->events[place];
}

RunResult Simulation::try_apply(std::span<const Action> actions, std::string name) {
  Impl& impl = changing();
  for (const Action& action : actions)
    if (const std::optional<Error> error = check(action)) {
      const std::string reason = std::string(action->key()) + ": " + error->problem;
      return impl.outcome.result = {Status::refused, reason + (error->hint.empty() ? "" : "; " + error->hint)};
    }
  if (!impl.act(actions, name)) return impl.outcome.result = {Status::refused, impl.outcome.message};
  return impl.outcome.result = {};
}

std::optional<Error> Simulation::check(const Action& action) const { return impl().unknown_name(action); }

std::optional<Error> Simulation::check(const Condition& condition) const { return open_reaction(impl().world, condition); }

void Simulation::set_gravity(Vec3 gravity) {
  Impl& impl = changing();
  impl.energy.settle(impl.world);
  const double before = impl.world.totals().potential;
  impl.world.edit().set_gravity(gravity);  // may throw
  impl.evaluate_state();
  impl.energy.balance.work += impl.world.totals().potential - before;
  impl.history.instants.clear();
  impl.recover();
  impl.contact.update_pending();
}

DryRun Simulation::dry_run() { return changing().dry_run(); }
SimulationSnapshot Simulation::snapshot() const { return steady().snapshot(); }
void Simulation::restore(const SimulationSnapshot& snapshot) {
  Impl& impl = changing();
  require_contact_method(snapshot.world, impl.integration.method);
  impl.go_back(snapshot);
}
void Simulation::keep_history(std::size_t most) { scheduling().history.most = most; }

bool Simulation::can_undo(std::size_t number) const { return impl().history.before(number, impl_->events.size()) != nullptr; }

void Simulation::undo(std::size_t number, bool again) {
  const RunHistory::Past* past = changing().history.before(number, impl_->events.size());
  if (past == nullptr)
    throw_error(
        {"the history of event " + std::to_string(number) + " was not kept", "", "call keep_history() before it happens"});
  SimulationSnapshot before = past->before;
  if (!again)
    for (const std::size_t k : past->places)
      if (k < before.armed.size()) before.armed[k].done = true;  // a joint's strength stays active
  impl_->go_back(before);
}

Simulation Simulation::branch() const {
  Simulation other(first_model(steady().world), impl_->integration);
  other.impl_->world.edit().start().gravity = impl_->world.start().gravity;
  other.impl_->queue = impl_->queue;
  other.impl_->events = impl_->events;
  other.impl_->go_back(impl_->snapshot());
  other.impl_->energy.balance.initial = impl_->energy.balance.initial;
  other.impl_->generated.provider = impl_->generated.provider;
  return other;
}

RunResult Simulation::run_until(double time) {
  Impl& impl = changing();
  if (std::isnan(time)) throw_error({"the time to run to is not a number", "", ""});
  if (time == HUGE_VAL && !impl.observers.observer && !impl.observers.watcher)
    throw_error(
        {"nothing ends a run with infinite end time", "", "give it an observer or a watcher that eventually returns false"});
  return impl.run(time);
}
RunResult Simulation::step(double dt) {
  const double now = changing().world.time();
  if (!(dt >= 0)) throw_error({"a step can't be " + detail::text(dt) + " s", "", ""});
  if (dt > 0 && now + dt == now)
    throw_error(
        {"a step of " + detail::text(dt) + " s is shorter than the clock can resolve at " + detail::text(now) + " s", "", ""});
  return run_until(now + dt);
}

void Simulation::observe(double every, std::function<bool(const World&)> observer) {
  Impl& impl = changing();
  const double clock = std::max(impl.world.time(), impl.integration.step);
  if (every != 0)
    if (std::optional<Error> wrong = wrong_period(every, clock, "the period of an observer")) throw_error(std::move(*wrong));
  impl.observers.observer = std::move(observer);
  impl.observers.every = every;
  impl.observers.observed = false;
}

void Simulation::sample(std::function<bool(const World&)> sampler) { changing().observers.sampler = std::move(sampler); }
void Simulation::watch(std::function<bool(double)> watcher) { changing().observers.watcher = std::move(watcher); }

void Simulation::use_generated(RatesProvider provider) {
  changing().generated.provider = std::move(provider);
  impl_->generated.asked_for.reset();
  impl_->evaluate.use(nullptr);
}

void Simulation::drive(std::string_view joint, std::function<double(const EvaluationContext&)> effort) {
  const int number = changing().world.find_joint(joint);
  if (const std::size_t dofs = number < 0 ? 1 : impl_->world.joint({number}).v.size(); dofs > 1)
    throw_error({"the joint '" + std::string(joint) + "' has " + std::to_string(dofs) +
                     " degrees of freedom, which a single function can't drive",
                 "", "use drive_all()"});
  JointFunction function;
  if (effort)
    function = [effort = std::move(effort)](const EvaluationContext& m, std::span<double> efforts) { efforts[0] = effort(m); };
  drive_all(joint, std::move(function));
}
void Simulation::drive_all(std::string_view joint, JointFunction efforts) {
  drive_all({{std::string(joint), std::move(efforts)}});
}
void Simulation::drive_all(std::vector<JointDriver> drivers) {
  std::vector<int> joints;
  for (const JointDriver& each : drivers) joints.push_back(to_drive(changing().world, each.joint, each.efforts != nullptr));
  for (std::size_t i = 0; i < joints.size(); ++i) impl_->world.edit().drive(joints[i], std::move(drivers[i].efforts));
  changing().evaluate_state();
  impl_->contact.update_pending();
}

void Simulation::force(std::string_view body, BodyFunction wrench) {
  const BodyId b = changing().world.model().body(body);  // may throw
  if (!impl_->world.alive(b)) throw_error({"the body '" + std::string(body) + "' is no longer in this world", "", ""});
  impl_->world.edit().load(b.index, std::move(wrench));
  impl_->evaluate_state();
  impl_->contact.update_pending();
}

void Simulation::restore(double time, const Forest& forest, std::span<const JointStart> joints,
                         const std::function<void(const World&)>& check) {
  World& world = changing().world;
  const int bodies = world.model().size();
  const auto restore_world = [&] {
    if (forest.gravity) world.edit().set_gravity(*forest.gravity);
    world.restore(time, forest, joints);
    if (check) check(world);
  };
#ifdef __cpp_exceptions
  const WorldSnapshot before = world.snapshot();
  try {
    restore_world();
  } catch (...) {  // such as loops that cannot be closed
    world.restore(before);
    impl_->evaluate_state();
    throw;
  }
#else
  restore_world();  // an error ends the program
#endif
  if (world.model().size() != bodies) impl_->contact.geometry.pairs.renew();
  impl_->make_methods();
  impl_->begin();
  impl_->contact.as_built = false;
  if (!forest.contacts.empty() || !forest.former_contacts.empty()) impl_->contact.between_runs.close_from_document(forest);
}

void Simulation::set_state(double time, std::span<const double> q, std::span<const double> y, Variables given) {
  Impl& impl = changing();
  const double before = impl.world.time();
  impl.world.edit().set_values(time, q, y, given);  // may throw
  impl.queue.restart(before, time);
  impl.make_methods();
  impl.begin();
  impl.contact.as_built = false;
}

void Simulation::adjust(std::span<const double> q, std::span<const double> y, Variables given) {
  Impl& impl = changing();
  const std::optional<double> before = impl.energy.unadjusted ? impl.energy.unadjusted : total_energy(impl.world);
  std::vector<Contact> closed = impl.contact.between_runs.closed();
  impl.world.edit().set_values(impl.world.time(), q, y, given);  // may throw
  impl.contact.between_runs.set_former(std::move(closed));
  impl.energy.unadjusted = before;
  impl.contact.stepping.placed = true;
  impl.contact.as_built = false;
  impl.queue.forget_looks();
  impl.recover();
  impl.observers.look_anew(impl.world.time());
  impl.contact.update_pending();
}

RunState Simulation::run_state() const { return steady().run_state(); }
void Simulation::continue_from(const RunState& state) { changing().continue_from(state); }

const Integration& Simulation::integration() const { return impl().integration; }
double Simulation::time() const { return impl().world.time(); }
const World& Simulation::world() const { return impl().world; }
const std::vector<Event>& Simulation::events() const { return impl().events; }
const RunStatistics& Simulation::statistics() const { return impl().statistics; }
const RunResult& Simulation::result() const { return impl().outcome.result; }

std::vector<MissedEvent> Simulation::missed() const {
  std::vector<MissedEvent> all;
  for (const EventQueue::Entry& e : impl().queue.entries) {
    if (e.fired > 0) continue;
    MissedEvent missed;
    missed.name = e.event.name, missed.time = e.time, missed.after = e.after;
    if (e.condition) {
      const Condition& c = *e.condition;
      missed.quantity = c.what->key();
      for (const auto& names : {c.what->joints(), c.what->bodies(), c.what->mechanisms(), c.what->solids()})
        missed.of.insert(missed.of.end(), names.begin(), names.end());
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
  impl().energy.settle(impl().world);
  EnergyBalance b = impl_->energy.balance;
  const Totals t = impl_->world.totals();
  b.final = t.kinetic + t.potential;
  b.largest_kinetic = std::max(b.largest_kinetic, t.kinetic);
  b.dissipated = impl_->energy.ledger.dissipated;
  b.work += impl_->energy.ledger.work;
  b.projection = impl_->energy.ledger.projection;
  b.lost_in_steps = impl_->energy.ledger.impacts;
  b.of_heights = energy_of_heights(impl_->world);
  b.lost_in_impacts += b.lost_in_steps;
  b.error = b.final + b.dissipated + b.lost_in_impacts + b.released - b.initial - b.work - b.projection;
  return b;
}

}  // namespace momentree
