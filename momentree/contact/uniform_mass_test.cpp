#include <momentree/contact/uniform_mass.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

using namespace momentree;

namespace {

using Triangle = std::array<std::uint32_t, 3>;

struct Triangles {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
};

Triangles box_of_triangles(const Vec3& size, const Pose& at) {
  Triangles box;
  for (int i = 0; i < 8; ++i)
    box.points.push_back(at * Vec3{(i & 1) != 0 ? size.x / 2 : -size.x / 2, (i & 2) != 0 ? size.y / 2 : -size.y / 2,
                                   (i & 4) != 0 ? size.z / 2 : -size.z / 2});
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}

void check_equal(const MassProperties& a, const MassProperties& b, double tolerance) {
  CHECK(a.mass == doctest::Approx(b.mass).epsilon(tolerance));
  CHECK(norm(a.com - b.com) < tolerance * (1 + norm(b.com)));
  const double size = b.inertia.xx + b.inertia.yy + b.inertia.zz;
  for (const auto& [x, y] : {std::pair{a.inertia.xx, b.inertia.xx},
                             {a.inertia.yy, b.inertia.yy},
                             {a.inertia.zz, b.inertia.zz},
                             {a.inertia.xy, b.inertia.xy},
                             {a.inertia.xz, b.inertia.xz},
                             {a.inertia.yz, b.inertia.yz}})
    CHECK(std::fabs(x - y) < tolerance * size);
}

}  // namespace

TEST_CASE("a box of triangles has the mass of a box, facing outwards or inwards, wherever it is") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in(-1, 1);
  for (int n = 0; n < 300; ++n) {
    const Vec3 size{1.5 + in(random), 1.5 + in(random), 1.5 + in(random)};
    const Pose at{{5 * in(random), 5 * in(random), 5 * in(random)}, from_rpy(3 * in(random), in(random), 3 * in(random))};
    Triangles box = box_of_triangles(size, at);
    const MassProperties exact = mass_properties(contact::Box{size}, at, 2700);
    check_equal(mass_properties(box.points, box.triangles, 2700), exact, 1e-12);
    for (Triangle& each : box.triangles) std::swap(each[1], each[2]);
    check_equal(mass_properties(box.points, box.triangles, 2700), exact, 1e-12);
  }
}

TEST_CASE("the halves of a cylinder, a capsule from its parts, and a hollow box add up") {
  const MassProperties whole = mass_properties(contact::Cylinder{.radius = 0.3, .length = 2}, {}, 800);
  const contact::Cylinder half{.radius = 0.3, .length = 1};
  const MassProperties halves[] = {mass_properties(half, Pose(Vec3{0, 0, 0.5}), 800),
                                   mass_properties(half, Pose(Vec3{0, 0, -0.5}), 800)};
  check_equal(sum_of(halves), whole, 1e-13);
  CHECK(whole.mass == doctest::Approx(800 * std::numbers::pi * 0.09 * 2));

  const Triangles outside = box_of_triangles({2, 2, 2}, {}), inside = box_of_triangles({1, 1, 1}, {});
  Triangles shell = outside;
  for (const Triangle& each : inside.triangles) shell.triangles.push_back({each[0] + 8, each[2] + 8, each[1] + 8});
  shell.points.insert(shell.points.end(), inside.points.begin(), inside.points.end());
  const MassProperties hollow = mass_properties(shell.points, shell.triangles, 1);
  CHECK(hollow.mass == doctest::Approx(7));
  CHECK(hollow.inertia.xx == doctest::Approx(8 * 8.0 / 12 - 2.0 / 12));
  CHECK(sum_of({}).mass == 0);
}
