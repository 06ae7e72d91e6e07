#pragma once
// Sweeps in C++: all worlds of a sweep file, or any function of many worlds, on threads.
//
//     const sweep::Sweep sweep = sweep::load("capture_loads.toml");
//     const sweep::SweepResults results = sweep::run(sweep);
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <momentree/sweep/lanes.hpp>
#include <momentree/sweep/plan/plan.hpp>
#include <momentree/sweep/sweep.hpp>

namespace momentree::sweep {

/// Reads a sweep file. Throws io::InputError with all its errors.
[[nodiscard]] Sweep load(const std::string& path);

struct RunOptions {
  int threads = 0;                          ///< 0: as many as the machine has
  Lanes lanes = lanes_of("auto");           ///< for worlds that fit into them
  const std::atomic<bool>* stop = nullptr;  ///< ends the run when it is set; null: it cannot be ended
};

struct SweepResults {
  std::uint64_t worlds = 0;
  std::vector<double> values;    ///< the varied values, a row per world (Plan::values)
  std::vector<double> measures;  ///< a row per world, in the order of Sweep::measures; NaN: absent, flags are 0, 1
  std::map<std::uint64_t, std::string> failures;  ///< worlds that failed, and why; their measures are NaN
  bool complete = false;                          ///< false: ended by `stop`; worlds that were not reached are NaN
};

/// Runs all worlds, with everything in memory; the same numbers as `momentree sweep` to the bit, for any number of threads. For
/// more worlds than memory holds, use the command. Throws Error: too few threads can be started; out of memory.
[[nodiscard]] SweepResults run(const Sweep& sweep, const RunOptions& options = {});

/// Calls f(first, count) for all worlds below `worlds`, in blocks of at most `block`, on several threads in any order; with 0
/// threads, on as many as the machine has. f must not use what other calls change; if one throws, no further block is begun, and
/// the exception is thrown again at the end.
void for_each_block(std::uint64_t worlds, std::uint64_t block, int threads,
                    const std::function<void(std::uint64_t, std::uint64_t)>& f);

}  // namespace momentree::sweep
