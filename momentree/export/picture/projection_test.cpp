#include <momentree/export/picture/projection.hpp>

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>

namespace momentree::io {
namespace {

bool same(const Vec3& a, const Vec3& b) { return norm(a - b) < 1e-9; }

void check_right_handed(const View& view) {
  CHECK(std::abs(norm(view.look) - 1) < 1e-12);
  CHECK(std::abs(norm(view.up) - 1) < 1e-12);
  CHECK(same(cross(view.look, view.up), view.right));
}

/// Points of an arc in the plane of `a` and `b`, wider along `a`.
std::vector<Vec3> arc(const Vec3& a, const Vec3& b) {
  std::vector<Vec3> points;
  for (int k = 0; k <= 20; ++k) points.push_back(3.0 * std::cos(0.15 * k) * a + std::sin(0.15 * k) * b);
  return points;
}

}  // namespace

TEST_CASE("a view projects at right angles: right is right and up is up") {
  const View view = view_along({0, 0, -2}, {0, -9.81, 0});
  check_right_handed(view);
  const Point2 p = view({3, 4, 5});
  CHECK(p.x == doctest::Approx(3));
  CHECK(p.y == doctest::Approx(-4));  // y of a picture points down
  CHECK(view.depth({0, 0, -1}) > view.depth({0, 0, 1}));
}

TEST_CASE("gravity points down in every view but one along it") {
  for (const Vec3& look : {Vec3{1, 0, 0}, Vec3{0.3, -0.5, 0.1}, Vec3{-1, 2, -3}}) {
    const View view = view_along(look, {0, 0, -9.81});
    check_right_handed(view);
    CHECK(std::abs(view({0, 0, -1}).x) < 1e-12);
    CHECK(view({0, 0, -1}).y > 0);
  }
  const View above = view_along({0, 0, -1}, {0, 0, -9.81});
  check_right_handed(above);
  CHECK(same(above.up, {0, 1, 0}));
}

TEST_CASE("a planar motion is seen along its normal, from the side that has the positive axis to the right") {
  const View upright = choose_view(arc({1, 0, 0}, {0, 1, 0}), {0, -9.81, 0});
  check_right_handed(upright);
  CHECK(same(upright.look, {0, 0, -1}));
  CHECK(same(upright.right, {1, 0, 0}));
  CHECK(same(choose_view(arc({0, 1, 0}, {0, 0, 1}), {0, 0, -9.81}).right, {0, 1, 0}));
}

TEST_CASE("a motion in a horizontal plane is seen from above") {
  const View view = choose_view(arc({1, 0, 0}, {0, 1, 0}), {0, 0, -9.81});
  check_right_handed(view);
  CHECK(same(view.look, {0, 0, -1}));
}

TEST_CASE("the widest horizontal spread of a spatial motion goes across the picture") {
  std::vector<Vec3> points;
  for (int k = 0; k < 50; ++k) points.push_back({std::sin(1.7 * k), 4 * std::cos(1.1 * k), 8 * std::sin(0.3 * k)});
  const View view = choose_view(points, {0, 0, -9.81});
  check_right_handed(view);
  CHECK(std::abs(view.right.z) < 1e-12);
  CHECK(view.right.y > 0.95);
  CHECK(view.up.z > 0.9);
  CHECK(view.look.z < -0.3);  // from above
}

TEST_CASE("a motion along a line, a point and no motion have a view, too") {
  check_right_handed(choose_view(std::vector<Vec3>{{0, 0, 0}, {0, 0, 1}}, {0, 0, -9.81}));
  check_right_handed(choose_view(std::vector<Vec3>{{1, 2, 3}}, {0, 0, 0}));
  check_right_handed(choose_view({}, {0, 0, 0}));
  const View line = choose_view(std::vector<Vec3>{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}, {0, 0, -9.81});
  CHECK(same(line.right, normalized(Vec3{1, 1, 0})));
}

TEST_CASE("directions are read from three numbers, and nothing else") {
  CHECK(same(parse_direction("1,-2.5,0"), {1, -2.5, 0}));
  for (const char* bad : {"", "1,2", "1,2,3,4", "1,2,x", "0,0,0", "nan,0,1", "1;2;3", "1,2,3 "}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(parse_direction(bad), Error);
  }
}

}  // namespace momentree::io
