#include <momentree/export/picture/projection.hpp>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string>

#include <momentree/base/error.hpp>

namespace momentree::io {
namespace {

Vec3 upwards(const Vec3& gravity) { return norm(gravity) > 0 ? normalized(-gravity) : Vec3{0, 0, 1}; }

Vec3 without(const Vec3& a, const Vec3& direction) { return a - dot(a, direction) * direction; }

/// Principal axes of a cloud of points, widest first, with the standard deviation along each. Jacobi rotations.
struct Spread {
  std::array<Vec3, 3> axis;
  std::array<double, 3> width;
};

Spread principal_axes(std::span<const Vec3> points) {
  Vec3 mean{};
  for (const Vec3& p : points) mean += (1.0 / static_cast<double>(points.size())) * p;
  double a[3][3] = {}, v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Vec3& p : points) {
    const double d[3] = {p.x - mean.x, p.y - mean.y, p.z - mean.z};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) a[i][j] += d[i] * d[j] / static_cast<double>(points.size());
  }
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (const auto [i, j] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
      if (a[i][j] == 0) continue;
      const double angle = 0.5 * std::atan2(2 * a[i][j], a[i][i] - a[j][j]), c = std::cos(angle), s = std::sin(angle);
      const auto turn = [&](double& x, double& y) {
        const double old = x;
        x = c * old + s * y;
        y = c * y - s * old;
      };
      for (int k = 0; k < 3; ++k) turn(a[i][k], a[j][k]);
      for (int k = 0; k < 3; ++k) turn(a[k][i], a[k][j]), turn(v[k][i], v[k][j]);
    }
  }
  Spread spread;
  std::array<int, 3> order{0, 1, 2};
  for (const auto [i, j] : {std::array{0, 1}, std::array{1, 2}, std::array{0, 1}})
    if (a[order[static_cast<std::size_t>(i)]][order[static_cast<std::size_t>(i)]] <
        a[order[static_cast<std::size_t>(j)]][order[static_cast<std::size_t>(j)]])
      std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(j)]);
  for (std::size_t k = 0; k < 3; ++k) {
    const int n = order[k];
    spread.axis[k] = {v[0][n], v[1][n], v[2][n]};
    spread.width[k] = std::sqrt(std::max(0.0, a[n][n]));
  }
  return spread;
}

/// Of the two sides of a view, the one from which the picture's right is a positive world direction.
View facing(const View& view) {
  const Vec3& r = view.right;
  const double largest = std::abs(r.x) >= std::abs(r.y) - 1e-9 && std::abs(r.x) >= std::abs(r.z) - 1e-9 ? r.x
                         : std::abs(r.y) >= std::abs(r.z) - 1e-9                                        ? r.y
                                                                                                        : r.z;
  if (largest > 0) return view;
  return {-view.right, view.up, cross(view.up, -view.right)};
}

View tilted(const View& level, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {level.right, c * level.up + s * level.look, c * level.look - s * level.up};
}

}  // namespace

View view_along(const Vec3& look, const Vec3& gravity) {
  if (norm(look) == 0 || !std::isfinite(norm(look)))
    throw_error({"the direction of view is zero", "--look", "for example --look 0,0,-1"});
  const Vec3 forward = normalized(look);
  for (const Vec3& candidate : {upwards(gravity), Vec3{0, 0, 1}, Vec3{0, 1, 0}, Vec3{1, 0, 0}}) {
    const Vec3 up = without(candidate, forward);
    if (norm(up) > 1e-3) return {cross(forward, normalized(up)), normalized(up), forward};
  }
  return {};
}

View choose_view(std::span<const Vec3> points, const Vec3& gravity) {
  if (points.empty()) return view_along({0, 1, 0}, gravity);
  const Vec3 up = upwards(gravity);
  const Spread spread = principal_axes(points);
  constexpr double flat = 1e-3;
  const bool line = spread.width[1] <= flat * spread.width[0];
  if (!line && spread.width[2] <= flat * spread.width[0]) {
    const Vec3& normal = spread.axis[2];
    const bool level = norm(without(up, normal)) < 0.05;
    return level ? view_along(-up, gravity) : facing(view_along(normal, gravity));
  }
  // The widest horizontal spread goes across the picture: rotate the two horizontal axes by the angle that makes their
  // covariance diagonal.
  const View any = view_along(std::abs(up.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{0, 0, -1}, -up);
  const Vec3 e1 = normalized(without(any.right, up)), e2 = cross(up, e1);
  double a = 0, b = 0, c = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double s = spread.width[k] * spread.width[k], x = dot(e1, spread.axis[k]), y = dot(e2, spread.axis[k]);
    a += s * x * x, b += s * x * y, c += s * y * y;
  }
  const double angle = 0.5 * std::atan2(2 * b, a - c);
  const Vec3 across = std::cos(angle) * e1 + std::sin(angle) * e2;
  const View level = facing({across, up, cross(up, across)});
  return line ? level : tilted(level, 20 * std::numbers::pi / 180);
}

Vec3 parse_direction(std::string_view text) {
  double at[3] = {};
  const char* begin = text.data();
  const char* end = begin + text.size();
  for (int k = 0; k < 3; ++k) {
    const auto [stop, error] = std::from_chars(begin, end, at[k]);
    const bool last = k == 2;
    if (error != std::errc{} || !std::isfinite(at[k]) || (last ? stop != end : (stop == end || *stop != ',')))
      throw_error({"'" + std::string(text) + "' is not a direction", "--look", "three numbers, for example --look 0,0,-1"});
    begin = last ? stop : stop + 1;
  }
  if (at[0] == 0 && at[1] == 0 && at[2] == 0)
    throw_error({"the direction of view is zero", "--look", "for example --look 0,0,-1"});
  return {at[0], at[1], at[2]};
}

}  // namespace momentree::io
