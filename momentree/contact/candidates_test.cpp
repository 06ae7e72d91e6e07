// Features of solids that face each other, against distances by brute force.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/candidates.hpp>
#include <momentree/contact/shapes/distance.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

using Triangle = std::array<Vec3, 3>;

// The surface of the core of a solid, in the world.
std::vector<Triangle> surface(const Solid& solid, const Place& place) {
  const auto world = [&](int i) { return place.r + place.R * solid.vertices[static_cast<std::size_t>(i)]; };
  if (solid.vertices.size() <= 2) return {{world(0), world(0), world(static_cast<int>(solid.vertices.size()) - 1)}};
  std::vector<Triangle> all;
  for (const Solid::Face& face : solid.faces)
    for (std::size_t k = 2; k < face.corners.size(); ++k)
      all.push_back({world(face.corners[0]), world(face.corners[k - 1]), world(face.corners[k])});
  return all;
}

double to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double square = dot(b - a, b - a), t = square > 0 ? std::clamp(dot(p - a, b - a) / square, 0.0, 1.0) : 0;
  return norm(p - (a + t * (b - a)));
}
double segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  double best = std::min({to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)});
  const Vec3 n = cross(b - a, d - c);
  const double square = dot(n, n);
  if (!(square > 1e-18)) return best;
  const double s = dot(cross(c - a, d - c), n) / square, t = dot(cross(c - a, b - a), n) / square;
  if (s >= 0 && s <= 1 && t >= 0 && t <= 1) best = std::min(best, std::fabs(dot(c - a, n)) / std::sqrt(square));
  return best;
}
double to_triangle(const Vec3& p, const Triangle& t) {
  double best = std::min({to_segment(p, t[0], t[1]), to_segment(p, t[1], t[2]), to_segment(p, t[2], t[0])});
  const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
  if (!(norm(n) > 1e-14)) return best;
  bool inside = true;
  for (std::size_t k = 0; k < 3; ++k) inside = inside && dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), n) >= 0;
  return inside ? std::min(best, std::fabs(dot(p - t[0], n)) / norm(n)) : best;
}
double distance(const std::vector<Triangle>& one, const std::vector<Triangle>& other) {
  double best = HUGE_VAL;
  for (const Triangle& a : one)
    for (const Triangle& b : other)
      for (std::size_t i = 0; i < 3; ++i) {
        best = std::min({best, to_triangle(a[i], b), to_triangle(b[i], a)});
        for (std::size_t k = 0; k < 3; ++k) best = std::min(best, segments(a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3]));
      }
  return best;
}

Solid random_solid(Prng& random) {
  const Pose at(random.vector(0.3), random.rotation());
  switch (random.integer(0, 3)) {
    case 0: return sphere(random.uniform(0.05, 0.5), at);
    case 1: return capsule(random.uniform(0.05, 0.4), random.uniform(0.2, 1), at);
    case 2: {
      const double x = random.uniform(0.2, 1);
      const double y = random.uniform(0.2, 1);
      const double z = random.uniform(0.2, 1);
      return box({x, y, z}, at);
    }
    default: {
      std::vector<Vec3> points;
      for (int i = random.integer(4, 14); i > 0; --i) points.push_back(random.vector(0.6));
      return hull(points);
    }
  }
}

struct Distance {
  double value, rate;
};
Distance distance_of(const Solid& one, const Place& a, const Solid& other, const Place& b) {
  const NearestPoints p = momentree::contact::distance(one, a, other, b);
  if (!(p.distance > 0)) return {0, 0};
  const auto v = [](const Place& of, const Vec3& x) { return of.v + cross(of.w, x - of.r); };
  return {p.distance, dot(p.normal, v(a, p.on_one) - v(b, p.on_other))};
}
// A place after t seconds.
Place moved(Place p, double t) {
  const double angle = norm(p.w) * t;
  const Vec3 axis = std::sin(0.5 * angle) * normalized(p.w);
  p.R = rotation_matrix(Quat{std::cos(0.5 * angle), axis.x, axis.y, axis.z}) * p.R, p.r += t * p.v;
  return p;
}

}  // namespace

