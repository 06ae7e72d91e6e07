#pragma once
// Machine code for whole mechanisms, made while a simulation runs, for each topology that it reaches (paper, section 2).
#include <memory>
#include <span>
#include <string>

#include <momentree/dynamics/steps/rates_function.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

struct KernelCacheOptions {
  /// Evaluations with more operations, with closed loops twice as many, run the kernels themselves, which are then as fast.
  long most_operations = 8000;
  /// Largest number of topologies to compile: a world with a new topology after every event would spend its time on that.
  long most_topologies = 100;
  /// Largest number of choices of independent rows to compile for one topology with closed loops.
  long most_choices = 8;
};

/// Statistics of the topologies requested from a cache; with closed loops, of topologies with one choice of rows each.
struct KernelCacheStatistics {
  long compiled = 0;     ///< topologies
  long found_again = 0;  ///< requests for a topology compiled before
  long left = 0;         ///< topologies too large or too many for code, or for which there is no machine code here, and requests
                         ///< for which stages_take_rates and stages_take_loop_rates are false: they run the kernels themselves
  double seconds = 0;    ///< time to make code (s)
};

/// Code for every requested topology, kept while the cache or a provider exists. Topologies are distinguished by what the kernels
/// read: forest, kinds, constants, gravity, armatures and locks, but not dampers or springs.
/// Code for momenta and code for velocities are made when they are asked for, and count as separate topologies. Code for closed
/// loops is in velocities, and for one choice of independent rows: each choice counts as a topology. Code is made inside the
/// call, in milliseconds, so the same run gives the same bits every time. Copies share their contents; thread-safe.
class KernelCache {
 public:
  explicit KernelCache(KernelCacheOptions options = {});

  /// For Simulation::use_generated.
  RatesProvider provider() const;
  /// The code for the tree's present topology and states in momenta, or null; see KernelCacheStatistics::left and message().
  RatesFunction find(const Tree& tree) const;
  /// The same for states in velocities.
  VelocityRatesFunction find_velocities(const Tree& tree) const;
  /// The same with closed loops, for these chosen rows, in ascending order.
  LoopRatesFunction find_loops(const Tree& tree, std::span<const int> rows) const;

  KernelCacheStatistics statistics() const;
  /// The first reason for which a topology has no code although it should; empty if there was none.
  std::string message() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace momentree
