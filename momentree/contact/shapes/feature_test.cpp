// Gaps of features, and their rates against differences.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/circle.hpp>
#include <momentree/contact/shapes/feature.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using namespace momentree::contact;
using oracle::Prng;

namespace {

// A body that moves uniformly: its place at time t.
struct Moving {
  Vec3 r, v, w;
  Quat at;
  Place place(double t) const {
    Place p;
    p.R = rotation_matrix(exp_rotation(t * w) * at);
    p.r = r + t * v, p.v = v, p.w = w;
    return p;
  }
};
Moving random_body(Prng& random) {
  Moving m;
  m.r = random.vector(2), m.v = random.vector(1), m.w = random.vector(2), m.at = random.rotation();
  return m;
}

// Derivatives of f at 0, of order 8.
template <class F>
auto derivative(const F& f) -> decltype(f(0.0)) {
  constexpr double weights[4] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280}, h = 1e-3;
  auto sum = weights[0] / h * (f(h) - f(-h));
  for (int k = 2; k <= 4; ++k) sum = sum + weights[k - 1] / h * (f(k * h) - f(-k * h));
  return sum;
}

// The line is before one point of the circle, which does not jump, and the ellipse that is seen along it is not too sharp there.
bool regular(const Features& f, const Moving& a, const Moving& b) {
  Vec3 last{};
  for (const double t : {-4e-3, 0.0, 4e-3}) {
    const Place at_a = a.place(t), at_b = b.place(t);
    const Vec3 axis = at_a.R * f.line_a, line = at_b.R * f.line_b;
    const Vec3 from = at_a.r + at_a.R * f.point_a - at_b.r - at_b.R * f.point_b;
    const OnCircle at = nearest_to_line(from, axis, f.rim, line, f.side > 0);
    if (!at.found || (last != Vec3{} && norm(at.radial - last) > 0.1)) return false;
    last = at.radial;
    const Vec3 d = from + f.rim * at.radial, tangent = cross(axis, at.radial), seen = at.radial - dot(at.radial, line) * line;
    if (f.rim * (1 - dot(tangent, line) * dot(tangent, line)) - dot(d, seen) < 0.2) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("contact features: gap, point and normal move as their rates say") {
  Prng random(7);
  int rims = 0;
  for (int k = 0; k < 6000; ++k) {
    Features f;
    f.pair = static_cast<FeaturePair>(random.integer(0, 6));
    if (f.pair == FeaturePair::cable) f.pair = FeaturePair::circle_line;
    const bool rim_before_line = f.pair == FeaturePair::circle_line;
    const bool on_plane = f.pair == FeaturePair::point_plane || f.pair == FeaturePair::circle_plane;
    f.point_a = random.vector(1), f.point_b = random.vector(1);
    f.line_a = random.direction(), f.line_b = random.direction();
    f.radius_a = random.uniform(0, 0.5), f.radius_b = on_plane ? 0 : random.uniform(0, 0.5);
    if (f.pair == FeaturePair::circle_plane || f.pair == FeaturePair::point_circle) f.rim = random.uniform(0.1, 1);
    if (f.pair == FeaturePair::circle_plane || rim_before_line) f.radius_a = 0;
    if (rim_before_line) f.rim = random.uniform(0.1, 1);
    f.side = random.chance(0.5) ? 1 : -1;
    const Moving a = random_body(random), b = random_body(random);
    const Vec3 la = a.place(0).R * f.line_a, lb = b.place(0).R * f.line_b;
    if (rim_before_line) f.side = std::fabs(dot(la, lb)) < 0.5 ? 1 : 0;
    const auto at = [&](double t) { return touch(f, a.place(t), b.place(t)); };
    const Touch now = at(0);
    if (now.gap + f.radius_a + f.radius_b < 0.3 && !on_plane && f.pair != FeaturePair::line_line && !rim_before_line) continue;
    if (f.pair == FeaturePair::circle_plane && norm(cross(la, lb)) < 0.3) continue;
    if (f.pair == FeaturePair::point_circle &&
        norm(cross(lb, a.place(0).r + a.place(0).R * f.point_a - b.place(0).r - b.place(0).R * f.point_b)) < 0.3)
      continue;
    if (f.pair == FeaturePair::line_line && norm(cross(la, lb)) < 0.4) continue;
    if (rim_before_line && (norm(cross(la, lb)) < 0.2 || !regular(f, a, b))) continue;
    rims += rim_before_line ? 1 : 0;
    CHECK(norm(now.normal) == doctest::Approx(1));
    for (const Vec3& t : now.tangent) {
      CHECK(norm(t) == doctest::Approx(1));
      CHECK(std::fabs(dot(t, now.normal)) < 1e-14);
    }
    CHECK(norm(derivative([&](double t) { return at(t).point; }) - now.point_rate) < 1e-6 * (1 + norm(now.point_rate)));
    CHECK(norm(derivative([&](double t) { return at(t).normal; }) - now.normal_rate) < 1e-6 * (1 + norm(now.normal_rate)));
    // The gap's rate is the relative velocity along the normal, wherever along the normal the point is.
    const double rate = derivative([&](double t) { return at(t).gap; });
    const Place pa = a.place(0), pb = b.place(0);
    Touch middle = now;
    if (f.pair == FeaturePair::line_line) {
      // Material points of both bodies, at the nearest points of the lines.
      const Along along = nearest_along(f, pa, pb);
      const Vec3 qa = pa.r + pa.R * f.point_a + along.a * la, qb = pb.r + pb.R * f.point_b + along.b * lb;
      CHECK(std::fabs(dot(now.normal, qa - qb) - (now.gap + f.radius_a + f.radius_b)) < 1e-10);
      CHECK(norm(cross(now.normal, qa - qb)) < 1e-10);
    }
    CHECK(std::fabs(dot(now.normal, relative_velocity(middle, pa, pb)) - rate) < 1e-6 * (1 + std::fabs(rate)));
  }
  CHECK(rims > 100);
}

TEST_CASE("contact features: the lowest point of a circle, and its distance from a point, against many of its points") {
  Prng random(8);
  for (int k = 0; k < 200; ++k) {
    const Place a = random_body(random).place(0), b = random_body(random).place(0);
    Features f{FeaturePair::circle_plane, random.vector(1), random.direction(), random.vector(1), random.direction()};
    f.rim = random.uniform(0.1, 1);
    Features near = f;
    near.pair = FeaturePair::point_circle;
    double lowest = HUGE_VAL, nearest = HUGE_VAL;
    Vec3 of_a[2], of_b[2];
    perpendiculars(f.line_a, of_a), perpendiculars(f.line_b, of_b);
    for (int i = 0; i < 4000; ++i) {
      const double angle = i * (3.14159265358979323846 / 2000), c = f.rim * std::cos(angle), s = f.rim * std::sin(angle);
      const Vec3 on_a = a.r + a.R * (f.point_a + c * of_a[0] + s * of_a[1]);
      const Vec3 on_b = b.r + b.R * (f.point_b + c * of_b[0] + s * of_b[1]);
      lowest = std::min(lowest, dot(b.R * f.line_b, on_a - b.r - b.R * f.point_b));
      nearest = std::min(nearest, norm(a.r + a.R * f.point_a - on_b));
    }
    CHECK(std::fabs(touch(f, a, b).gap - lowest) < 2e-6);
    CHECK(std::fabs(touch(near, a, b).gap - nearest) < 2e-6);
  }
}

TEST_CASE("contact features: spheres, planes and capsules by hand") {
  Place a, b;
  a.r = {0, 0, 3};
  const Features ball{FeaturePair::point_plane, {}, {}, {0, 0, 1}, {0, 0, 1}, 0.5, 0};
  const Touch on_floor = touch(ball, a, b);
  CHECK(on_floor.gap == 1.5);
  CHECK(on_floor.point == Vec3{0, 0, 2.5});
  const Features balls{FeaturePair::point_point, {}, {}, {0, 4, 0}, {}, 1, 2};
  CHECK(touch(balls, a, b).gap == 2);
  const Features rods{FeaturePair::line_line, {}, {1, 0, 0}, {0, 7, 0}, {0, 1, 0}, 0.25, 0.5, 1};
  CHECK(touch(rods, a, b).gap == 2.25);
  CHECK(touch(rods, a, b).normal == Vec3{0, 0, 1});
  const Features on_rod{FeaturePair::point_line, {}, {}, {0, 7, 0}, {0, 1, 0}, 0.25, 0.5};
  CHECK(touch(on_rod, a, b).gap == 2.25);
}
