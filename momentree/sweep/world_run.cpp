#include <momentree/sweep/world_run.hpp>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include <momentree/base/error.hpp>

namespace momentree::sweep {

WorldRun::WorldRun(Simulation& simulation, double until, const StopRule& stop, Observation& observation)
    : simulation_(simulation), until_(until), stop_(stop), observation_(observation), first_step_(simulation.statistics().steps) {
  const std::vector<double>& instants = observation.instants();
  while (instant_ < instants.size() && instants[instant_] < simulation.time()) ++instant_;
  if (observation.samples() || !stop.events.empty() || stop.steps > 0)
    simulation.sample([this](const World&) { return sample(); });
}

bool WorldRun::sample() {
  try {
    if (observation_.samples()) observation_.sample(simulation_);
  } catch (const Error& error) {
    problem_ = error.problem;
    return false;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    problem_ = error.what();
    return false;
  }
  const std::vector<Event>& events = simulation_.events();
  for (; looked_at_ < events.size() && !stopped_; ++looked_at_)
    stopped_ = std::find(stop_.events.begin(), stop_.events.end(), events[looked_at_].name) != stop_.events.end();
  too_long_ = stop_.steps > 0 && simulation_.statistics().steps - first_step_ > stop_.steps;
  return !stopped_ && !too_long_;
}

std::optional<double> WorldRun::next() const {
  if (over_ || stopped_ || !last_) return std::nullopt;
  const std::vector<double>& instants = observation_.instants();
  return instant_ < instants.size() && instants[instant_] <= until_ ? instants[instant_] : until_;
}

void WorldRun::reached(const RunResult& result) {
  last_ = result;
  const std::vector<double>& instants = observation_.instants();
  if (instant_ < instants.size() && instants[instant_] <= until_) {
    // An end by the rule at this very instant is no earlier than it.
    if (last_ || (stopped_ && simulation_.time() == instants[instant_])) observation_.instant(simulation_, instants[instant_]);
    ++instant_;
  } else {
    over_ = true;
  }
}

RunResult WorldRun::result() const {
  if (!problem_.empty()) return {Status::refused, problem_};
  if (stopped_ && last_.status == Status::interrupted) return {};
  if (too_long_ && last_.status == Status::interrupted)
    return {Status::stalled, "more than " + std::to_string(stop_.steps) + " steps, the limit of [stop]"};
  return last_;
}

RunResult run_world(Simulation& simulation, double until, const StopRule& stop, Observation& observation) {
  WorldRun run(simulation, until, stop, observation);
  while (const std::optional<double> time = run.next()) run.reached(simulation.run_until(*time));
  return run.result();
}

}  // namespace momentree::sweep
