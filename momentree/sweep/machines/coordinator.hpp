#pragma once
// Gives out the worlds of a sweep that are not in its journal yet, and stores the results.
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <unordered_set>
#include <vector>

#include <momentree/sweep/journal.hpp>
#include <momentree/sweep/machines/work_source.hpp>

namespace momentree::sweep {

struct CoordinatorOptions {
  int workers = 1;        ///< about how many work at once
  double seconds = 0.25;  ///< about how long a chunk should take; longer with so many workers that rank 0 would be too busy
  std::uint64_t largest = 16384;  ///< worlds in a chunk
  std::uint64_t multiple = 1;     ///< chunks have a multiple of this number of worlds, where the worlds that are left allow it
};

/// Chunks are small at first; as the cost of a world becomes known they grow until one takes about `seconds`, and towards the
/// end they shrink so that all workers end together. Results do not depend on the chunks.
class Coordinator final : public WorkSource {
 public:
  Coordinator(Journal& journal, CoordinatorOptions options);

  std::optional<Chunk> next() override;
  void finished(Chunk chunk, std::string encoded) override;
  bool complete() const override;
  void give_again(Chunk chunk) override;

  struct Progress {
    std::uint64_t done = 0;    ///< worlds with results, of this and earlier runs
    std::uint64_t failed = 0;  ///< of the worlds of this run
    double rate = 0;           ///< worlds per second, of this run
  };
  Progress progress() const;

 private:
  using Clock = std::chrono::steady_clock;
  std::uint64_t chunk_size() const;

  mutable std::mutex mutex_;
  Journal& journal_;
  CoordinatorOptions options_;
  std::deque<Chunk> gaps_;                      ///< worlds that nobody has been given, in order
  std::deque<Chunk> again_;                     ///< chunks to give another time
  std::unordered_set<std::uint64_t> finished_;  ///< first worlds of chunks finished in this run
  std::uint64_t ungiven_ = 0, done_ = 0, before_ = 0, failed_ = 0;
  Clock::time_point start_ = Clock::now();
};

}  // namespace momentree::sweep
