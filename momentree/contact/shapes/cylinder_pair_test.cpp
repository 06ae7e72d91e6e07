// Two cylinders: gaps against distances by nested searches, and rates against differences.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/circle.hpp>
#include <momentree/contact/shapes/cylinder_pair.hpp>
#include <momentree/contact/shapes/overlap_points.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

// A golden section of a convex function on an interval.
template <class F>
double least(double low, double high, const F& f) {
  constexpr double golden = 0.6180339887498949;
  double a = high - golden * (high - low), b = low + golden * (high - low), fa = f(a), fb = f(b);
  for (int k = 0; k < 60; ++k) {
    if (fa < fb)
      high = b, b = a, fb = fa, a = high - golden * (high - low), fa = f(a);
    else
      low = a, a = b, fa = fb, b = low + golden * (high - low), fb = f(b);
  }
  return std::min(fa, fb);
}

double from(const Solid& can, const Place& place, const Vec3& world) {
  const Vec3 p = transpose_times(place.R, world - place.r), along = can.ends[1] - can.ends[0], d = p - can.ends[0];
  const double length = norm(along), h = dot(d, along) / length;
  return std::hypot(std::max({-h, h - length, 0.0}), std::max(norm(d - (h / length) * along) - can.rim, 0.0));
}

// The distance from a convex set is convex on the discs of the other one, and along its axis.
double exact(const Solid& one, const Place& a, const Solid& other, const Place& b) {
  const Vec3 along = one.ends[1] - one.ends[0];
  Vec3 across[2];
  perpendiculars(normalized(along), across);
  return least(0, 1, [&](double h) {
    return least(-one.rim, one.rim, [&](double x) {
      const double half = std::sqrt(std::max(0.0, one.rim * one.rim - x * x));
      return least(-half, half, [&](double y) {
        return from(other, b, a.r + a.R * (one.ends[0] + h * along + x * across[0] + y * across[1]));
      });
    });
  });
}

Solid random_can(Prng& random) {
  const double radius = random.uniform(0.1, 0.6);
  return cylinder(radius, random.uniform(0.05, 1.2), Pose(random.vector(0.3), random.rotation()));
}
Place random_place(Prng& random, double size) {
  Place place;
  place.R = rotation_matrix(random.rotation()), place.r = random.vector(size);
  place.v = random.vector(1), place.w = random.vector(1);
  return place;
}
double reach(const Vec3& n, const Solid& can, const Place& place) {
  const double tilt = norm(cross(n, place.R * normalized(can.ends[1] - can.ends[0])));
  double most = -HUGE_VAL;
  for (const Vec3& end : can.ends) most = std::max(most, dot(n, place.r + place.R * end) + can.rim * tilt);
  return most;
}

}  // namespace

