#include <momentree/sweep/run.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <mutex>
#include <numeric>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/sweep/plan/read_sweep.hpp>
#include <momentree/sweep/scenario_worlds.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::sweep {

Sweep load(const std::string& path) {
  ReadSweep read = read_sweep(path);
  if (!read.sweep) throw io::InputError(std::move(read.diagnostics));
  return std::move(*read.sweep);
}

void for_each_block(std::uint64_t worlds, std::uint64_t block, int threads,
                    const std::function<void(std::uint64_t, std::uint64_t)>& f) {
  block = std::max<std::uint64_t>(block, 1);
  if (threads <= 0) threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1u));
  std::atomic<std::uint64_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&]() noexcept {
    try {
      for (std::uint64_t first = next.fetch_add(block); first < worlds && !failed; first = next.fetch_add(block))
        f(first, std::min(block, worlds - first));
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    const std::uint64_t blocks = (worlds + block - 1) / block;
    try {
      while (others.size() + 1 < std::min(static_cast<std::uint64_t>(threads), blocks)) others.emplace_back(work);
    } catch (const std::system_error& error) {
      failed = true;
      throw_error({"cannot start " + std::to_string(threads) + " threads: " + error.code().message(), "", "use fewer"});
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

SweepResults run(const Sweep& sweep, const RunOptions& options) {
  const ScenarioWorlds worlds(sweep, lanes_for(sweep, options.lanes), options.stop);
  const std::size_t columns = sweep.measures.size(), components = sweep.plan->size();
  SweepResults results;
  results.worlds = sweep.worlds();
  results.values.resize(results.worlds * components);
  results.measures.assign(results.worlds * columns, NAN);
  std::mutex mutex;
  std::atomic<bool> ended = false;
  for_each_block(results.worlds, worlds.at_once(), options.threads, [&](std::uint64_t first, std::uint64_t count) {
    std::vector<std::uint64_t> block(count);
    std::iota(block.begin(), block.end(), first);
    for (const std::uint64_t world : block)
      sweep.plan->values(world, std::span(results.values).subspan(world * components, components));
    if (ended) return;
    const bool all = worlds.run(block, [&](std::size_t place, WorldResult result) {
      const std::uint64_t world = first + place;
      if (result.done()) {
        std::copy(result.measures.begin(), result.measures.end(),
                  results.measures.begin() + static_cast<std::ptrdiff_t>(world * columns));
        return;
      }
      const std::lock_guard lock(mutex);
      results.failures.emplace(world, std::move(result.failure));
    });
    if (!all) ended = true;
  });
  results.complete = !ended;
  return results;
}

}  // namespace momentree::sweep
