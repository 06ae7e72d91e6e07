// Primitive shapes: their solids and back, and bodies of uniform density.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/contact/primitive.hpp>
#include <momentree/contact/shapes/distance.hpp>

using namespace momentree;
using namespace momentree::contact;

namespace {

const Primitive shapes[] = {Box{{0.5, 0.4, 0.3}}, Sphere{0.3}, Cylinder{0.2, 0.6}, Capsule{0.2, 0.4}, Ellipsoid{{0.3, 0.2, 0.1}}};

struct Sizes {
  std::vector<double> all;
  void operator()(const char*, double x, const Field&) { all.push_back(x); }
  void operator()(const char*, const Vec3& x, const Field&) { all.insert(all.end(), {x.x, x.y, x.z}); }
};

}  // namespace

TEST_CASE("primitives: the shape and the place of a solid are those from which it was made") {
  const Pose at{{1, 2, 3}, from_rpy(0.3, -0.4, 0.5)};
  for (const Primitive& shape : shapes) {
    CAPTURE(info(shape).key);
    const Solid made = solid(shape, at);
    const auto placed = primitive_of(made);
    REQUIRE(placed);
    REQUIRE(placed->shape.index() == shape.index());
    Sizes sizes, same;
    describe(sizes, shape), describe(same, placed->shape);
    for (std::size_t i = 0; i < sizes.all.size(); ++i) CHECK(same.all[i] == doctest::Approx(sizes.all[i]).epsilon(1e-14));
    const Solid again = solid(placed->shape, placed->at);
    for (const Vec3& n : {Vec3{1, 0, 0}, {0, 0.6, 0.8}, {-0.6, 0, 0.8}}) {
      const double distance = distance_to_plane(made, {}, {}, n).distance;
      CHECK(distance_to_plane(again, {}, {}, n).distance == doctest::Approx(distance).epsilon(1e-13));
    }
  }
}

TEST_CASE("primitives: volume and moments of inertia are sums over small parts") {
  constexpr int n = 80;
  constexpr double step = 0.8 / n;
  Solid point = sphere(1);
  point.radius = point.reach = 0;
  for (const Primitive& shape : shapes) {
    CAPTURE(info(shape).key);
    const Solid whole = solid(shape, {});
    double volume = 0;
    Vec3 squares{};
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
          const Vec3 p{(i + 0.5) * step - 0.4, (j + 0.5) * step - 0.4, (k + 0.5) * step - 0.4};
          if (distance(point, {.r = p}, whole, {}).distance > 0) continue;
          volume += step * step * step;
          squares += step * step * step * Vec3{p.x * p.x, p.y * p.y, p.z * p.z};
        }
    const UniformBody body = uniform(shape);
    CHECK(body.volume == doctest::Approx(volume).epsilon(5e-3));
    CHECK(body.moments.x == doctest::Approx(squares.y + squares.z).epsilon(1e-2));
    CHECK(body.moments.y == doctest::Approx(squares.z + squares.x).epsilon(1e-2));
    CHECK(body.moments.z == doctest::Approx(squares.x + squares.y).epsilon(1e-2));
  }
}

TEST_CASE("primitives: those with a size that is not above zero have no volume") {
  CHECK(has_volume(Box{}));
  CHECK_FALSE(has_volume(Box{{1, 0, 1}}));
  CHECK_FALSE(has_volume(Cylinder{1, 0}));
  CHECK_FALSE(has_volume(Sphere{-1}));
}
