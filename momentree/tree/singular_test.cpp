#include <doctest/doctest.h>

#include <cmath>

#include <momentree/joint/kinds.hpp>
#include <momentree/model/model.hpp>

namespace momentree {
namespace {

Model chain(int links, const Vec3& along, const JointSpec& joint, double bend = 0) {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < links; ++k) {
    last = model.add({.name = std::to_string(k),
                      .mass = 0.01,
                      .com = 0.5 * along,
                      .inertia = diagonal(1e-6),
                      .parent = last,
                      .at = Pose(k == 0 ? Vec3{} : along, from_axis_angle({1, 2, 3}, bend)),
                      .joint = joint});
  }
  return model;
}

TEST_CASE("a long chain is not singular, in any direction") {
  for (const Vec3& along : {Vec3{0.05, 0, 0}, Vec3{0.01, 0.02, 0.03}})
    for (const double bend : {0.0, 0.1}) {
      CHECK(singular_joints(chain(70000, along, Revolute{.axis = {0, 0, 1}}, bend)).empty());
      CHECK(singular_joints(chain(70000, along, Revolute{.axis = {1, 1, 0}}, bend)).empty());
      CHECK(singular_joints(chain(70000, along, Ball{}, bend)).empty());
    }
}

TEST_CASE("DoFs that share one mass are singular, in any direction") {
  for (const Vec3& axis : {Vec3{0, 0, 1}, Vec3{1, 2, 3}, Vec3{1, -1, 0}}) {
    for (int between = 0; between < 3; ++between) {
      Model model;
      BodyId last = model.add({.name = "first", .joint = Revolute{.axis = axis}});
      for (int k = 0; k < between; ++k)
        last = model.add({.name = "weld" + std::to_string(k), .parent = last, .at = Pose(0.1 * axis)});
      model.add({.name = "second",
                 .mass = 1,
                 .com = {0.1, 0.2, 0.3},
                 .inertia = diagonal(0.1, 0.2, 0.3),
                 .parent = last,
                 .joint = Revolute{.axis = axis}});
      REQUIRE(singular_joints(model).size() == 1);
      CHECK(singular_joints(model)[0].body.index == 0);
    }
  }
}

TEST_CASE("a point on the axis of its joint is singular, also across a weld") {
  for (const Vec3& axis : {Vec3{0, 0, 1}, Vec3{1, 2, 3}, Vec3{0.3, -0.1, 0.7}}) {
    Model model;
    model.add({.name = "bead", .mass = 1, .com = 0.7 * axis, .joint = Revolute{.axis = axis}});
    const BodyId wire = model.add({.name = "wire", .joint = Revolute{.axis = axis}});
    model.add({.name = "far bead", .mass = 1, .com = 0.2 * axis, .parent = wire, .at = Pose(0.5 * axis)});
    CHECK(singular_joints(model).size() == 2);
  }
}

}  // namespace
}  // namespace momentree