TEST_CASE("cylinder pairs: gaps of two rims, their points and normals move as their rates say") {
  Prng random(54);
  int tried = 0;
  for (int k = 0; k < 3000; ++k) {
    Features f{FeaturePair::circle_line, random.vector(0.4), random.direction(), random.vector(0.4), random.direction()};
    f.rim = random.uniform(0.3, 1), f.length = random.uniform(0.3, 1), f.side = random.chance(0.5) ? 1 : -1;
    const Place a = random_place(random, 0.3), b = random_place(random, 0.3);
    const auto moved = [](Place p, double t) {
      const double angle = norm(p.w) * t;
      const Vec3 axis = std::sin(0.5 * angle) * normalized(p.w);
      p.R = rotation_matrix(Quat{std::cos(0.5 * angle), axis.x, axis.y, axis.z}) * p.R, p.r += t * p.v;
      return p;
    };
    const auto at = [&](double t) { return touch(f, moved(a, t), moved(b, t)); };
    const Touch now = at(0);
    constexpr double h = 1e-4;
    const auto smooth = [&](double t) {
      const Place pa = moved(a, t), pb = moved(b, t);
      return norm(cross(pa.R * f.line_a, pb.R * f.line_b)) > 0.5 && std::fabs(now.gap) < 0.1 &&
             nearest_of_circles(pa.r + pa.R * f.point_a - pb.r - pb.R * f.point_b, pa.R * f.line_a, f.rim, pb.R * f.line_b,
                                f.length, f.side)
                 .found;
    };
    if (!(smooth(-2 * h) && smooth(0) && smooth(2 * h)) || norm(now.point_rate) > 20 || norm(now.normal_rate) > 20) continue;
    ++tried;
    const auto difference = [&](const auto& of) {
      return (2.0 / (3 * h)) * (of(at(h)) - of(at(-h))) - (1.0 / (12 * h)) * (of(at(2 * h)) - of(at(-2 * h)));
    };
    CAPTURE(k);
    CHECK(norm(difference([](const Touch& t) { return t.point; }) - now.point_rate) < 1e-6 * (1 + norm(now.point_rate)));
    CHECK(norm(difference([](const Touch& t) { return t.normal; }) - now.normal_rate) < 1e-6 * (1 + norm(now.normal_rate)));
    const double rate = difference([](const Touch& t) { return t.gap; });
    CHECK(std::fabs(dot(now.normal, relative_velocity(now, a, b)) - rate) < 1e-8 * (1 + std::fabs(rate)));
  }
  CHECK(tried > 100);
}

TEST_CASE("cylinder pairs: features touch where the cylinders do, and no earlier") {
  Prng random(51);
  int touched = 0, missed = 0, kinds[8] = {}, rims = 0;
  for (int k = 0; k < 3000; ++k) {
    const Solid one = random_can(random), other = random_can(random);
    const Place a = random_place(random, 0.3);
    Place b = random_place(random, 0.3);
    const Vec3 way = random.direction();
    const Vec3 start = a.r + a.R * one.centre - b.R * other.centre + 3.0 * way + random.vector(0.5);
    std::vector<Candidate> found;
    const auto gap = [&](double t) {
      b.r = start - t * way;
      found.clear();
      cylinders_face(one, a, other, b, 0.5 * std::min(one.thickness, other.thickness), found);
      double smallest = HUGE_VAL;
      for (const Candidate& c : found) smallest = std::min(smallest, c.gap);
      return smallest;
    };
    double low = 0, high = 0;
    while (high < 6 && gap(high) > 0) low = high, high += 0.01;
    if (!(high < 6)) {
      ++missed;
      continue;
    }
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (gap(middle) > 0 ? low : high) = middle;
    }
    CAPTURE(k);
    ++touched;
    const double at = gap(high);
    CHECK(std::fabs(at) < 1e-12);
    for (const Candidate& c : found)
      if (c.gap == at) ++kinds[static_cast<int>(c.features.pair)], rims += c.features.length > 0 ? 1 : 0;
    // A plane through the point of contact separates them.
    double apart = -HUGE_VAL;
    for (const Candidate& c : found) {
      const Touch t = touch(c.features, c.swapped ? b : a, c.swapped ? a : b);
      const Vec3 n = c.swapped ? -t.normal : t.normal;
      apart = std::max(apart, -reach(-n, one, a) - reach(n, other, b));
    }
    CHECK(std::fabs(apart) < 1e-11);
  }
  CHECK(touched > 1000);
  CHECK(missed > 50);
  for (const FeaturePair pair : {FeaturePair::line_line, FeaturePair::circle_plane, FeaturePair::circle_line})
    CHECK(kinds[static_cast<int>(pair)] > 100);
  CHECK(rims > 100);
}

TEST_CASE("cylinder pairs: distances are exact") {
  Prng random(52);
  int apart = 0;
  for (int k = 0; k < 60; ++k) {
    const Solid one = random_can(random), other = random_can(random);
    const Place a = random_place(random, 0.9), b = random_place(random, 0.9);
    const double expected = exact(one, a, other, b);
    const NearestPoints found = cylinders_distance(one, a, other, b);
    CAPTURE(k);
    if (expected > 1e-7) ++apart;
    CHECK(std::fabs(found.distance - (expected > 1e-7 ? expected : 0.0)) < 1e-7);
  }
  CHECK(apart > 20);
}

