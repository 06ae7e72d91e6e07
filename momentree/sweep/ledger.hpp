#pragma once
// Which rank has which chunks, and which of them another rank should have.
#include <chrono>
#include <map>
#include <optional>
#include <vector>

#include <momentree/sweep/machines/work_source.hpp>

namespace momentree::sweep {

/// Chunks that were given to ranks and are not finished. A rank computes its oldest chunks, one per thread; the others wait.
class Ledger {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit Ledger(int ranks) : ranks_(static_cast<std::size_t>(ranks)) {}

  void join(int rank, int threads) { at(rank).threads = threads; }
  /// 0 until the rank has joined.
  int threads(int rank) const { return at(rank).threads; }
  int held(int rank) const { return static_cast<int>(at(rank).chunks.size()); }

  void give(int rank, Chunk chunk, Time now);
  /// Takes a chunk from every rank that has it. Returns the other ranks that had it. `seconds`: how long it took.
  std::vector<int> finish(int rank, Chunk chunk, double seconds, Time now);

  struct Again {
    Chunk chunk;
    std::optional<int> from;  ///< the rank that should drop it, because it has not started it
  };
  /// The chunk of another rank that an idle `rank` should compute: one that waits, or one that has been running for more than
  /// twice as long as chunks of its size take, four times if two ranks have it, and so on. Removes it from `from`.
  std::optional<Again> overdue(int rank, Time now);

 private:
  struct Held {
    Chunk chunk;
    Time since;  ///< when the rank got it, or became free for it
  };
  struct Rank {
    int threads = 0;
    std::vector<Held> chunks;
  };
  Rank& at(int rank) { return ranks_[static_cast<std::size_t>(rank)]; }
  const Rank& at(int rank) const { return ranks_[static_cast<std::size_t>(rank)]; }
  void remove(int rank, Chunk chunk, Time now);
  double patience(Chunk chunk, int copies) const;

  std::vector<Rank> ranks_;
  std::map<Chunk, int> copies_;  ///< how many ranks have it
  double seconds_ = 0;           ///< of all finished chunks
  std::uint64_t items_ = 0;      ///< in these
};

}  // namespace momentree::sweep
