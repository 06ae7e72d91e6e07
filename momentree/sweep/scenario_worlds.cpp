#include <momentree/sweep/scenario_worlds.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/io/diagnostic.hpp>

namespace momentree::sweep {

RunResult run_world(Simulation& simulation, double until, const StopRule& stop, Observation& observation) {
  bool stopped = false, too_long = false;
  std::size_t looked_at = 0;
  const long first_step = simulation.statistics().steps;
  if (observation.samples() || !stop.events.empty() || stop.steps > 0)
    simulation.sample([&](const World&) {
      if (observation.samples()) observation.sample(simulation);
      const std::vector<Event>& events = simulation.events();
      for (; looked_at < events.size() && !stopped; ++looked_at)
        stopped = std::find(stop.events.begin(), stop.events.end(), events[looked_at].name) != stop.events.end();
      too_long = stop.steps > 0 && simulation.statistics().steps - first_step > stop.steps;
      return !stopped && !too_long;
    });
  RunResult result;
  for (const double instant : observation.instants()) {
    if (instant < simulation.time() || instant > until || !result || stopped) continue;
    result = simulation.run_until(instant);
    if (result) observation.instant(simulation, instant);
  }
  if (result) result = simulation.run_until(until);
  simulation.sample({});
  if (stopped && result.status == Status::interrupted) return {};
  if (too_long && result.status == Status::interrupted)
    return {Status::stalled, "more than " + std::to_string(stop.steps) + " steps, the limit of [stop]"};
  return result;
}

namespace {

std::string text_of(const io::Diagnostic& problem) {
  return problem.hint.empty() ? problem.what : problem.what + "; " + problem.hint;
}

}  // namespace

WorldResult ScenarioWorlds::run(std::uint64_t world, bool* ended) const {
  WorldResult result;
  const auto failed = [&result](std::string why) {
    result.failure = why.empty() ? "it ended early" : std::move(why);
    result.measures.clear();
    return result;
  };
  try {
    io::ReadResult read = io::read_scenario_again(*sweep_.scenario, sweep_.overrides(world));
    if (!read.scenario) {
      for (const io::Diagnostic& each : read.diagnostics)
        if (each.severity == io::Severity::error) return failed(text_of(each));
      return failed("");
    }
    io::Session session(std::make_shared<const io::Scenario>(std::move(*read.scenario)));
    const std::vector<io::Diagnostic> warnings = session.schedule();
    Simulation& simulation = session.simulation();
    // Steps end at the instants at which `run` writes rows: the results have the same bits as those of that run.
    if (session.scenario().output_every > 0)
      simulation.observe(session.scenario().output_every, [](const World&) { return true; });
    bool cancelled = false;
    if (stop_ != nullptr)
      simulation.watch([this, &cancelled](double) { return !(cancelled = stop_->load(std::memory_order_relaxed)); });
    Observation observation(sweep_.measures);
    const RunResult outcome = run_world(simulation, session.scenario().until, sweep_.stop, observation);
    if (cancelled && ended != nullptr) *ended = true;
    if (!outcome) return failed(outcome.reason);
    result.measures = observation.results(simulation);
  } catch (const Error& error) {
    return failed(error.hint.empty() ? error.problem : error.problem + "; " + error.hint);
  }
  return result;
}

std::string ScenarioWorlds::run(Chunk chunk) const {
  std::string encoded;
  bool ended = false;
  for (std::uint64_t i = 0; i < chunk.count; ++i) {
    if (stop_ != nullptr && stop_->load(std::memory_order_relaxed)) return {};
    encode(run(chunk.first + i, &ended), encoded);
    if (ended) return {};
  }
  return encoded;
}

}  // namespace momentree::sweep
