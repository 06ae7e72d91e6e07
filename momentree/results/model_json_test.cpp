#include <momentree/results/model_json.hpp>

#include <doctest/doctest.h>

#include <momentree/joint/kinds/free.hpp>
#include <momentree/joint/kinds/helical.hpp>
#include <momentree/joint/kinds/revolute.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree::io {
namespace {

Model arm() {
  Model model({.gravity = {0, 0, -1}});
  const BodyId base = model.add({.name = "arm/base", .mass = 2, .com = {0, 0, 0.1}, .inertia = diagonal(1), .joint = Free{}});
  const BodyId link = model.add({.name = "arm/<link>",
                                 .mass = 1,
                                 .com = {0.25, 0, 0},
                                 .inertia = {3, 4, 5, 0.1, 0.2, 0.3},
                                 .parent = base,
                                 .at = {0, 0, 0.5},
                                 .joint = Revolute{.axis = {0, 1, 0}},
                                 .joint_name = "arm/hinge"});
  model.add({.name = "arm/nut",
             .mass = 1,
             .inertia = diagonal(1),
             .parent = link,
             .at = {1, 0, 0},
             .joint = Helical{.axis = {1, 0, 0}, .pitch = 0.25}});
  return model;
}

bool mentions(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a body is drawn to its children, a leaf through its centre of mass") {
  const std::string text = model_json(World(arm()), "");
  CHECK(mentions(text, R"("extent": [[[0, 0, 0], [0, 0, 0.5]]])"));  // the base
  CHECK(mentions(text, R"("extent": [[[0, 0, 0], [1, 0, 0]]])"));    // the link
  CHECK(mentions(text, R"("extent": [])"));                          // the nut: its mass is at its joint

  Model rod;
  rod.add({.name = "rod", .mass = 1, .com = {0.5, 0, 0}, .inertia = diagonal(1), .joint = Revolute{}, .child_at = {0.25, 0, 0}});
  CHECK(mentions(model_json(World(rod), ""), R"("extent": [[[0.25, 0, 0], [0.75, 0, 0]]])"));
  const Shape ball = Shape::of(contact::Sphere{});
  CHECK(mentions(model_json(World(rod), "", {ball}), R"("extent": [[[0.25, 0, 0], [0.5, 0, 0]]])"));
}

TEST_CASE("bodies are drawn to the joints that close loops") {
  Model bars;
  const BodyId crank = bars.add({.name = "crank", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}});
  const BodyId bar =
      bars.add({.name = "bar", .mass = 1, .com = {1, 0, 0}, .inertia = diagonal(1), .parent = crank, .joint = Revolute{}});
  bars.add_loop({.name = "pin", .body = bar, .joint = Revolute{}, .at = {2, 0, 0}, .child_at = {2, 0, 0}});
  const std::string text = model_json(World(bars, Variables::velocities), "");
  CHECK(mentions(text, R"("extent": [[[0, 0, 0], [2, 0, 0]]])"));
  CHECK(mentions(text, R"("pin": {"kind": "revolute", "parent": null, "child": "bar")"));
  CHECK(mentions(text, R"("loop": true)"));
}

TEST_CASE("bodies that were removed are not in the document") {
  Simulation simulation(arm());
  simulation.remove(simulation.world().model().body("arm/nut"));
  const std::string text = model_json(simulation.world(), "");
  CHECK(!mentions(text, "arm/nut"));
  CHECK(mentions(text, R"("arm/<link>": {)"));
}

