#pragma once
// A small pseudo-random number generator with the same sequence on every machine. Draw only once per statement: the order in
// which the arguments of a call are evaluated is not defined.
#include <cstdint>

#include <cmath>

#include <momentree/math/vec.hpp>

namespace momentree::oracle {

/// SplitMix64 (Steele, Lea, Flood 2014).
class Prng {
 public:
  explicit Prng(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 0xD1B54A32D192ED03ull) {}

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ull;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  /// In [0, 1).
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  /// In [low, high].
  int integer(int low, int high) { return low + static_cast<int>(next() % static_cast<std::uint64_t>(high - low + 1)); }
  bool chance(double probability) { return unit() < probability; }

  Vec3 vector(double size) {
    const double x = uniform(-size, size);
    const double y = uniform(-size, size);
    const double z = uniform(-size, size);
    return {x, y, z};
  }
  /// Uniform on the sphere, by rejection.
  Vec3 direction() {
    for (;;) {
      const Vec3 a = vector(1);
      const double n = norm(a);
      if (n > 0.1 && n <= 1) return (1 / n) * a;
    }
  }
  Quat rotation() {
    for (;;) {
      const double w = uniform(-1, 1);
      const double x = uniform(-1, 1);
      const double y = uniform(-1, 1);
      const double z = uniform(-1, 1);
      const double n = std::sqrt(w * w + x * x + y * y + z * z);
      if (n > 0.1 && n <= 1) return {w / n, x / n, y / n, z / n};
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace momentree::oracle
