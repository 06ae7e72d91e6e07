#include <momentree/export/picture/outline.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/math/vec.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

struct Surface {
  std::vector<Vec3> points;
  Triangles triangles;
};

// A torus about z, closed and facing outwards; of `open`, a part is cut out.
Surface torus(std::uint32_t around, std::uint32_t across, bool open) {
  Surface all;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t k = 0; k < across; ++k) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * k / across, r = 1 + 0.4 * std::cos(v);
      all.points.push_back({r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)});
      const std::uint32_t a = i * across + k, b = (i + 1) % around * across + k, c = (i + 1) % around * across + (k + 1) % across,
                          d = i * across + (k + 1) % across;
      if (open && i < 3) continue;
      all.triangles.push_back({a, b, c}), all.triangles.push_back({a, c, d});
    }
  return all;
}

double cross_of(const Point2& a, const Point2& b, const Point2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

bool covered(const std::vector<Point2>& points, const Triangles& triangles, const Point2& p) {
  return std::any_of(triangles.begin(), triangles.end(), [&](const auto& t) {
    const double a = cross_of(points[t[0]], points[t[1]], p), b = cross_of(points[t[1]], points[t[2]], p),
                 c = cross_of(points[t[2]], points[t[0]], p);
    return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
  });
}

int winding(const std::vector<std::vector<Point2>>& loops, const Point2& p) {
  int turns = 0;
  for (const std::vector<Point2>& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Point2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
      if (a.y <= p.y && b.y > p.y && cross_of(a, b, p) > 0) ++turns;
      if (a.y > p.y && b.y <= p.y && cross_of(a, b, p) < 0) --turns;
    }
  return turns;
}

}  // namespace

TEST_CASE("outline: it winds around what the triangles cover, with few points") {
  oracle::Prng random(6);
  for (int k = 0; k < 30; ++k) {
    Surface surface;
    if (k % 3 < 2) {
      surface = torus(24, 12, k % 3 == 1);
    } else {  // triangles that have nothing in common
      for (int i = 0; i < 60; ++i) surface.points.push_back(random.vector(1));
      for (std::uint32_t i = 0; i < 60; i += 3) surface.triangles.push_back({i, i + 1, i + 2});
    }
    const Mat3 R = rotation_matrix(random.rotation());
    std::vector<Point2> flat;
    for (const Vec3& p : surface.points) {
      const Vec3 turned = R * p;
      flat.push_back({turned.x, -turned.y});
    }
    const std::vector<std::vector<Point2>> loops = outline_of(flat, surface.triangles);
    int inside = 0;
    for (int i = 0; i < 400; ++i) {
      const Point2 p{random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5)};
      const bool is_covered = covered(flat, surface.triangles, p);
      CHECK((winding(loops, p) != 0) == is_covered);
      inside += is_covered ? 1 : 0;
    }
    CHECK(inside > 20);
    std::size_t corners = 0;
    for (const std::vector<Point2>& loop : loops) corners += loop.size();
    if (k % 3 == 0) CHECK(corners < surface.triangles.size() / 2);
  }
}

TEST_CASE("outline: nothing is left of triangles that are seen edge on") {
  const std::vector<Point2> points{{0, 0}, {1, 1}, {2, 2}};
  const Triangles triangles{{0, 1, 2}};
  CHECK(outline_of(points, triangles).empty());
}
