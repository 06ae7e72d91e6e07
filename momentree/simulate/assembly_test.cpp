// Loops that are closed at the start, from coordinates that are far off.
#include <cmath>
#include <numbers>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/loops.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {
namespace {

BodySpec bar(const std::string& name, double length, const JointSpec& joint, BodyId parent, double at, Values q) {
  BodySpec body;
  body.name = "m/" + name, body.mass = length, body.com = {length / 2, 0, 0};
  body.inertia = diagonal(1e-4 * length, length * length * length / 12, length * length * length / 12);
  body.joint = joint, body.parent = parent, body.at = Pose{{at, 0, 0}, Quat{}}, body.q = q;
  return body;
}

const JointSpec pin = Revolute{.axis = y_axis};

// A closed polygon of bars on the ground whose last end is pinned `open` times its circumference away from its first one.
Model polygon(int bars, double open, const JointSpec& joint) {
  constexpr double length = 0.1;
  const double turn = -2 * std::numbers::pi / bars;
  Model model;
  BodyId last = ground;
  for (int k = 0; k < bars; ++k) {
    const Values q = joint.kind == Kind::ball ? Values{std::cos(turn / 2), 0, std::sin(turn / 2), 0} : Values{turn};
    last = model.add(bar("b" + std::to_string(k), length, joint, last, k == 0 ? 0 : length, q));
  }
  const double far = open * bars * length;
  model.add_loop({.name = "end", .body = last, .joint = joint, .at = {0.9 * far, 0, -0.4 * far}, .child_at = {length, 0, 0}});
  return model;
}

// Four-bars side by side, each angle off by up to `off` (rad).
Model windows(int count, double off, const JointSpec& joint) {
  Model model;
  std::vector<BodyId> up;
  int k = 0;
  const auto angle = [&](double closed) { return Values{closed + off * std::sin(37.0 * ++k)}; };
  for (int i = 0; i <= count; ++i) up.push_back(model.add(bar("up" + std::to_string(i), 1, pin, ground, i, angle(-1.3))));
  for (int i = 0; i < count; ++i) {
    const BodyId across = model.add(bar("across" + std::to_string(i), 1, pin, up[static_cast<std::size_t>(i)], 1, angle(1.3)));
    const BodyId to = up[static_cast<std::size_t>(i) + 1];
    const std::string name = "l" + std::to_string(i);
    model.add_loop({.name = name, .body = across, .to = to, .joint = joint, .at = {1, 0, 0}, .child_at = {1, 0, 0}});
  }
  return model;
}

Model four_bar(double crank, double coupler, double rocker, const JointSpec& joint) {
  Model model;
  const BodyId a = model.add(bar("crank", 0.12, pin, ground, 0, {crank}));
  const BodyId b = model.add(bar("coupler", 0.38, pin, a, 0.12, {coupler}));
  const BodyId c = model.add(bar("rocker", 0.25, pin, ground, 0.4, {rocker}));
  model.add_loop({.name = "eye", .body = b, .to = c, .joint = joint, .at = {0.25, 0, 0}, .child_at = {0.38, 0, 0}});
  return model;
}

void check_closed(const Model& model) { CHECK(World(model).loop_status().residual < 1e-13); }

}  // namespace

TEST_CASE("long chains close from ends that are far apart") {
  for (const JointSpec& joint : {JointSpec(Ball{}), pin})
    for (const int bars : {10, 100, 300})
      for (const double open : {0.001, 0.01, 0.1, 0.3, 0.8}) {
        CAPTURE(info(joint.kind).name);
        CAPTURE(bars);
        CAPTURE(open);
        check_closed(polygon(bars, open, joint));
      }
}

TEST_CASE("four-bars close from angles that are 30 degrees off, alone and in long rows") {
  for (const JointSpec& joint : {JointSpec(Ball{}), pin, JointSpec(Cylindrical{.axis = y_axis})}) {
    CAPTURE(info(joint.kind).name);
    for (const int count : {1, 2, 5, 40})
      for (const double off : {0.05, 0.2, 0.5}) {
        CAPTURE(count);
        CAPTURE(off);
        check_closed(windows(count, off, joint));
      }
    for (int corner = 0; corner < 27; ++corner) {
      const auto off = [&](int place) { return (corner / place % 3 - 1) * std::numbers::pi / 6; };
      CAPTURE(corner);
      check_closed(four_bar(-1.05 + off(1), 0.7 + off(3), -1.55 + off(9), joint));
    }
  }
}

TEST_CASE("mechanisms close from positions in which all bars are in line, where no small change would bring them nearer") {
  for (const JointSpec& joint : {JointSpec(Ball{}), pin}) {
    CAPTURE(info(joint.kind).name);
    check_closed(windows(1, 0, joint));
    check_closed(four_bar(0, 0, 0, joint));
    for (const int bars : {3, 10, 50}) {
      Model model;
      BodyId last = ground;
      for (int k = 0; k < bars; ++k) last = model.add(bar("b" + std::to_string(k), 0.1, joint, last, k == 0 ? 0 : 0.1, {}));
      model.add_loop({.name = "end", .body = last, .joint = joint, .at = {0.05 * bars, 0, 0}, .child_at = {0.1, 0, 0}});
      CAPTURE(bars);
      check_closed(model);
    }
  }
}

TEST_CASE("lengths whose squares overflow are open, not closed") {
  Model model = polygon(4, 0, pin);
  LoopSpec far = model.loops()[0];
  far.name = "far", far.at.position = {1e300, 0, 0};
  model.add_loop(far);
  CHECK_THROWS_AS(World{model}, Error);
}

TEST_CASE("loops that are too short to close are refused by name, with what remains open") {
  for (const JointSpec& joint : {JointSpec(Ball{}), pin}) {
    Model model = polygon(20, 1.2, joint);  // 20 bars of 0.1 m to a point 2.36 m away
    try {
      [[maybe_unused]] const World world(model);
      FAIL("it cannot be closed");
    } catch (const Error& error) {
      CHECK(error.where == "loop 'end'");
      CHECK(error.problem.find("stays open by") != std::string::npos);
    }
  }
}

}  // namespace momentree
