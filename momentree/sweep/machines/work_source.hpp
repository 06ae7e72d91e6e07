#pragma once
// Chunks of worlds: how a sweep's work is given out and its results are collected.
#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace momentree::sweep {

/// Consecutive worlds: from `first` on, `count` of them.
struct Chunk {
  std::uint64_t first = 0, count = 0;
  friend auto operator<=>(const Chunk&, const Chunk&) = default;
};

/// The work of a sweep, on the process that keeps its journal. Its functions may be called by several threads at once.
class WorkSource {
 public:
  virtual ~WorkSource() = default;
  /// A chunk to compute; nothing if all have been given out. Some may still be given again.
  virtual std::optional<Chunk> next() = 0;
  /// Takes the encoded results of a chunk. A chunk that comes a second time is ignored. Throws Error if they cannot be stored.
  virtual void finished(Chunk chunk, std::string encoded) = 0;
  /// Whether every world has its result.
  virtual bool complete() const = 0;
  /// The worker that had this chunk is lost or slow: another one may have it.
  virtual void give_again(Chunk chunk) = 0;
};

/// Computes the worlds of a chunk and returns their encoded results; empty if it was told to stop. Called by several threads at
/// once.
using RunChunk = std::function<std::string(Chunk)>;

}  // namespace momentree::sweep
