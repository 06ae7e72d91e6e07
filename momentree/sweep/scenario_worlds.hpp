#pragma once
// Runs worlds of a sweep as whole simulations.
#include <atomic>
#include <cstdint>
#include <string>

#include <momentree/io/session.hpp>
#include <momentree/sweep/encoding.hpp>
#include <momentree/sweep/sweep.hpp>
#include <momentree/sweep/work_source.hpp>

namespace momentree::sweep {

/// Runs a simulation to `until` (s) as a world of the sweep: measures are recorded in `observation`, and the run ends early by
/// the sweep's rule, which counts as Status::ok. A limit on the number of steps gives Status::stalled. The observer and the
/// watcher of the simulation are left alone.
RunResult run_world(Simulation& simulation, double until, const StopRule& stop, Observation& observation);

/// Computes worlds from a sweep's scenario. Used by several threads at once.
class ScenarioWorlds {
 public:
  /// `stop`: ends the present worlds when it is set; null: they cannot be ended. The sweep must outlive this object.
  explicit ScenarioWorlds(const Sweep& sweep, const std::atomic<bool>* stop = nullptr) : sweep_(sweep), stop_(stop) {}

  /// One world. A world that cannot be run has `failure`. `ended`, if given, is set if the world was ended by `stop`.
  WorldResult run(std::uint64_t world, bool* ended = nullptr) const;
  /// The encoded results of a chunk; empty if it was ended by `stop`.
  std::string run(Chunk chunk) const;

 private:
  const Sweep& sweep_;
  const std::atomic<bool>* stop_;
};

}  // namespace momentree::sweep
