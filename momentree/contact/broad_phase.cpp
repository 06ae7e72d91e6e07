#include <momentree/contact/broad_phase.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/contact/indices.hpp>

namespace momentree::contact {

namespace {

double along_axis(const Vec3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

int widest_axis(std::span<const Ball> balls) {
  Vec3 sum{}, squares{};
  for (const Ball& ball : balls) {
    const Vec3& c = ball.centre;
    sum += c, squares += Vec3{c.x * c.x, c.y * c.y, c.z * c.z};
  }
  const double n = static_cast<double>(balls.size());
  int widest = 0;
  double most = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const double mean = along_axis(sum, axis) / n, spread = along_axis(squares, axis) / n - mean * mean;
    if (spread > most) most = spread, widest = axis;
  }
  return widest;
}

}  // namespace

std::span<const std::pair<int, int>> BroadPhase::find(std::span<const Ball> balls) {
  found_.clear();
  if (balls.empty()) return found_;
  const int axis = widest_axis(balls);
  if (order_.size() != balls.size()) {
    order_.resize(balls.size());
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<int>(i);
  }
  const auto low = [&](int i) {
    const double x = along_axis(balls[at(i)].centre, axis) - balls[at(i)].radius;
    return std::isnan(x) ? -HUGE_VAL : x;  // of motions that diverged
  };
  const auto before = [&](int i, int k) {
    const double a = low(i), b = low(k);
    return a < b || (a == b && i < k);
  };
  if (!std::is_sorted(order_.begin(), order_.end(), before)) std::sort(order_.begin(), order_.end(), before);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const Ball& one = balls[at(order_[i])];
    const double end = along_axis(one.centre, axis) + one.radius;
    for (std::size_t k = i + 1; k < order_.size() && low(order_[k]) <= end; ++k) {
      const Ball& other = balls[at(order_[k])];
      const Vec3 apart = one.centre - other.centre;
      const double reach = one.radius + other.radius;
      if (dot(apart, apart) <= reach * reach) found_.push_back(std::minmax(order_[i], order_[k]));
    }
  }
  std::sort(found_.begin(), found_.end());
  return found_;
}

}  // namespace momentree::contact
