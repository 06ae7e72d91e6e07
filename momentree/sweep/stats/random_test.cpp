#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/sampling_test_support.hpp>

using namespace momentree::sweep;

TEST_CASE("Philox4x32-10 gives the known answers of Random123") {
  using Four = std::array<std::uint32_t, 4>;
  const std::uint32_t ones = 0xFFFFFFFF;
  CHECK(philox({0, 0, 0, 0}, {0, 0}) == Four{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(philox({ones, ones, ones, ones}, {ones, ones}) == Four{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        Four{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
  CHECK(Random(0, 0).bits(0) == 0xe169c58d6627e8d5);
  CHECK(Random(~std::uint64_t{0}, ~std::uint64_t{0}).bits(~std::uint64_t{0}) == 0x41c83b0e408f276d);
}

TEST_CASE("uniform numbers are uniform, and streams, seeds and neighbours are independent") {
  constexpr std::size_t n = 100'000;
  std::vector<double> first(n), other_stream(n), other_seed(n), next(n);
  for (std::size_t i = 0; i < n; ++i) {
    first[i] = Random(1, 2).uniform(i);
    next[i] = Random(1, 2).uniform(i + 1);
    other_stream[i] = Random(1, 3).uniform(i);
    other_seed[i] = Random(2, 2).uniform(i);
    REQUIRE((first[i] > 0 && first[i] < 1));
    REQUIRE(std::ldexp(first[i], 53) == std::floor(std::ldexp(first[i], 53)));
    REQUIRE(1 - (1 - first[i]) == first[i]);
  }
  CHECK(distance_from(first, [](double x) { return x; }) < 1.95);
  for (const auto* other : {&other_stream, &other_seed, &next})
    CHECK(std::abs(correlation_of(first, *other)) < 3.3 / std::sqrt(static_cast<double>(n)));
}

TEST_CASE("permute is a bijection for every size and key") {
  std::vector<std::uint64_t> sizes{100, 1000, 4095, 4096, 4097, 100'003};
  for (std::uint64_t size = 1; size <= 70; ++size) sizes.push_back(size);
  for (const std::uint64_t size : sizes)
    for (std::uint64_t key : {0, 1, 77}) {
      std::vector<bool> seen(size, false);
      for (std::uint64_t i = 0; i < size; ++i) {
        const std::uint64_t image = permute(i, size, key);
        REQUIRE(image < size);
        REQUIRE(!seen[image]);
        seen[image] = true;
      }
    }
  CHECK(permute((std::uint64_t{1} << 62) - 1, std::uint64_t{1} << 62, 5) < std::uint64_t{1} << 62);
}

TEST_CASE("small permutations are all equally likely") {
  for (const std::uint64_t size : {2, 3, 4, 5}) {
    std::map<std::vector<std::uint64_t>, double> counts;
    constexpr int keys = 24'000;
    for (int key = 0; key < keys; ++key) {
      std::vector<std::uint64_t> images;
      for (std::uint64_t i = 0; i < size; ++i)
        images.push_back(permute(i, size, Random(3, size).bits(static_cast<std::uint64_t>(key))));
      ++counts[images];
    }
    const double kinds = std::tgamma(static_cast<double>(size) + 1), expected = keys / kinds;
    CHECK(static_cast<double>(counts.size()) == kinds);
    double chi_square = 0;
    for (const auto& [images, count] : counts) chi_square += (count - expected) * (count - expected) / expected;
    CAPTURE(size);
    CHECK(chi_square < kinds + 4 * std::sqrt(2 * kinds));
  }
}

TEST_CASE("large permutations have no trend") {
  constexpr std::uint64_t size = 10'007;
  std::vector<double> places, images, steps, next;
  for (std::uint64_t i = 0; i < size; ++i) {
    places.push_back(static_cast<double>(i));
    images.push_back(static_cast<double>(permute(i, size, 42)));
    next.push_back(static_cast<double>(permute((i + 1) % size, size, 42)));
  }
  CHECK(std::abs(correlation_of(places, images)) < 0.033);
  CHECK(std::abs(correlation_of(images, next)) < 0.033);
}
