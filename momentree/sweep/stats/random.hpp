#pragma once
// Counter-based random numbers: number i of a stream is a function of seed, stream and i alone, so that worlds can be drawn in
// any order and by any thread.
#include <array>
#include <cstdint>

namespace momentree::sweep {

/// Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key);

/// A hash of 64 bits: the finaliser of SplitMix64, a bijection in which every bit of the result depends on every bit of x.
std::uint64_t mix(std::uint64_t x);

/// Independent streams of random numbers, by index.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}
  /// 64 random bits.
  std::uint64_t bits(std::uint64_t index) const;
  /// An odd multiple of 2^-53: in (0, 1), never 0 or 1, and 1 - uniform() is exact.
  double uniform(std::uint64_t index) const;

 private:
  std::uint64_t seed_, stream_;
};

/// The image of `index` under a pseudo-random permutation of 0 … size - 1, which `key` chooses. Needs no memory: a Feistel
/// network on the next power of 4, applied until the result is below `size`. `index` < `size` <= 2^62.
std::uint64_t permute(std::uint64_t index, std::uint64_t size, std::uint64_t key);

}  // namespace momentree::sweep
