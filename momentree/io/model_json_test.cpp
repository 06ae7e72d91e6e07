#include <momentree/io/model_json.hpp>

#include <doctest/doctest.h>

#include <momentree/joint/kinds/free.hpp>
#include <momentree/joint/kinds/helical.hpp>
#include <momentree/joint/kinds/revolute.hpp>
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
  Shape ball;
  ball.kind = Shape::Kind::sphere;
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

TEST_CASE("the document lists joints and bodies in the order of the model") {
  Shape box;
  box.kind = Shape::Kind::box;
  box.size = {1, 2, 3};
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
