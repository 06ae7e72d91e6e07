#pragma once
// Work that is divided into numbered items, and handed out in chunks.
#include <compare>
#include <cstdint>
#include <optional>
#include <string>

namespace momentree::sweep {

/// The items first … first + count − 1.
struct Chunk {
  std::uint64_t first = 0, count = 0;
  auto operator<=>(const Chunk&) const = default;
};

/// On rank 0: what is to be done, and where results go. Called from several threads.
class WorkSource {
 public:
  virtual ~WorkSource() = default;
  /// A chunk to be computed; none if all have been handed out (later, some may be given again).
  virtual std::optional<Chunk> next() = 0;
  /// The result of a chunk. A chunk may be finished several times, with the same result: it counts once. Throws Error if the
  /// result cannot be stored.
  virtual void finished(Chunk chunk, std::string encoded) = 0;
  /// Whether all chunks are finished.
  virtual bool complete() const = 0;
  /// Lets the next call of next() return this chunk again, unless it is finished.
  virtual void give_again(Chunk chunk) = 0;
};

}  // namespace momentree::sweep
