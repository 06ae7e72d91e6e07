#include <momentree/simulate/run_state.hpp>

#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

SimulationSnapshot Simulation::Impl::snapshot() {
  energy.settle(world);
  SimulationSnapshot all{world.snapshot(), {}, events.size(), energy.balance};
  all.proposal = method->proposal();
  all.balance.dissipated = energy.ledger.dissipated;
  all.balance.work = energy.ledger.work;
  all.balance.projection = energy.ledger.projection;
  all.balance.lost_in_steps = energy.ledger.impacts;
  all.stepping = contact.stepping_state();
  all.impulsive_work = energy.balance.work;
  all.armed = queue.armed();
  QueueState remembered = queue.state(world);
  remembered.deeper_stops = stops.deeper();
  all.queue = std::make_shared<const QueueState>(std::move(remembered));
  return all;
}

// The state of the run as it was, apart from what belongs to callbacks and to the history.
void Simulation::Impl::restore_run(const SimulationSnapshot& to) {
  energy.unadjusted.reset();
  const int bodies = world.tree().bodies();
  const bool populated = !to.world.added.empty() || world.model().size() != world.start().bodies;
  world.restore(to.world);
  world.edit().take_needed_variables();
  if (populated) contact.geometry.pairs.renew();
  if (populated || world.tree().bodies() != bodies) make_methods();
  method->set_proposal(to.proposal);
  contact.continue_stepping(to.stepping);
  energy.balance = to.balance;
  energy.ledger.dissipated = to.balance.dissipated;
  energy.ledger.work = to.balance.work;
  energy.ledger.projection = to.balance.projection;
  energy.ledger.impacts = to.balance.lost_in_steps;
  energy.balance.dissipated = 0;
  energy.balance.work = to.impulsive_work;
  queue.restore(to.armed, world.time());
  if (to.queue != nullptr) queue.restore_strengths(*to.queue, world);
  stops.set_deeper(to.queue != nullptr ? to.queue->deeper_stops : std::vector<DeeperStop>());
  events.resize(std::min(events.size(), to.events));
  evaluate_state();
}

void Simulation::Impl::go_back(const SimulationSnapshot& to) {
  restore_run(to);
  contact.keeps_closed = true;
  while (!history.instants.empty() && history.instants.back().events >= to.events) history.instants.pop_back();
  recover();
  observers.look_anew(world.time());
}

// Evaluates nothing: that would change the counts of the run.
RunState Simulation::Impl::run_state() {
  energy.settle(world);
  RunState all;
  all.world = world.snapshot();
  all.queue = queue.state(world);
  all.queue.deeper_stops = stops.deeper();
  all.balance = energy.balance;
  all.dissipated = energy.ledger.dissipated, all.work = energy.ledger.work;
  all.balance.projection = energy.ledger.projection;
  all.proposal = method->proposal();
  all.impacts = energy.ledger.impacts;
  all.stepping = contact.stepping_state();
  all.evaluated = world.edit().workspace().evaluated == world.edit().state().stamp();
  all.evaluations = evaluate.count, all.evaluation_seconds = evaluate.seconds;
  all.statistics = statistics;
  all.within_run = continues || activity.doing == Doing::watching;
  if (activity.doing == Doing::watching)
    all.statistics.total_seconds[statistics.changes > 0 ? 1 : 0] += detail::seconds_since(lap);
  all.keeps_closed = contact.keeps_closed || activity.doing == Doing::observing;
  all.progress = progress.mark();
  all.observed = observers.observed, all.observed_at = observers.observed_at, all.next_observation = observers.next_look;
  all.events = events;
  return all;
}

void Simulation::Impl::continue_from(const RunState& from) {
  energy.unadjusted.reset();
  history.instants.clear();
  recover();
  world.restore(from.world);
  world.edit().take_needed_variables();
  contact.geometry.pairs.renew();
  make_methods();
  method->set_proposal(from.proposal);
  contact.continue_stepping(from.stepping);
  queue.continue_from(from.queue, world);
  stops.set_deeper(from.queue.deeper_stops);
  energy.balance = from.balance;
  energy.ledger = {from.dissipated, from.work};
  energy.ledger.projection = from.balance.projection;
  energy.ledger.impacts = from.impacts;
  if (from.evaluated) evaluate_state();
  evaluate.count = from.evaluations, evaluate.seconds = from.evaluation_seconds;
  statistics = from.statistics;
  progress.continue_from(from.progress);
  continues = from.within_run, contact.keeps_closed = from.keeps_closed;
  observers.observed = from.observed, observers.observed_at = from.observed_at, observers.next_look = from.next_observation;
  events = from.events;
}

const std::vector<EventQueue::Entry>& scheduled(const Simulation& simulation) {
  return implementation(simulation, false).queue.entries;
}

void schedule(Simulation& simulation, std::vector<EventQueue::Entry> events) {
  Simulation::Impl& impl = implementation(simulation, true);
  impl.queue.entries = std::move(events);
  impl.queue.look_ahead();
}

}  // namespace momentree
