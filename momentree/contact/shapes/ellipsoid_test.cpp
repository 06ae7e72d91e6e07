// Ellipsoids: gaps against separating planes that are searched for, how points and normals move against differences, and motions
// in closed form.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/candidates.hpp>
#include <momentree/contact/shapes/distance.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

// How far a solid extends along n from the origin of its body, in its frame.
double extent(const Solid& solid, const Vec3& n) {
  if (solid.is_smooth())
    return dot(n, solid.centre) + norm(Vec3{dot(solid.axes[0], n), dot(solid.axes[1], n), dot(solid.axes[2], n)});
  double most = -HUGE_VAL;
  if (solid.rim > 0) {
    const Vec3 axis = normalized(solid.ends[1] - solid.ends[0]);
    for (const Vec3& end : solid.ends) most = std::max(most, dot(n, end) + solid.rim * norm(cross(axis, n)));
  } else {
    for (const Vec3& v : solid.vertices) most = std::max(most, dot(n, v) + solid.radius);
  }
  return most;
}

// By which a plane across n separates the first solid, above it, from the second one.
double separation(const Solid& one, const Place& a, const Solid& other, const Place& b, const Vec3& n) {
  return dot(n, a.r - b.r) - extent(one, transpose_times(a.R, -n)) - extent(other, transpose_times(b.R, n));
}

template <class F>
double largest(double low, double high, const F& f) {
  constexpr double golden = 0.6180339887498949;
  double x = high - golden * (high - low), y = low + golden * (high - low), fx = f(x), fy = f(y);
  for (int k = 0; k < 70; ++k) {
    if (fx > fy)
      high = y, y = x, fy = fx, x = high - golden * (high - low), fx = f(x);
    else
      low = x, x = y, fx = fy, y = low + golden * (high - low), fy = f(y);
  }
  return std::max(fx, fy);
}

// The distance of solids that are apart: the largest separation, whose level sets are convex cones.
double searched(const Solid& one, const Place& a, const Solid& other, const Place& b) {
  Vec3 best{0, 0, 1};
  double most = -HUGE_VAL;
  for (int k = 0; k < 3000; ++k) {
    const double z = (k + 0.5) / 1500 - 1, angle = 2.399963229728653 * k, r = std::sqrt(1 - z * z);
    const Vec3 n{r * std::cos(angle), r * std::sin(angle), z};
    if (const double now = separation(one, a, other, b, n); now > most) most = now, best = n;
  }
  Vec3 across[2];
  perpendiculars(best, across);
  return largest(-0.15, 0.15, [&](double s) {
    return largest(-0.15, 0.15,
                   [&](double t) { return separation(one, a, other, b, normalized(best + s * across[0] + t * across[1])); });
  });
}

Solid random_ellipsoid(Prng& random) {
  const double size = random.uniform(0.2, 0.8);
  const Vec3 axes{size * random.uniform(0.2, 1), size * random.uniform(0.2, 1), size * random.uniform(0.2, 1)};
  return ellipsoid(axes, Pose(random.vector(0.3), random.rotation()));
}

Solid random_other(Prng& random, int kind) {
  const Pose at(random.vector(0.3), random.rotation());
  switch (kind) {
    case 0: return random_ellipsoid(random);
    case 1: return sphere(random.uniform(0.1, 0.6), at);
    case 2: return capsule(random.uniform(0.1, 0.4), random.uniform(0.1, 1), at);
    case 3: return box({random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1)}, at);
    case 4: return cylinder(random.uniform(0.1, 0.5), random.uniform(0.1, 1), at);
    default: {
      std::vector<Vec3> points;
      for (int k = 0; k < 14; ++k) points.push_back(at * random.vector(0.5));
      return hull(points);
    }
  }
}

Place random_place(Prng& random, double size) {
  Place place;
  place.R = rotation_matrix(random.rotation()), place.r = random.vector(size);
  return place;
}

Place moved(const Place& place, double t) {
  Place there = place;
  there.R = rotation_matrix(exp_rotation(t * place.w)) * place.R, there.r = place.r + t * place.v;
  return there;
}

}  // namespace

