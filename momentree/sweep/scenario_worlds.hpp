#pragma once
// Runs worlds of a sweep as simulations: several in SIMD lanes where they are simple enough, otherwise one by one.
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include <momentree/sweep/lanes.hpp>
#include <momentree/sweep/machines/encoding.hpp>
#include <momentree/sweep/machines/work_source.hpp>

namespace momentree::sweep {

/// Computes worlds from a sweep's scenario. Used by several threads at once. Results do not depend on which worlds are computed
/// together, nor on the number of threads.
class ScenarioWorlds {
 public:
  /// `lanes`: for the worlds that fit into them. `stop`: ends the present worlds when it is set; null: they cannot be ended. The
  /// sweep must outlive this object.
  explicit ScenarioWorlds(const Sweep& sweep, Lanes lanes, const std::atomic<bool>* stop = nullptr);

  /// The smallest number of worlds that fill the lanes.
  std::uint64_t at_once() const;
  /// Whether that world can run in lanes: see Lockstep::fits(); in addition, no measure may need the energy ledger.
  [[nodiscard]] bool fits(std::uint64_t world) const;
  /// Whether lanes save time. The first world fits into them; if it has closed loops, whose steps cost more in one lane than
  /// alone, another one of the first worlds shares its lanes.
  [[nodiscard]] bool gain_by_lanes() const;
  /// Takes the result of the world at that place of a list. A world that cannot be run has `failure`.
  using Take = std::function<void(std::size_t, WorldResult)>;
  /// Runs these worlds and passes on their results, in any order. False: they were ended by `stop`.
  [[nodiscard]] bool run(std::span<const std::uint64_t> worlds, const Take& take) const;
  /// One world.
  WorldResult run(std::uint64_t world) const;
  /// The encoded results of a chunk; empty if it was ended by `stop`.
  std::string run(Chunk chunk) const;

 private:
  class Running;
  class Together;
  std::unique_ptr<Running> start(std::uint64_t world) const;
  static WorldResult result_of(Running& world);

  const Sweep& sweep_;
  Lanes lanes_;
  const std::atomic<bool>* stop_;
};

}  // namespace momentree::sweep