TEST_CASE("bodies without shapes have those of their colliders, and the planes of the ground are listed") {
  Model model;
  const Pose at{{1, 2, 3}, from_rpy(0.3, -0.4, 0.5)};
  const BodyId box = model.add({.name = "box", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
  const BodyId pin = model.add({.name = "pin", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
  const BodyId ball = model.add({.name = "ball", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
  model.add_collider({.body = box, .solid = contact::box({0.5, 2, 3}, at)});
  model.add_collider({.body = box, .solid = contact::sphere(0.25, at)});
  model.add_collider({.body = pin, .solid = contact::capsule(0.125, 4, at)});
  model.add_collider({.body = ball, .solid = contact::sphere(7)});
  model.add_collider({.plane = true, .point = {0, 0, -2}, .normal = {0, 1, 0}});
  const Shape own = Shape::of(contact::Sphere{8});
  const std::vector<Shape> shapes = drawn_shapes(model, {{}, {}, own});
  REQUIRE(shapes.size() == 3);
  REQUIRE(shapes[0].as<contact::Box>());
  CHECK(norm(shapes[0].as<contact::Box>()->size - Vec3{0.5, 2, 3}) < 1e-14);
  REQUIRE(shapes[0].more.size() == 1);
  CHECK(shapes[0].more[0].as<contact::Sphere>());
  CHECK(norm(shapes[0].more[0].at.position - at.position) < 1e-14);
  REQUIRE(shapes[1].as<contact::Capsule>());
  CHECK(shapes[1].as<contact::Capsule>()->length == doctest::Approx(4).epsilon(1e-14));
  for (const Vec3& corner : {Vec3{0.25, 1, 1.5}, {-0.25, 1, -1.5}, {0.25, -1, 1.5}})
    CHECK(norm(shapes[0].at * corner - at * corner) < 1e-14);
  for (const double end : {-2, 2}) CHECK(norm(shapes[1].at * Vec3{0, 0, end} - at * Vec3{0, 0, end}) < 1e-14);
  CHECK(shapes[2].primitive == own.primitive);
  CHECK(shapes[2].more.empty());
  Shape missing;  // a mesh that does not exist
  missing.kind = Shape::Kind::mesh, missing.mesh = "ball.stl";
  CHECK(drawn_shapes(model, {{}, {}, missing})[2].primitive == contact::Primitive(contact::Sphere{7}));
  const std::string replaced = model_json(World(model, Variables::velocities), "", {{}, {}, missing});
  CHECK(mentions(replaced, R"("missing_shapes": [{"kind": "mesh", "file": "ball.stl")"));
  missing.more.push_back(own);
  CHECK(drawn_shapes(model, {{}, {}, missing})[2].kind == Shape::Kind::mesh);
  const std::string text = model_json(World(model, Variables::velocities), "", {{}, {}, own});
  CHECK(mentions(text, R"({"point": [0, 0, -2], "normal": [0, 1, 0]})"));
  CHECK(mentions(text, R"("kind": "capsule", "radius": 0.125)"));
  CHECK(!mentions(model_json(World(arm()), ""), "planes"));
}

TEST_CASE("of the colliders of bodies without shapes cylinders are drawn, hulls are not") {
  Model model;
  const Pose at{{1, 2, 3}, from_rpy(0.3, -0.4, 0.5)};
  const auto add = [&](const char* name, const contact::Solid& solid) {
    const BodyId body = model.add({.name = name, .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
    model.add_collider({.body = body, .solid = solid});
  };
  add("can", contact::cylinder(0.5, 3, at));
  std::vector<Vec3> frustum;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {0.0, 1.0}) frustum.push_back(at * Vec3{(1 - 0.5 * z) * x, (1 - 0.5 * z) * y, z});
  add("frustum", contact::hull(frustum));
  const std::vector<Shape> shapes = drawn_shapes(model, {});
  REQUIRE(shapes.size() == 2);
  REQUIRE(shapes[0].as<contact::Cylinder>());
  CHECK(shapes[0].as<contact::Cylinder>()->radius == 0.5);
  CHECK(shapes[0].as<contact::Cylinder>()->length == doctest::Approx(3).epsilon(1e-14));
  for (const double end : {-1.5, 1.5}) CHECK(norm(shapes[0].at * Vec3{0, 0, end} - at * Vec3{0, 0, end}) < 1e-14);
  CHECK(shapes[1].kind == Shape::Kind::none);
}

TEST_CASE("the document lists joints and bodies in the order of the model") {
  Shape box = Shape::of(contact::Box{{1, 2, 3}});
  box.colour = "#ff8800";
  const std::string text = model_json(World(arm()), "An \"arm\"", {box});
  CHECK(mentions(text, R"("title": "An \"arm\"")"));
  CHECK(mentions(text, R"("gravity": [0, 0, -1])"));
  CHECK(mentions(text, R"("root": "arm/base")"));
  CHECK(mentions(text, R"("inertia": [3, 4, 5, 0.1, 0.2, 0.3])"));
  CHECK(mentions(text, R"("kind": "box", "size": [1, 2, 3])"));
  CHECK(mentions(text, R"("arm/hinge": {"kind": "revolute", "parent": "arm/base", "child": "arm/<link>")"));
  CHECK(mentions(text, R"("pitch": 0.25)"));
  CHECK(text.find(R"("arm/base": {)") < text.find(R"("arm/nut": {)"));
}

}  // namespace momentree::io
