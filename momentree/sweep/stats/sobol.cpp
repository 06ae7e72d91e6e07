#include <momentree/sweep/stats/sobol.hpp>

#include <array>
#include <bit>

#include <momentree/base/check.hpp>
#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/sobol_table.hpp>

namespace momentree::sweep {
namespace {

constexpr int sobol_width = 52;
using Directions = std::array<std::array<std::uint64_t, sobol_width>, sobol_dimensions>;

// The recurrence of Joe and Kuo, "Remark on Algorithm 659", ACM TOMS 29 (2003).
constexpr Directions make_directions() {
  Directions all{};
  for (std::size_t d = 0; d < all.size(); ++d) {
    auto& v = all[d];
    const SobolEntry& entry = sobol_table[d];
    const int degree = std::bit_width(static_cast<unsigned>(entry.polynomial)) - 1;
    for (int j = 0; j < sobol_width; ++j) {
      const auto at = static_cast<std::size_t>(j);
      if (degree == 0 || j < degree) {
        v[at] = std::uint64_t{degree == 0 ? 1u : entry.first[at]} << (sobol_width - 1 - j);
        continue;
      }
      const std::uint64_t old = v[static_cast<std::size_t>(j - degree)];
      v[at] = old ^ (old >> degree);
      for (int k = 1; k < degree; ++k)
        if (entry.polynomial >> (degree - k) & 1) v[at] ^= v[static_cast<std::size_t>(j - k)];
    }
  }
  return all;
}
constexpr Directions sobol_directions = make_directions();

}  // namespace

std::uint64_t sobol_bits(std::uint64_t index, int dimension) {
  MT_REQUIRE(dimension >= 0 && dimension < sobol_dimensions && index >> sobol_width == 0,
             "a point and a dimension of the sequence");
  const auto& v = sobol_directions[static_cast<std::size_t>(dimension)];
  std::uint64_t x = 0;
  for (std::uint64_t gray = index ^ index >> 1; gray; gray &= gray - 1) x ^= v[static_cast<std::size_t>(std::countr_zero(gray))];
  return x;
}

double sobol(std::uint64_t index, int dimension, std::uint64_t seed) {
  const std::uint64_t x = sobol_bits(index, dimension);
  const std::uint64_t key = Random(seed, static_cast<std::uint64_t>(dimension)).bits(0);
  // Each digit is flipped or not, by a hash of the digits before it. A leading 1 tells prefixes of different lengths apart.
  std::uint64_t flips = 0;
  for (int digit = sobol_width - 1; digit >= 0; --digit) {
    const std::uint64_t prefix = std::uint64_t{1} << (sobol_width - 1 - digit) | x >> (digit + 1);
    flips |= (mix(key ^ mix(prefix)) & 1) << digit;
  }
  return static_cast<double>((x ^ flips) * 2 + 1) * 0x1p-53;
}

}  // namespace momentree::sweep