TEST_CASE("distance: of all pairs of shapes over random poses, and its rate") {
  Prng random(11);
  const auto solid = [&](int kind) -> Solid {
    const Pose at(random.vector(0.3), random.rotation());
    const double radius = random.uniform(0.1, 0.4);
    if (kind == 4) return cylinder(radius, 0.7, at);
    Solid any = random_solid(random);
    const auto kind_of = [](const Solid& s) {
      return s.vertices.size() == 1 ? 0 : s.vertices.size() == 2 ? 1 : s.edges.size() == 12 && s.faces.size() == 6 ? 2 : 3;
    };
    while (kind_of(any) != kind) any = random_solid(random);
    return any;
  };
  int apart = 0, overlapping = 0;
  for (int k = 0; k < 3000; ++k) {
    const int kind = random.integer(0, 4), other_kind = random.integer(0, 4);
    const Solid one = solid(kind), other = solid(other_kind);
    Place a, b;
    a.R = rotation_matrix(random.rotation()), b.R = rotation_matrix(random.rotation());
    a.r = random.vector(random.chance(0.1) ? 20 : 2), b.r = random.vector(2);
    a.v = random.vector(1), a.w = random.vector(1), b.v = random.vector(1), b.w = random.vector(1);
    const Distance found = distance_of(one, a, other, b), turned = distance_of(other, b, one, a);
    CHECK(std::fabs(found.value - turned.value) < 1e-12 * std::max(1.0, found.value));
    const bool round = kind == 4 || other_kind == 4;  // not a polyhedron: see cylinder_test
    const double exact = round ? found.value : distance(surface(one, a), surface(other, b)) - one.radius - other.radius;
    CAPTURE(kind);
    CAPTURE(other_kind);
    if (found.value == 0) {  // brute force knows only surfaces: of cores that overlap, nothing
      ++overlapping;
      CHECK(found.rate == 0);
      continue;
    }
    ++apart;
    CHECK(std::fabs(found.value - exact) < 2e-12 * std::max(1.0, exact));
    constexpr double h = 1e-6;
    const double later = distance_of(one, moved(a, h), other, moved(b, h)).value;
    const double earlier = distance_of(one, moved(a, -h), other, moved(b, -h)).value;
    if (later > 0 && earlier > 0) CHECK(std::fabs((later - earlier) / (2 * h) - found.rate) < 1e-4);
  }
  CHECK(apart > 2000);
  CHECK(overlapping > 50);
}

TEST_CASE("solids: sizes of hulls and boxes") {
  const Solid cube = box({1, 1, 1});
  CHECK(cube.vertices.size() == 8);
  CHECK(cube.edges.size() == 12);
  CHECK(cube.faces.size() == 6);
  CHECK(cube.thickness == 1);
  std::vector<Vec3> points = cube.vertices;
  for (int i = 0; i < 8; ++i) points.push_back({0.1 * i - 0.3, 0.2, 0.1});  // inside
  const Solid same = hull(points);
  CHECK(same.vertices.size() == 8);
  CHECK(same.edges.size() == 12);
  CHECK(same.faces.size() == 12);
  CHECK(hull(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).vertices.empty());
  for (const Solid::Face& face : same.faces)
    for (const Vec3& v : same.vertices) CHECK(dot(face.normal, v) <= face.offset + 1e-12);
}

TEST_CASE("solids: hulls contain their points, and their corners are points") {
  Prng random(4);
  for (int k = 0; k < 300; ++k) {
    std::vector<Vec3> points;
    for (int i = random.integer(4, 60); i > 0; --i) points.push_back(random.chance(0.3) ? random.direction() : random.vector(1));
    const Solid solid = hull(points);
    REQUIRE(!solid.vertices.empty());
    for (const Solid::Face& face : solid.faces)
      for (const Vec3& p : points) CHECK(dot(face.normal, p) <= face.offset + 1e-10);
    CHECK(solid.vertices.size() - solid.edges.size() + solid.faces.size() == 2);  // Euler, without faces of one plane
  }
}

