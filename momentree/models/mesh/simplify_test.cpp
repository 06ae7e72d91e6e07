#include <momentree/models/mesh/simplify.hpp>

#include <cmath>
#include <map>

#include <doctest/doctest.h>

#include <momentree/models/mesh/test_meshes.hpp>

namespace momentree::io {
namespace {

using namespace test;

/// A sphere of radius 1 as a grid of quadrilaterals, halved.
MeshPart sphere(std::uint32_t rings, std::uint32_t around) {
  MeshPart part;
  constexpr double pi = 3.14159265358979323846;
  part.points.push_back({0, 0, 1});
  for (std::uint32_t r = 1; r < rings; ++r)
    for (std::uint32_t a = 0; a < around; ++a) {
      const double polar = pi * r / rings, azimuth = 2 * pi * a / around;
      part.points.push_back({std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)});
    }
  part.points.push_back({0, 0, -1});
  const auto at = [&](std::uint32_t r, std::uint32_t a) {
    return r == 0 ? 0u : r == rings ? 1 + (rings - 1) * around : 1 + (r - 1) * around + a % around;
  };
  for (std::uint32_t r = 0; r < rings; ++r)
    for (std::uint32_t a = 0; a < around; ++a) {
      if (r > 0) part.triangles.push_back({at(r, a), at(r + 1, a), at(r, a + 1)});
      if (r + 1 < rings) part.triangles.push_back({at(r, a + 1), at(r + 1, a), at(r + 1, a + 1)});
    }
  return part;
}

double volume_of(const MeshPart& part) {
  double six = 0;
  for (const Corners& t : corners_of(part)) six += dot(t[0], cross(t[1], t[2]));
  return six / 6;
}

/// How many triangles there are at each edge, by its ends; with the sign of its direction in `sense`.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges_of(const MeshPart& part, int& sense) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges, directed;
  for (const auto& t : part.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      ++edges[{low, high}];
      directed[{low, high}] += t[k] == low ? 1 : -1;
    }
  sense = 0;
  for (const auto& [edge, sum] : directed) sense += std::abs(sum);
  return edges;
}

TEST_CASE("a simplified sphere stays a closed sphere") {
  for (const std::size_t most : {2000u, 500u, 100u}) {
    MeshPart part = sphere(40, 60);
    const double exact = volume_of(part);
    simplify(part, most);
    CAPTURE(most);
    CHECK(part.triangles.size() <= most);
    CHECK(part.triangles.size() >= most - 2);
    for (const Vec3& p : part.points) CHECK(norm(p) == doctest::Approx(1));  // points are removed, none is moved
    int sense = 0;
    for (const auto& [edge, count] : edges_of(part, sense)) CHECK(count == 2);
    CHECK(sense == 0);  // neighbours run through their edge in opposite directions: no triangle is turned over
    // An inscribed polyhedron with n equal triangles lacks about 4 π² ÷ (√3 · 3 n) · 3 of the volume.
    CHECK(volume_of(part) < exact);
    CHECK(volume_of(part) > exact * (1 - 16.0 / static_cast<double>(most)));
  }
}

TEST_CASE("flat surfaces lose triangles without losing area, also at their borders and holes") {
  MeshPart part;
  constexpr std::uint32_t n = 30;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) part.points.push_back({i / 30.0, j / 30.0, 0.25});
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      if (i >= 10 && i < 20 && j >= 10 && j < 20) continue;  // a square hole
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      part.triangles.push_back({a, b, a + 1});
      part.triangles.push_back({a + 1, b, b + 1});
    }
  simplify(part, 60);
  double area = 0;
  for (const Corners& t : corners_of(part)) area += 0.5 * cross(t[1] - t[0], t[2] - t[0]).z;
  CHECK(part.triangles.size() <= 60);
  CHECK(area == doctest::Approx(1 - 1.0 / 9).epsilon(1e-12));
}

TEST_CASE("any mesh gets as few triangles as asked for, with valid corners") {
  std::mt19937 random(5);
  for (int i = 0; i < 60; ++i) {
    MeshPart part = random_part(random, 3 + 20 * i, 40 * i + 1);  // entangled: edges of many triangles, triangles without area
    if (i % 3 == 0)
      for (auto& t : part.triangles) t[0] = 0;  // all at one point
    if (i % 2 == 0) merge_points(part, 65535);
    const std::size_t most = 56 + static_cast<std::size_t>(7 * i);
    simplify(part, most);
    CHECK(part.triangles.size() <= most);
    for (const auto& t : part.triangles)
      for (const std::uint32_t corner : t) CHECK(corner < part.points.size());
  }
}

TEST_CASE("merging joins points of one cell and removes what becomes nothing") {
  MeshPart part;
  part.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1e-9, 0}, {1, 1, 0}, {0, 1, 0}, {5, 5, 5}};
  part.triangles = {{0, 1, 2}, {3, 4, 5}, {1, 3, 4}, {2, 0, 1}, {6, 6, 6}};
  merge_points(part, 1000);
  CHECK(part.triangles.size() == 2);
  CHECK(part.points.size() == 4);
  double area = 0;
  for (const Corners& t : corners_of(part)) area += 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
  CHECK(area == doctest::Approx(1).epsilon(0.02));
}

}  // namespace
}  // namespace momentree::io
