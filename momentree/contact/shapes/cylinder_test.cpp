// Cylinders before boxes, hulls and capsules: gaps against distances by nested searches, and rates against differences.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/cylinder.hpp>
#include <momentree/contact/shapes/cylinder_overlap.hpp>
#include <momentree/contact/shapes/distance.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

struct Oracle {
  const Solid& can;
  Place of_can;

  // Of a point, 0 inside.
  double from(const Vec3& world) const {
    const Vec3 p = transpose_times(of_can.R, world - of_can.r), along = can.ends[1] - can.ends[0], from = p - can.ends[0];
    const double length = norm(along), h = dot(from, along) / length;
    const double beyond = std::max({-h, h - length, 0.0});
    return std::hypot(beyond, std::max(norm(from - (h / length) * along) - can.rim, 0.0));
  }
  // The distance from a convex set is convex: golden sections.
  template <class F>
  static double least(const F& f) {
    constexpr double golden = 0.6180339887498949;
    double low = 0, high = 1, a = 1 - golden, b = golden, fa = f(a), fb = f(b);
    for (int k = 0; k < 60; ++k) {
      if (fa < fb)
        high = b, b = a, fb = fa, a = high - golden * (high - low), fa = f(a);
      else
        low = a, a = b, fa = fb, b = low + golden * (high - low), fb = f(b);
    }
    return std::min({fa, fb, f(0.0), f(1.0)});
  }
  double segment(const Vec3& a, const Vec3& b) const {
    return least([&](double s) { return from(a + s * (b - a)); });
  }
  // The points of its faces that are nearest, or of its axis.
  double distance(const Solid& other, const Place& place) const {
    const auto world = [&](int i) { return place.r + place.R * other.vertices[static_cast<std::size_t>(i)]; };
    if (other.faces.empty()) return segment(world(0), world(1)) - other.radius;
    double best = HUGE_VAL;
    for (const Solid::Face& face : other.faces)
      for (std::size_t k = 2; k < face.corners.size(); ++k) {
        const Vec3 a = world(face.corners[0]), b = world(face.corners[k - 1]), c = world(face.corners[k]);
        best = std::min(best, least([&](double s) { return segment(a + s * (b - a), a + s * (c - a)); }));
        if (best == 0) return 0;
      }
    return best;
  }
};

Solid random_solid(Prng& random) {
  const Pose at(random.vector(0.3), random.rotation());
  switch (random.integer(0, 2)) {
    case 0: {
      const double radius = random.uniform(0.05, 0.4);
      return capsule(radius, random.uniform(0.2, 1), at);
    }
    case 1: {
      const double x = random.uniform(0.2, 1);
      const double y = random.uniform(0.2, 1);
      const double z = random.uniform(0.2, 1);
      return box({x, y, z}, at);
    }
    default: {
      std::vector<Vec3> points;
      for (int i = random.integer(4, 10); i > 0; --i) points.push_back(random.vector(0.6));
      return hull(points);
    }
  }
}
Solid random_cylinder(Prng& random) {
  const double radius = random.uniform(0.1, 0.6);
  const double length = random.uniform(0.05, 1.2);
  return cylinder(radius, length, Pose(random.vector(0.3), random.rotation()));
}
Place random_place(Prng& random, double size) {
  Place place;
  place.R = rotation_matrix(random.rotation()), place.r = random.vector(size);
  place.v = random.vector(1), place.w = random.vector(1);
  return place;
}
double least_gap(const Solid& one, const Place& a, const Solid& other, const Place& b, std::vector<Candidate>& found) {
  found.clear();
  face_each_other(one, a, other, b, 3, found);
  double least = HUGE_VAL;
  for (const Candidate& c : found) least = std::min(least, c.gap);
  return least;
}

}  // namespace

