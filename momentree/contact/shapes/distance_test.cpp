// Distances of solids against closed forms, and against what makes them distances.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/distance.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

Place somewhere(Prng& random, double size) {
  Place place;
  place.r = random.vector(size);
  place.R = rotation_matrix(random.rotation());
  place.v = random.vector(1);
  place.w = random.vector(1);
  return place;
}

// Of a point from a box around the origin.
double from_box(const Vec3& p, const Vec3& size) {
  const double x = std::max(std::fabs(p.x) - 0.5 * size.x, 0.0), y = std::max(std::fabs(p.y) - 0.5 * size.y, 0.0),
               z = std::max(std::fabs(p.z) - 0.5 * size.z, 0.0);
  return std::sqrt(x * x + y * y + z * z);
}

double between_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // By the best of the ends, and of the common perpendicular.
  const auto to_segment = [](const Vec3& p, const Vec3& from, const Vec3& to) {
    const Vec3 along = to - from;
    const double t = std::clamp(dot(p - from, along) / dot(along, along), 0.0, 1.0);
    return norm(p - from - t * along);
  };
  double least = std::min({to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)});
  const Vec3 u = b - a, v = d - c, w = a - c, n = cross(u, v);
  if (dot(n, n) > 1e-12) {
    const double s = -dot(cross(v, n), w) / dot(n, n), t = -dot(cross(u, n), w) / dot(n, n);
    if (s > 0 && s < 1 && t > 0 && t < 1) least = std::min(least, std::fabs(dot(n, w)) / norm(n));
  }
  return least;
}

// How far a solid reaches in a direction.
double reach(const Vec3& n, const Solid& solid, const Place& place) {
  double most = -HUGE_VAL;
  if (solid.rim > 0) {
    const double tilt = norm(cross(n, place.R * normalized(solid.ends[1] - solid.ends[0])));
    for (const Vec3& end : solid.ends) most = std::max(most, dot(n, place.r + place.R * end) + solid.rim * tilt);
    return most;
  }
  for (const Vec3& v : solid.vertices) most = std::max(most, dot(n, place.r + place.R * v));
  return most + solid.radius;
}

}  // namespace

TEST_CASE("distance: spheres, capsules and boxes in closed form") {
  Prng random(1);
  double worst = 0;
  for (int k = 0; k < 20000; ++k) {
    const Place a = somewhere(random, 3), b = somewhere(random, 3);
    const NearestPoints spheres = distance(sphere(0.3), a, sphere(0.2), b);
    worst = std::max(worst, std::fabs(spheres.distance - (norm(a.r - b.r) - 0.5)));
    const Vec3 half{0, 0, 0.5};
    const NearestPoints capsules = distance(capsule(0.1, 1), a, capsule(0.2, 1), b);
    worst = std::max(worst, std::fabs(capsules.distance + 0.3 -
                                      between_segments(a.r - a.R * half, a.r + a.R * half, b.r - b.R * half, b.r + b.R * half)));
    const Vec3 size{0.6, 1, 1.4};
    const NearestPoints boxed = distance(sphere(0.2), a, box(size), b);
    const double outside = from_box(transpose_times(b.R, a.r - b.r), size);
    if (outside > 1e-9) worst = std::max(worst, std::fabs(boxed.distance - (outside - 0.2)));
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("distance: no points of two solids are nearer, and a plane separates them by the distance") {
  Prng random(2);
  int apart = 0;
  for (int k = 0; k < 20000; ++k) {
    const Solid one = k % 2 == 0 ? box({0.4, 0.8, 1.2}) : cylinder(0.3, 0.9),
                other = k % 3 == 0 ? capsule(0.1, 0.7) : box({1, 0.3, 0.5});
    const Place a = somewhere(random, 1.5), b = somewhere(random, 1.5);
    const NearestPoints found = distance(one, a, other, b);
    if (found.distance <= 1e-6) continue;
    ++apart;
    CHECK(norm(found.on_one - found.on_other) == doctest::Approx(found.distance).epsilon(1e-9));
    const double lowest = -reach(-found.normal, one, a), highest = reach(found.normal, other, b);
    CHECK(std::fabs(lowest - highest - found.distance) < 1e-11);
  }
  CHECK(apart > 5000);
}

TEST_CASE("distance: planes, also from a cylinder") {
  Prng random(3);
  for (int k = 0; k < 2000; ++k) {
    const Place a = somewhere(random, 2);
    const Vec3 n = random.direction(), point = random.vector(1), axis = a.R * Vec3{0, 0, 1};
    const double tilt = dot(n, axis), centre = dot(n, a.r - point);
    CHECK(std::fabs(distance_to_plane(capsule(0.1, 1), a, point, n).distance - (centre - 0.5 * std::fabs(tilt) - 0.1)) < 1e-14);
    CHECK(std::fabs(distance_to_plane(cylinder(0.3, 1), a, point, n).distance -
                    (centre - 0.5 * std::fabs(tilt) - 0.3 * std::sqrt(1 - tilt * tilt))) < 1e-13);
  }
}