TEST_CASE("solids: the least gap of features is the distance") {
  Prng random(5);
  int compared = 0, sharp = 0;
  for (int k = 0; k < 4000; ++k) {
    const Solid one = random_solid(random), other = random_solid(random);
    Place a, b;
    a.R = rotation_matrix(random.rotation()), b.R = rotation_matrix(random.rotation());
    a.r = random.vector(1), b.r = random.vector(1);
    const double core = distance(surface(one, a), surface(other, b)), rounding = one.radius + other.radius;
    // Cores that overlap have crossing edges or a vertex inside: the distance of surfaces does not tell.
    std::vector<Candidate> found;
    face_each_other(one, a, other, b, 5, found);
    double least = HUGE_VAL;
    for (const Candidate& c : found) {
      least = std::min(least, c.gap);
      const Place &pa = c.swapped ? b : a, &pb = c.swapped ? a : b;
      CHECK(touch(c.features, pa, pb).gap == c.gap);
    }
    if (least < -rounding - 1e-9) continue;  // overlap
    if (rounding > 0) {
      ++compared;
      CHECK(std::fabs(least - (core - rounding)) < 1e-9);
    } else if (std::isfinite(least)) {
      ++sharp;
      CHECK(least > core - 1e-9);
    }
  }
  CHECK(compared > 2000);
  CHECK(sharp > 100);
}

TEST_CASE("solids: boxes of one size, one on the other, touch at all corners of both") {
  Place a, b;
  a.r = {0, 0, 1};
  std::vector<Candidate> found;
  face_each_other(box({1, 1, 1}), a, box({1, 1, 1}), b, 0.1, found);
  CHECK(found.size() == 8);
  for (const Candidate& c : found) CHECK(c.gap == 0);
}

TEST_CASE("solids: capsules side by side touch at both ends of what they share") {
  Place a, b;
  a.r = {0.5, 0, 0.2};
  std::vector<Candidate> found;
  face_each_other(capsule(0.25, 1), a, capsule(0.25, 1), b, 0.1, found);
  CHECK(std::count_if(found.begin(), found.end(), [](const Candidate& c) { return std::fabs(c.gap) < 1e-15; }) == 2);
}

TEST_CASE("solids: every vertex faces a plane") {
  Place a, b;
  a.r = {0, 0, 0.5};
  std::vector<Candidate> found;
  face_plane(box({1, 1, 1}), a, {}, {0, 0, 1}, b, 0.1, found);
  CHECK(found.size() == 4);
  found.clear();
  face_plane(sphere(0.5), a, {}, {0, 0, 1}, b, 0.1, found);
  REQUIRE(found.size() == 1);
  CHECK(found[0].gap == 0);
}

TEST_CASE("solids: hulls of points on a grid, given twice, and in any order") {
  Prng random(6);
  for (int k = 0; k < 60; ++k) {
    const int n = random.integer(1, 4);
    std::vector<Vec3> points;
    for (int x = 0; x <= n; ++x)
      for (int y = 0; y <= n; ++y)
        for (int z = 0; z <= n; ++z) points.insert(points.end(), 2, Vec3{double(x), double(y), double(z)});
    for (std::size_t i = points.size() - 1; i > 0; --i) {
      const int j = random.integer(0, static_cast<int>(i));
      std::swap(points[i], points[static_cast<std::size_t>(j)]);
    }
    const Mat3 R = rotation_matrix(random.rotation());
    for (Vec3& p : points) p = R * p;
    const Solid solid = hull(points);
    CHECK(volume(solid) == doctest::Approx(n * n * n));
    for (const Solid::Face& face : solid.faces)
      for (const Vec3& p : points) CHECK(dot(face.normal, p) <= face.offset + 1e-11);
  }
}