TEST_CASE("cylinders: features touch where the solids do, and no earlier") {
  Prng random(31);
  int touched = 0, missed = 0;
  int kinds[8] = {};
  for (int k = 0; k < 1500; ++k) {
    const Solid can = random_cylinder(random), other = random_solid(random);
    const Place a = random_place(random, 0.3);
    Place b = random_place(random, 0.3);
    Vec3 way = random.direction();
    const Vec3 start = a.r + a.R * can.centre - b.R * other.centre + 3.0 * way + random.vector(0.5);
    const bool second = random.chance(0.5);
    std::vector<Candidate> found;
    const auto gap = [&](double t) {
      b.r = start - t * way;
      return second ? least_gap(other, b, can, a, found) : least_gap(can, a, other, b, found);
    };
    double low = 0, high = 0;
    while (high < 6 && gap(high) > 0) low = high, high += 0.01;
    const Oracle oracle{can, a};
    if (!(high < 6)) {
      ++missed;
      for (const double t : {2.5, 3.0, 3.5}) {
        b.r = start - t * way;
        CHECK(oracle.distance(other, b) > 0);
      }
      continue;
    }
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (gap(middle) > 0 ? low : high) = middle;
    }
    CAPTURE(k);
    const double at = gap(high);
    ++touched;
    CHECK(std::fabs(at) < 1e-12);
    for (const Candidate& c : found)
      if (c.gap == at) ++kinds[static_cast<int>(c.features.pair)];
    const double distance = oracle.distance(other, b);
    CHECK(std::fabs(distance) < 1e-11);
    const double before = gap(high - 1e-6), exact = oracle.distance(other, b);
    CHECK(exact > 0);
    CHECK(std::fabs(before - exact) < 1e-9);
  }
  CHECK(touched > 1000);
  CHECK(missed > 20);
  for (const FeaturePair pair : {FeaturePair::point_plane, FeaturePair::point_line, FeaturePair::line_line,
                                 FeaturePair::circle_plane, FeaturePair::point_circle, FeaturePair::circle_line})
    CHECK(kinds[static_cast<int>(pair)] > 30);
}

TEST_CASE("cylinders: no gap is below the distance, which is exact") {
  Prng random(32);
  int apart = 0, rounded = 0, overlapping = 0;
  for (int k = 0; k < 3000; ++k) {
    const Solid can = random_cylinder(random), other = random_solid(random);
    const Place a = random_place(random, 0.8), b = random_place(random, 0.8);
    std::vector<Candidate> found;
    const double least = least_gap(can, a, other, b, found), distance = Oracle{can, a}.distance(other, b);
    CAPTURE(k);
    const NearestPoints near = momentree::contact::distance(can, a, other, b),
                        turned = momentree::contact::distance(other, b, can, a);
    CHECK(near.distance == turned.distance);
    if (!(distance > 0)) {
      // Of overlapping solids that are sharp nothing is known but that.
      CHECK((near.distance > -1e-12) == (other.radius == 0));
      CHECK(near.distance < 1e-12);
      ++overlapping;
      continue;
    }
    CHECK(std::fabs(near.distance - distance) < 1e-11);
    CHECK(std::fabs(norm(near.on_one - near.on_other) - distance) < 1e-10);
    CHECK(norm(near.on_one - near.on_other - near.distance * near.normal) < 1e-10);
    CHECK(norm(turned.on_one - near.on_other) + norm(turned.normal + near.normal) < 1e-12);
    ++apart;
    CHECK(least > distance - 1e-10);
    if (other.radius > 0) {
      ++rounded;
      CHECK(least < distance + 1e-10);
    }
    for (const Candidate& c : found) CHECK(touch(c.features, c.swapped ? b : a, c.swapped ? a : b).gap == c.gap);
  }
  CHECK(apart > 1000);
  CHECK(rounded > 300);
  CHECK(overlapping > 100);
}

TEST_CASE("cylinders: a capsule that pierces a disc is as deep as the way out at its nearer end") {
  const Solid disc = cylinder(1, 0.05), pin = capsule(0.02, 0.4);
  for (const double shift : {-0.05, 0.02, 0.1}) {
    for (const bool second : {false, true}) {
      std::vector<Candidate> found;
      cylinder_overlap_points(disc, Place{}, pin, Place{.r = {0.1, 0, shift}}, second, 0, found);
      REQUIRE(found.size() == 1);
      CHECK(found[0].gap == doctest::Approx(std::fabs(shift) - 0.2 - 0.02 - 0.025).epsilon(1e-12));
    }
  }
}
