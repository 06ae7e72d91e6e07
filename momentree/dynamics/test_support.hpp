#pragma once
// Random links, and how far two results are from one another: for tests of the ways of an evaluation.
#include <algorithm>
#include <cmath>
#include <random>

#include <momentree/tree/model.hpp>

namespace momentree::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(engine_()) / 4294967295.0); }
  bool chance(double p) { return between(0, 1) < p; }
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }
  Vec3 vector(double size) {
    const double x = between(-size, size), y = between(-size, size), z = between(-size, size);
    return {x, y, z};
  }

 private:
  std::mt19937 engine_;
};

/// Links as machines have them: twists of 0, 90° and any angle, lengths that are zero or not; some with any placement.
inline Pose random_place(Random& random) {
  if (random.chance(0.15)) {
    const Vec3 r = random.vector(0.4), e = random.vector(0.8);
    return {r, normalized(Quat{1, e.x, e.y, e.z})};
  }
  const double alphas[] = {0, std::acos(0.0), std::acos(0.0), -std::acos(0.0), 0.05, random.between(-2, 2)};
  const double alpha = alphas[random.below(6)];
  const double a = random.chance(0.3) ? 0 : random.between(-0.4, 0.4), d = random.chance(0.4) ? 0 : random.between(-0.4, 0.4);
  const double aside = alpha == 0.05 ? 0.3 : 0;  // the common normal is far off
  return {{a, aside - d * std::sin(alpha), d * std::cos(alpha)}, from_axis_angle(x_axis, alpha)};
}

inline double largest(const double* a, int n) {
  double x = 0;
  for (int i = 0; i < n; ++i) x = std::max(x, std::fabs(a[i]));
  return x;
}
/// Largest difference, as a share of the largest number.
inline double difference(const double* a, const double* b, int n) {
  double x = 0;
  for (int i = 0; i < n; ++i) x = std::max(x, std::fabs(a[i] - b[i]));
  return n == 0 || x == 0 ? x : x / std::max(largest(a, n), largest(b, n));
}
}  // namespace momentree::test