TEST_CASE("solids: hulls reach as far as their points in every direction") {
  Prng random(9);
  for (int k = 0; k < 100; ++k) {
    std::vector<Vec3> points;
    for (int i = random.integer(4, 2000); i > 0; --i)
      points.push_back(random.chance(0.5) ? random.direction() : random.vector(1));
    const Solid whole = hull(points);
    double beyond = 0;
    const Solid part = hull_within(points, 20, 1e-6, beyond);
    CHECK(part.vertices.size() <= 20);
    for (int i = 0; i < 50; ++i) {
      const Vec3 n = random.direction();
      const auto reach = [&](const std::vector<Vec3>& of) {
        double most = -HUGE_VAL;
        for (const Vec3& p : of) most = std::max(most, dot(n, p));
        return most;
      };
      CHECK(std::fabs(reach(whole.vertices) - reach(points)) < 1e-12);
    }
    for (const Solid::Face& face : part.faces)
      for (const Vec3& p : points) CHECK(dot(face.normal, p) <= face.offset + beyond + 3e-6);
  }
}

TEST_CASE("solids: a cylinder stands on eight points, lies on two and touches with one") {
  const Solid can = cylinder(0.5, 2);
  std::vector<Candidate> found;
  Place a, b;
  a.r = {0, 0, 1};
  face_plane(can, a, {}, {0, 0, 1}, b, 0.1, found);
  CHECK(found.size() == 8);
  for (const Candidate& c : found) CHECK(std::fabs(c.gap) < 1e-15);
  found.clear();
  a.r.z = 0.5, a.R = rotation_matrix(from_axis_angle({1, 0, 0}, std::acos(0.0)));
  face_plane(can, a, {}, {0, 0, 1}, b, 0.1, found);
  CHECK(found.size() == 2);
  for (const Candidate& c : found) CHECK(std::fabs(c.gap) < 1e-15);
  found.clear();
  a.R = rotation_matrix(from_axis_angle({1, 0, 0}, 0.5)), a.r.z = std::cos(0.5) + 0.5 * std::sin(0.5);
  face_plane(can, a, {}, {0, 0, 1}, b, 0.1, found);
  REQUIRE(found.size() == 1);
  CHECK(std::fabs(found[0].gap) < 1e-15);
  CHECK(std::fabs(volume(can) / (3.14159265358979323846 * 0.5) - 1) < 0.01);
}

TEST_CASE("solids: the distance of a ball from a cylinder is that of a point from a rectangle") {
  Prng random(10);
  for (int k = 0; k < 3000; ++k) {
    const double radius = random.uniform(0.1, 1);
    const double length = random.uniform(0.1, 2);
    const double r = random.uniform(0.01, 0.5);
    const Pose at(random.vector(0.5), random.rotation());
    Place a, b;
    a.R = rotation_matrix(random.rotation()), b.R = rotation_matrix(random.rotation());
    a.r = random.vector(2), b.r = random.vector(0.5);
    const Vec3 centre = random.vector(0.2);
    const Vec3 p = rotation_matrix(conjugate(at.rotation)) * (transpose_times(b.R, a.r + a.R * centre - b.r) - at.position);
    const double aside = std::hypot(p.x, p.y) - radius, above = std::fabs(p.z) - length / 2;
    if (aside < 0 && above < 0) continue;
    const double expected = std::hypot(std::max(aside, 0.0), std::max(above, 0.0)) - r;
    for (const bool swapped : {false, true}) {
      const Solid ball = sphere(r, Pose(centre)), can = cylinder(radius, length, at);
      std::vector<Candidate> found;
      if (swapped)
        face_each_other(can, b, ball, a, 9, found);
      else
        face_each_other(ball, a, can, b, 9, found);
      REQUIRE(found.size() == 1);
      CHECK(found[0].swapped == swapped);
      CHECK(std::fabs(found[0].gap - expected) < 1e-14);
    }
  }
}