TEST_CASE("ellipsoids: gaps and points before all solids, apart and overlapping a little") {
  Prng random(71);
  int apart = 0;
  for (int k = 0; k < 900; ++k) {
    CAPTURE(k);
    const Solid one = random_ellipsoid(random), other = random_other(random, k % 6);
    const Place a = random_place(random, 1.2), b = random_place(random, 1.2);
    const double exact = searched(one, a, other, b);
    if (exact < 1e-3) continue;
    ++apart;
    const NearestPoints now = distance(one, a, other, b), turned = distance(other, b, one, a);
    CHECK(std::fabs(now.distance - exact) < 1e-12);
    CHECK(std::fabs(turned.distance - exact) < 1e-12);
    CHECK(std::fabs(separation(one, a, other, b, now.normal) - exact) < 1e-13);
    CHECK(norm(now.on_one - now.on_other - exact * now.normal) < 1e-12);
    CHECK(std::fabs(dot(now.normal, now.on_one - a.r) + extent(one, transpose_times(a.R, -now.normal))) < 1e-13);
    CHECK(std::fabs(dot(now.normal, now.on_other - b.r) - extent(other, transpose_times(b.R, now.normal))) < 1e-13);
    std::vector<Candidate> found;
    face_each_other(one, a, other, b, 10, found);
    REQUIRE(found.size() == 1);
    CHECK(std::fabs(found[0].gap - exact) < 1e-12);
    // Moved along the normal they overlap, with the same points.
    const double depth = 0.3 * one.thickness * one.thickness / (4 * one.reach);
    Place deeper = a;
    deeper.r -= (exact + depth) * now.normal;
    found.clear();
    face_each_other(other, b, one, deeper, 10, found);
    REQUIRE(found.size() == 1);
    CHECK(std::fabs(found[0].gap + depth) < 1e-12);
  }
  CHECK(apart > 400);
}

TEST_CASE("ellipsoids: gap, point and normal move as their rates say") {
  Prng random(72);
  constexpr double weights[4] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280}, h = 1e-3;
  for (int k = 0; k < 600; ++k) {
    CAPTURE(k);
    const Solid one = random_ellipsoid(random), other = random_other(random, k % 6);
    Place a = random_place(random, 1.2), b = random_place(random, 1.2);
    a.v = random.vector(1), a.w = random.vector(2), b.v = random.vector(1), b.w = random.vector(2);
    std::vector<Candidate> found;
    if (k % 7 == 0)
      face_plane(one, a, random.vector(0.5), random.direction(), b, HUGE_VAL, found);
    else
      face_each_other(one, a, other, b, 10, found);
    REQUIRE(found.size() == 1);
    if (found[0].gap < 0.02) continue;
    const Features& f = found[0].features;
    const Touch now = touch(f, a, b);
    Touch rate{};
    for (int i = 1; i <= 4; ++i)
      for (const double side : {1.0, -1.0}) {
        const Touch there = touch(f, moved(a, side * i * h), moved(b, side * i * h));
        const double weight = side * weights[i - 1] / h;
        rate.gap += weight * there.gap, rate.point += weight * there.point, rate.normal += weight * there.normal;
      }
    CHECK(norm(rate.point - now.point_rate) < 2e-5 * (1 + norm(now.point_rate)));
    CHECK(norm(rate.normal - now.normal_rate) < 2e-5 * (1 + norm(now.normal_rate)));
    CHECK(std::fabs(rate.gap - dot(now.normal, relative_velocity(now, a, b))) < 1e-6);
  }
}

TEST_CASE("ellipsoids: needles and coins") {
  Prng random(73);
  for (int k = 0; k < 200; ++k) {
    CAPTURE(k);
    const double thin = random.log_uniform(1e-3, 1);
    const Solid one = ellipsoid({1, k % 2 == 0 ? thin : 1, thin}, Pose({}, random.rotation()));
    const Solid other = k % 3 == 0 ? ellipsoid({thin, 1, 0.5}) : random_other(random, k % 6);
    const Place a = random_place(random, 3), b = random_place(random, 1);
    const double now = distance(one, a, other, b).distance;
    if (!(now > 1e-3)) continue;
    const Vec3 n = distance(one, a, other, b).normal;
    CHECK(std::fabs(separation(one, a, other, b, n) - now) < 1e-11);
    // No direction near it, or anywhere else, separates them by more.
    for (int i = 0; i < 400; ++i) {
      const Vec3 m = normalized(n + random.log_uniform(1e-6, 10) * random.direction());
      CHECK(separation(one, a, other, b, m) < now + 1e-11);
    }
  }
}
