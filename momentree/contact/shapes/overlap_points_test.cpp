// Points of polyhedra that overlap, by what they are for: a motion along their normal by their depth separates the solids, and no
// shorter motion along any face normal does.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/overlap_points.hpp>
#include <momentree/math/vec.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

Place random_place(Prng& random, double size) {
  Place place;
  place.r = random.vector(size);
  place.R = rotation_matrix(random.rotation());
  return place;
}

// The least overlap of two solids along a direction and its opposite (m).
double overlap_along(const Vec3& n, const Solid& one, const Place& a, const Solid& other, const Place& b) {
  const auto highest = [](const Vec3& along, const Solid& solid, const Place& place) {
    double most = -HUGE_VAL;
    if (solid.rim > 0) {
      const double tilt = norm(cross(along, place.R * normalized(solid.ends[1] - solid.ends[0])));
      for (const Vec3& end : solid.ends) most = std::max(most, dot(along, place.r + place.R * end) + solid.rim * tilt);
      return most;
    }
    for (const Vec3& v : solid.vertices) most = std::max(most, dot(along, place.r + place.R * v));
    return most;
  };
  return highest(n, other, b) + highest(-n, one, a) + one.radius + other.radius;
}

}  // namespace

TEST_CASE("overlap points: a motion by their depth separates the solids") {
  Prng random(5);
  OverlapPoints find;
  int overlaps = 0, edges = 0, round = 0, apart = 0;
  for (int k = 0; k < 20000; ++k) {
    const Solid one = k % 3 == 0 ? cylinder(0.3, 0.8) : box({0.4, 0.6, 1.0});
    const Solid other = box({0.8, 0.5, 0.7});
    const Place a = random_place(random, 0.9), b = random_place(random, 0.2);
    std::vector<Candidate> points;
    find.find(one, a, other, b, 0, points);
    double least = HUGE_VAL;
    for (const auto& [solid, place] : {std::pair{&one, &a}, {&other, &b}})
      for (const Solid::Face& face : solid->faces) {
        const Vec3 n = place->R * face.normal;
        if (solid->rim > 0 && norm(cross(face.normal, solid->ends[1] - solid->ends[0])) > 1e-9) continue;  // a side of a prism
        least = std::min(least, overlap_along(solid == &one ? -n : n, one, a, other, b));
      }
    if (points.empty()) {
      ++apart;
      continue;
    }
    CHECK(least > 0);
    ++overlaps;
    double depth = 0;
    Vec3 normal{};
    for (const Candidate& c : points) {
      const Touch touch = contact::touch(c.features, c.swapped ? b : a, c.swapped ? a : b);
      CHECK(touch.gap == doctest::Approx(c.gap));
      depth = std::max(depth, -touch.gap);
      normal = c.swapped ? -touch.normal : touch.normal;  // from the second solid to the first
    }
    CHECK(depth <= least * (1 + 2e-3));
    CHECK(overlap_along(normal, one, a, other, b) <= least * (1 + 2e-3) + 1e-12);
    if (k % 3 == 0)
      for (int i = 0; i < 200; ++i) CHECK(0.9 * depth <= overlap_along(random.direction(), one, a, other, b) * (1 + 2e-3));
    const FeaturePair pair = points.front().features.pair;
    if (pair == FeaturePair::point_plane || pair == FeaturePair::circle_plane || points.size() > 1) continue;
    ++(pair == FeaturePair::line_line ? edges : round);
    CHECK(depth == doctest::Approx(overlap_along(normal, one, a, other, b)).epsilon(1e-6));
  }
  CHECK(overlaps > 3000);
  CHECK(edges > 200);
  CHECK(round > 100);
  CHECK(apart > 3000);
}

TEST_CASE("overlap points: a box on another one has the corners of the common area, with normals across it") {
  const Solid one = box({0.4, 0.4, 0.2}), other = box({1, 1, 0.2});
  Place a;
  for (const double height : {0.1999, 0.2001}) {
    a.r = {0.4, 0, height};
    OverlapPoints find;
    std::vector<Candidate> points;
    find.find(one, a, other, {}, 1e-3, points);
    REQUIRE(points.size() == 4);
    for (const Candidate& c : points) {
      const Touch touch = contact::touch(c.features, c.swapped ? Place{} : a, c.swapped ? a : Place{});
      CHECK(std::fabs(touch.gap - (height - 0.2)) < 1e-15);
      CHECK(std::fabs(std::fabs(touch.normal.z) - 1) < 1e-15);
      CHECK((std::fabs(touch.point.x - 0.2) < 1e-12 || std::fabs(touch.point.x - 0.5) < 1e-12));
    }
    points.clear();
    find.find(one, a, other, {}, 0, points);
    CHECK(points.size() == (height < 0.2 ? 4u : 0u));
  }
}
