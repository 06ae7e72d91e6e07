#include <momentree/simulate/run_state.hpp>

#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

SimulationSnapshot Simulation::Impl::snapshot() {
  settle();
  SimulationSnapshot all{world.snapshot(), {}, events.size(), balance};
  all.proposal = method->proposal();
  all.balance.dissipated = ledger.dissipated;
  all.balance.work = ledger.work;
  all.balance.projection = ledger.projection;
  all.balance.lost_in_steps = ledger.impacts;
  all.stepping = stepping_state();
  all.impulsive_work = balance.work;
  all.armed = queue.armed();
  QueueState remembered = queue.state(world);
  remembered.deeper_stops = stops.deeper();
  all.queue = std::make_shared<const QueueState>(std::move(remembered));
  return all;
}

// The state of the run as it was, apart from what belongs to callbacks and to the history.
void Simulation::Impl::restore_run(const SimulationSnapshot& to) {
  unadjusted.reset();
  const int bodies = world.tree_.bodies();
  const bool populated = !to.world.added.empty() || world.model_.size() != world.first_bodies_;
  world.restore(to.world);
  if (populated) geometry.pairs.renew();
  if (populated || world.tree_.bodies() != bodies) make_methods();
  method->set_proposal(to.proposal);
  continue_stepping(to.stepping);
  balance = to.balance;
  ledger.dissipated = to.balance.dissipated;
  ledger.work = to.balance.work;
  ledger.projection = to.balance.projection;
  ledger.impacts = to.balance.lost_in_steps;
  balance.dissipated = 0;
  balance.work = to.impulsive_work;
  queue.restore(to.armed, world.time());
  if (to.queue != nullptr) queue.restore_strengths(*to.queue, world);
  stops.set_deeper(to.queue != nullptr ? to.queue->deeper_stops : std::vector<DeeperStop>());
  events.resize(std::min(events.size(), to.events));
  evaluate_state();
}

void Simulation::Impl::go_back(const SimulationSnapshot& to) {
  restore_run(to);
  keeps_contacts = true;
  while (!history.empty() && history.back().events >= to.events) history.pop_back();
  recover();
  look_anew();
}

// Evaluates nothing: that would change the counts of the run.
RunState Simulation::Impl::run_state() {
  settle();
  RunState all;
  all.world = world.snapshot();
  all.queue = queue.state(world);
  all.queue.deeper_stops = stops.deeper();
  all.balance = balance;
  all.dissipated = ledger.dissipated, all.work = ledger.work;
  all.balance.projection = ledger.projection;
  all.proposal = method->proposal();
  all.impacts = ledger.impacts;
  all.stepping = stepping_state();
  all.evaluated = world.workspace_.evaluated == world.state_.stamp();
  all.evaluations = evaluate.count, all.evaluation_seconds = evaluate.seconds;
  all.statistics = statistics;
  all.within_run = doing == Doing::watching;
  if (all.within_run) all.statistics.total_seconds[statistics.changes > 0 ? 1 : 0] += detail::seconds_since(lap);
  all.progress = progress.mark();
  all.observed = observed, all.observed_at = observed_at, all.next_observation = next_look;
  all.events = events;
  return all;
}

void Simulation::Impl::continue_from(const RunState& from) {
  unadjusted.reset();
  history.clear();
  recover();
  world.restore(from.world);
  geometry.pairs.renew();
  make_methods();
  method->set_proposal(from.proposal);
  continue_stepping(from.stepping);
  queue.continue_from(from.queue, world);
  stops.set_deeper(from.queue.deeper_stops);
  balance = from.balance;
  ledger = {from.dissipated, from.work};
  ledger.projection = from.balance.projection;
  ledger.impacts = from.impacts;
  if (from.evaluated) evaluate_state();
  evaluate.count = from.evaluations, evaluate.seconds = from.evaluation_seconds;
  statistics = from.statistics;
  progress.continue_from(from.progress);
  continues = from.within_run;
  observed = from.observed, observed_at = from.observed_at, next_look = from.next_observation;
  events = from.events;
}

}  // namespace momentree
