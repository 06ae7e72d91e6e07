#pragma once
// How a simulation runs as a world of a sweep: measures are recorded, and it may end early.
#include <cstddef>
#include <optional>
#include <string>

#include <momentree/simulate/simulation.hpp>
#include <momentree/sweep/plan/measure.hpp>
#include <momentree/sweep/sweep.hpp>

namespace momentree::sweep {

/// The run of one world, in parts: `while (auto time = run.next()) run.reached(simulation.run_until(*time));`
class WorldRun {
 public:
  /// Measures are recorded in `observation`. Sets the sampler of the simulation during its own lifetime; observer and watcher are
  /// left alone.
  WorldRun(Simulation& simulation, double until, const StopRule& stop, Observation& observation);
  ~WorldRun() { simulation_.sample({}); }
  WorldRun(const WorldRun&) = delete;
  WorldRun& operator=(const WorldRun&) = delete;

  /// The time (s) to run to next; nothing: the run is over.
  std::optional<double> next() const;
  void reached(const RunResult& result);
  /// At the end: the end by the sweep's rule counts as Status::ok, a limit on the number of steps gives Status::stalled.
  RunResult result() const;

 private:
  bool sample();

  Simulation& simulation_;
  const double until_;
  const StopRule& stop_;
  Observation& observation_;
  const long first_step_;
  std::size_t looked_at_ = 0;  ///< events
  std::size_t instant_ = 0;    ///< of the observation, the next one
  bool stopped_ = false, too_long_ = false, over_ = false;
  std::string problem_;  ///< of a measure
  RunResult last_;
};

/// All of it.
RunResult run_world(Simulation& simulation, double until, const StopRule& stop, Observation& observation);

}  // namespace momentree::sweep
