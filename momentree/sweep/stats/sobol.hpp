#pragma once
// Sobol's low-discrepancy sequence.
#include <cstdint>

namespace momentree::sweep {

constexpr int sobol_dimensions = 64;

/// Point `index` (< 2^52) of the sequence in one dimension (< sobol_dimensions) as a multiple of 2^-52, without scrambling:
/// direction numbers of Joe and Kuo (new-joe-kuo-6), in the order of the Gray code.
std::uint64_t sobol_bits(std::uint64_t index, int dimension);

/// The same with Owen's nested uniform scrambling, which `seed` chooses: each point is uniform in (0, 1), and every power of two
/// of consecutive points from an aligned index on is as evenly spread as without scrambling. An odd multiple of 2^-53.
double sobol(std::uint64_t index, int dimension, std::uint64_t seed);

}  // namespace momentree::sweep
