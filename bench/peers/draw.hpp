#pragma once
#include <random>

#include <Eigen/Core>

namespace peers {

/// Random numbers that are the same with every standard library.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(engine_()) / 4294967295.0); }
  Eigen::Vector3d within(double size) {
    const double x = between(-size, size), y = between(-size, size), z = between(-size, size);
    return {x, y, z};
  }

 private:
  std::mt19937 engine_;
};

}  // namespace peers
