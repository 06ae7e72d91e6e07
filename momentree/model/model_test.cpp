#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/model/model.hpp>
#include <momentree/tree/tree.hpp>

using namespace momentree;

namespace {

const double not_a_number = std::numeric_limits<double>::quiet_NaN();

BodySpec link(std::string name, BodyId parent = ground) {
  return {.name = std::move(name), .mass = 1, .inertia = diagonal(1), .parent = parent, .joint = Revolute{.axis = {0, 0, 2}}};
}

// The message of the Error that add() throws; "accepted" if it does not throw.
std::string refusal(BodySpec spec, Model model = Model{}) {
  try {
    model.add(std::move(spec));
  } catch (const Error& error) {
    return error.message();
  }
  return "accepted";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a copy of a model shares its bodies until one of the two changes") {
  Model first;
  const BodyId a = first.add(link("m/a"));
  Model second = first;
  CHECK(&second.bodies() == &first.bodies());
  second.add(link("m/b", a));
  CHECK(first.size() == 1);
  CHECK(!first.has_body("m/b"));
  CHECK(second.size() == 2);
  CHECK(second.body("m/b").index == 1);
  Model third = second;
  third.keep(1);
  CHECK(!third.has_joint("m/b"));
  CHECK(second.has_joint("m/b"));
  first = third;
  CHECK(&first.bodies() == &third.bodies());
  first.reserve(100);
  CHECK(first.bodies().capacity() >= 100);
  CHECK(third.bodies().capacity() < 100);
  CHECK(first.body("m/a") == a);
}

TEST_CASE("a model completes omitted values and normalises axes") {
  Model model;
  const BodyId a = model.add(link("arm/1"));
  BodySpec spec = link("arm/2", a);
  spec.joint = Free{};
  spec.at.rotation = {1 + 4e-7, 0, 0, 0};
  spec.joint_name = "arm/wrist";
  const BodyId b = model.add(spec);
  CHECK(model[a].joint.axis == Vec3{0, 0, 1});
  CHECK(model[a].joint_name == "arm/1");
  CHECK(model[a].q.empty());  // whether a start value was given matters where loops are closed
  CHECK(model[b].v.empty());
  CHECK(model[b].at.rotation.w == 1);
  CHECK(model.joint("arm/wrist") == model.inboard_joint(b));
  CHECK(model.body("arm/2") == b);
  CHECK(!model.has_joint("arm/2"));
}

TEST_CASE("an axis of any length is accepted, however large") {
  Model model;
  BodySpec spec = link("a");
  spec.joint.axis = {0, 3e200, 4e200};
  const BodyId a = model.add(spec);
  CHECK(norm(model[a].joint.axis) == doctest::Approx(1));
  CHECK(model[a].joint.axis.y == doctest::Approx(0.6));
}

TEST_CASE("a model refuses errors in a body, and names it") {
  const auto changed = [](auto change) {
    BodySpec spec = link("b");
    change(spec);
    return refusal(spec);
  };
  CHECK(changed([](BodySpec&) {}) == "accepted");
  CHECK(changed([](BodySpec& s) { s.mass = 0, s.inertia = {}; }) == "accepted");  // whether it is singular depends on the whole
                                                                                  // model
  CHECK(contains(changed([](BodySpec& s) { s.name = ""; }), "needs a name"));
  CHECK(contains(changed([](BodySpec& s) { s.name = "a,b"; }), "comma"));
  CHECK(contains(changed([](BodySpec& s) { s.mass = -1; }), "b: error: mass: must not be negative"));
  CHECK(contains(changed([](BodySpec& s) { s.mass = not_a_number; }), "mass: must be finite"));
  CHECK(contains(changed([](BodySpec& s) { s.mass = 0; }), "without mass"));
  CHECK(contains(changed([](BodySpec& s) { s.com.y = not_a_number; }), "com: must be finite"));
  CHECK(contains(changed([](BodySpec& s) { s.inertia = diagonal(1, 1, -1); }), "negative principal moment"));
  CHECK(contains(changed([](BodySpec& s) { s.inertia = diagonal(1, 1, 3); }), "more than the sum"));
  CHECK(contains(changed([](BodySpec& s) { s.joint.axis = {}; }), "axis: an axis of length zero"));
  CHECK(contains(changed([](BodySpec& s) {
                   s.joint = Universal{.axis = {0, 0, 1}, .axis2 = {0, 0, -2}};
                 }),
                 "axis2: is parallel"));
  CHECK(contains(changed([](BodySpec& s) { s.joint = Helical{.axis = {0, 0, 1}, .pitch = 0}; }), "pitch"));
  CHECK(contains(changed([](BodySpec& s) { s.joint.parameters.damping = -1; }), "damping: must not be negative"));
  CHECK(contains(changed([](BodySpec& s) { s.joint.parameters.damping = {1, 2}; }), "1 degree of freedom, not 2"));
  CHECK(contains(changed([](BodySpec& s) { s.joint = Ball{.effort = 1.0}; }), "one effort for 3 degrees of freedom"));
  CHECK(contains(changed([](BodySpec& s) { s.q = {1, 2}; }), "q: a revolute joint has 1 coordinate, not 2"));
  CHECK(contains(changed([](BodySpec& s) { s.v = {1, 2}; }), "v: a revolute joint has 1 velocity, not 2"));
  CHECK(contains(changed([](BodySpec& s) { s.joint = Ball{}, s.q = {0, 0, 0, 0}; }), "quaternion of zeros"));
  CHECK(contains(changed([](BodySpec& s) { s.at.rotation = {1.1, 0, 0, 0}; }), "at: the length of the quaternion is not 1"));
  CHECK(contains(changed([](BodySpec& s) { s.parent = {0}; }), "not a body of this model"));
  CHECK(contains(changed([](BodySpec& s) { s.parent = {-2}; }), "not a body of this model"));
}

TEST_CASE("names of bodies and of joints are unique") {
  Model model;
  BodySpec first = link("m/a");
  first.joint_name = "m/hinge";
  model.add(first);
  CHECK(contains(refusal(link("m/a"), model), "body with that name"));
  BodySpec second = link("m/b");
  second.joint_name = "m/hinge";
  CHECK(contains(refusal(second, model), "already a joint 'm/hinge'"));
}

TEST_CASE("for an unknown name the error suggests the nearest one") {
  Model model;
  model.add(link("arm/elbow"));
  CHECK_THROWS_AS(model.body("arm/ebow"), Error);
  try {
    model.joint("arm/ebow");
  } catch (const Error& error) {
    CHECK(error.hint == "did you mean 'arm/elbow'?");
  }
}

TEST_CASE("a mechanism is named by the part before the slash, unless an earlier one has that name") {
  Model model;
  const BodyId a = model.add(link("m/a"));
  const BodyId b = model.add(link("m/b"));
  const BodyId c = model.add(link("alone"));
  CHECK(model.mechanism_name(a) == "m");
  CHECK(model.mechanism_name(b) == "m/b");
  CHECK(model.mechanism_name(c) == "alone");
}

TEST_CASE("a model is compiled once, by whichever thread needs it first, and again after each kind of change") {
  Model model;
  const BodyId a = model.add(link("m/a")), b = model.add(link("m/b", a));
  std::vector<const Tree*> seen(8);
  std::vector<std::thread> threads;
  for (const Tree*& tree : seen) threads.emplace_back([&model, &tree] { tree = &model.compiled(); });
  for (std::thread& thread : threads) thread.join();
  for (const Tree* tree : seen) CHECK(tree == &model.compiled());

  const auto stays = [&](const auto& change) {
    Model copy = model;
    if (&copy.compiled() != &model.compiled()) return false;
    change(copy);
    const Tree now(copy);
    CHECK(copy.compiled().topology().model == now.topology().model);
    CHECK(copy.compiled().bodies() == now.bodies());
    CHECK(copy.compiled().loops().size() == now.loops().size());
    return &copy.compiled() == &model.compiled();
  };
  CHECK(stays([](Model&) {}));
  CHECK(stays([](Model& m) { m.reserve(10); }));
  CHECK(stays([](Model& m) { m.add_contact_rule({}); }));  // a tree has neither colliders nor their rules
  CHECK(stays([](Model& m) { m.add_collider({.plane = true}); }));
  CHECK(!stays([&](Model& m) { m.add(link("m/c", b)); }));
  CHECK(!stays([&](Model& m) { m.set_gravity({0, 0, 1}); }));
  CHECK(!stays([&](Model& m) { m.add_force({.body = a}); }));
  CHECK(!stays([&](Model& m) { m.add_spring({.name = "s", .from = {ground, {0, 0, 1}}, .to = {b, {}}, .stiffness = 1}); }));
  CHECK(!stays([&](Model& m) { m.add_loop({.name = "l", .body = b, .joint = Ball{}}); }));
  CHECK(!stays([&](Model& m) { m.add_coupling({.joint = {0}, .follows = {1}}); }));
  CHECK(!stays([&](Model& m) { m.keep(1); }));

  // A change of the only model that has a tree, and of one that was moved from and assigned to.
  Model alone = model;
  alone.set_gravity({0, 0, 2});
  const Tree before = alone.compiled();
  alone.set_gravity({0, 0, 3});
  CHECK(before.gravity() == Vec3{0, 0, 2});
  CHECK(alone.compiled().gravity() == Vec3{0, 0, 3});
  Model taken = std::move(alone);
  alone = taken;
  CHECK(&alone.compiled() == &taken.compiled());
}
