#include <momentree/sweep/stats/random.hpp>

#include <bit>

#include <momentree/base/check.hpp>

namespace momentree::sweep {
namespace {

constexpr std::uint64_t most_shuffled = 64;

// Fisher and Yates. Networks of few bits do not reach all permutations equally often.
std::uint64_t shuffled(std::uint64_t index, std::uint64_t size, std::uint64_t key) {
  std::array<std::uint8_t, most_shuffled> all{};
  for (std::uint64_t i = 0; i < size; ++i) {
    const std::uint64_t other = mix(mix(key) + i) % (i + 1);
    all[i] = all[other];
    all[other] = static_cast<std::uint8_t>(i);
  }
  return all[index];
}

}  // namespace

std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0], b = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
  return x ^ (x >> 31);
}

std::uint64_t Random::bits(std::uint64_t index) const {
  const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
  const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
  const auto four = philox({low(index), high(index), low(stream_), high(stream_)}, {low(seed_), high(seed_)});
  return std::uint64_t{four[1]} << 32 | four[0];
}

double Random::uniform(std::uint64_t index) const { return static_cast<double>((bits(index) >> 12) * 2 + 1) * 0x1p-53; }

std::uint64_t permute(std::uint64_t index, std::uint64_t size, std::uint64_t key) {
  MT_REQUIRE(index < size && size <= std::uint64_t{1} << 62, "an index below the size of the permutation");
  if (size <= most_shuffled) return shuffled(index, size, key);
  const int half = (static_cast<int>(std::bit_width(size - 1)) + 1) / 2;
  const std::uint64_t mask = (std::uint64_t{1} << half) - 1;
  // With few bits a round has few functions to choose from: more rounds make up for it.
  const int rounds = half < 8 ? 16 : 8;
  do {
    std::uint64_t left = index >> half, right = index & mask;
    for (int round = 0; round < rounds; ++round) {
      const std::uint64_t next = left ^ (mix(mix(key + static_cast<std::uint64_t>(round) * 0x9E3779B97F4A7C15) + right) & mask);
      left = right;
      right = next;
    }
    index = left << half | right;
  } while (index >= size);
  return index;
}

}  // namespace momentree::sweep