TEST_CASE("cylinder pairs: planes separate them by their distance") {
  Prng random(53);
  int apart = 0;
  for (int k = 0; k < 20000; ++k) {
    const Solid one = random_can(random), other = random_can(random);
    const Place a = random_place(random, 1.2), b = random_place(random, 1.2);
    const NearestPoints found = cylinders_distance(one, a, other, b);
    CAPTURE(k);
    double sampled = -HUGE_VAL;
    if (!(found.distance > 0)) {
      for (int i = 0; i < 100; ++i) {
        const Vec3 n = random.direction();
        sampled = std::max(sampled, -reach(-n, one, a) - reach(n, other, b));
      }
      CHECK(sampled <= 0);
      continue;
    }
    ++apart;
    CHECK(std::fabs(-reach(-found.normal, one, a) - reach(found.normal, other, b) - found.distance) < 1e-10);
    CHECK(norm(found.on_one - found.on_other - found.distance * found.normal) < 1e-10);
    CHECK(from(one, a, found.on_one) + from(other, b, found.on_other) < 1e-10);
  }
  CHECK(apart > 5000);
}

TEST_CASE("cylinder pairs: a motion by the depth of their points separates them, and none is much shorter") {
  Prng random(55);
  OverlapPoints find;
  int overlaps = 0, single = 0;
  for (int k = 0; k < 4000; ++k) {
    const Solid one = random_can(random), other = random_can(random);
    const Place a = random_place(random, 0.7), b = random_place(random, 0.3);
    std::vector<Candidate> points;
    find.find(one, a, other, b, 0, points);
    if (points.empty()) continue;
    ++overlaps;
    double depth = 0;
    Vec3 normal{};
    for (const Candidate& c : points) {
      const Touch t = touch(c.features, c.swapped ? b : a, c.swapped ? a : b);
      CHECK(t.gap == doctest::Approx(c.gap));
      depth = std::max(depth, -t.gap), normal = c.swapped ? -t.normal : t.normal;
    }
    const auto overlap = [&](const Vec3& n) { return reach(n, other, b) + reach(-n, one, a); };
    CAPTURE(k);
    if (depth > 0.2 * std::min(one.thickness, other.thickness)) continue;
    for (int i = 0; i < 200; ++i) CHECK(0.9 * depth <= overlap(random.direction()) * (1 + 2e-3));
    const FeaturePair pair = points.front().features.pair;
    if (points.size() > 1 || pair == FeaturePair::circle_plane || pair == FeaturePair::point_plane) continue;
    ++single;
    CHECK(depth == doctest::Approx(overlap(normal)).epsilon(1e-6));
  }
  CHECK(overlaps > 500);
  CHECK(single > 100);
}

TEST_CASE("cylinder pairs: one stands on another one, lies on it and beside it") {
  const Solid can = cylinder(0.5, 2);
  Place a, b;
  std::vector<Candidate> found;
  const auto touching = [&] {
    found.clear();
    cylinders_face(can, a, can, b, 0.1, found);
    return std::count_if(found.begin(), found.end(), [](const Candidate& c) { return std::fabs(c.gap) < 1e-13; });
  };
  a.r = {0.3, 0.1, 2};
  CHECK(touching() >= 6);  // points of both rims, and two where they cross
  for (const Candidate& c : found)
    CHECK(std::fabs(std::fabs(touch(c.features, c.swapped ? b : a, c.swapped ? a : b).normal.z) - 1) < 1e-15);
  a.r = {0, 0, 2};
  CHECK(touching() == 16);
  a.r = {1, 0, 0.4};  // side by side
  CHECK(touching() == 2);
  a.r = {0, 0, 1.5}, a.R = rotation_matrix(from_axis_angle({1, 0, 0}, std::acos(0.0)));  // lying on an end
  CHECK(touching() == 2);
}
