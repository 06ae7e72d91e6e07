// Loops that are closed at the start, from coordinates that are far off.
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/world/world.hpp>

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

Model four_bar(Values crank, Values coupler, Values rocker, const JointSpec& joint) {
  Model model;
  const BodyId a = model.add(bar("crank", 0.12, pin, ground, 0, crank));
  const BodyId b = model.add(bar("coupler", 0.38, pin, a, 0.12, coupler));
  const BodyId c = model.add(bar("rocker", 0.25, pin, ground, 0.4, rocker));
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

TEST_CASE("what no loop or coupling needs to move stays where it is, also where closing needs a bent start") {
  // Two bars in one line, pinned at 0.6 m: they bend by arccos 0.6/1 to one of the two sides.
  for (const bool first : {true, false}) {
    Model model;
    const auto add_slide = [&] {
      model.add({.name = "slide", .mass = 1, .inertia = diagonal(0.01), .joint = Prismatic{.axis = x_axis}});
    };
    if (first) add_slide();
    const BodyId a = model.add(bar("a", 0.5, pin, ground, 0, {0.0}));
    const BodyId b = model.add(bar("b", 0.5, pin, a, 0.5, {0.0}));
    model.add_loop({.name = "pin", .body = b, .joint = Cylindrical{.axis = y_axis}, .at = {0.6, 0, 0}, .child_at = {0.5, 0, 0}});
    if (!first) add_slide();
    const World world(model);
    CHECK(std::fabs(world.joint(world.model().joint("slide")).q[0]) < 1e-12);
    CHECK(std::fabs(world.joint(world.model().joint("m/a")).q[0]) == doctest::Approx(std::acos(0.6)).epsilon(1e-12));
  }
}

TEST_CASE("coordinates that occur in no equation of a loop keep their start") {
  // Planes in series: the second one's displacement in its plane moves nothing that the loop holds.
  Model model;
  const auto add = [&](const char* name, const JointSpec& joint, BodyId parent, Values q, double mass) {
    BodySpec body;
    body.name = name, body.mass = mass, body.inertia = diagonal(0.02, 0.024, 0.025);
    body.joint = joint, body.parent = parent, body.q = q;
    return model.add(body);
  };
  const BodyId base = add("base", Free{}, ground, {0.1, 0.05, 0.5, 0.7, 0.5, 0.1, -0.5}, 0.4);
  const BodyId plate = add("plate", Planar{}, base, {}, 2.5);
  const BodyId turn = add("turn", Revolute{.axis = z_axis}, ground, {}, 0.7);
  const BodyId roll = add("roll", Cylindrical{.axis = x_axis}, turn, {}, 0.9);
  const BodyId slide = add("slide", Prismatic{.axis = y_axis}, roll, {}, 0.36);
  model.add_loop({.name = "plane", .body = plate, .to = slide, .joint = Planar{}});
  const World world(model);
  CHECK(world.loop_status().residual < 1e-12);
  for (int i = 0; i < 2; ++i) CHECK(std::fabs(world.joint(world.model().joint("plate")).q[static_cast<std::size_t>(i)]) < 1e-6);
  for (const BodyMotion& motion : world.motions()) CHECK(norm(motion.pose.position) < 2);
}

TEST_CASE("such coordinates return to their start also from far off") {
  Model model;
  const auto add = [&](const char* name, const JointSpec& joint, BodyId parent, Values q, double mass, const Sym3& inertia) {
    BodySpec body;
    body.name = name, body.mass = mass, body.inertia = inertia, body.joint = joint, body.parent = parent, body.q = q;
    return model.add(body);
  };
  const Values pose{0.096, 0.047, 0.494, 0.7026020158830055, 0.4644431033892375, 0.2646238314822251, -0.469699093892013};
  const BodyId base = add("base", Free{}, ground, pose, 0.449, diagonal(0.003989, 0.003618, 0.00143));
  const BodyId plate = add("plate", Planar{}, base, {}, 2.497, diagonal(0.02102, 0.024245, 0.024871));
  const BodyId turn = add("turn", Revolute{.axis = z_axis}, ground, {}, 0.7, {});
  const BodyId roll = add("roll", Cylindrical{.axis = x_axis}, turn, {}, 0.898, diagonal(0.005396, 0.004635, 0.008184));
  const BodyId slide = add("slide", Prismatic{.axis = y_axis}, roll, {}, 0.358, {});
  model.add_loop({.name = "plane", .body = plate, .to = slide, .joint = Planar{}});
  const World world(model);
  CHECK(world.loop_status().residual < 1e-12);
  for (int i = 0; i < 3; ++i) CHECK(std::fabs(world.joint({plate.index}).q[static_cast<std::size_t>(i)]) < 1e-9);
}

TEST_CASE("lengths whose squares overflow are open, not closed") {
  Model model = polygon(4, 0, pin);
  LoopSpec far = model.loops()[0];
  far.name = "far", far.at.position = {1e300, 0, 0};
  model.add_loop(far);
  CHECK_THROWS_AS(World{model}, Error);
}

// A crank of length r, a rod of length l and a piston on the x-axis, of which only some start values are given.
TEST_CASE("given start values are kept, and the others close the loop") {
  constexpr double r = 0.1, l = 0.25, angle = 0.7, speed = 40;
  struct Given {
    Values crank_v, rod_v, piston_v;
    double crank_speed;
  };
  const double x = r * std::cos(angle) + std::sqrt(l * l - r * r * std::sin(angle) * std::sin(angle));
  const double slope = -r * std::sin(angle) * (1 + r * std::cos(angle) / (x - r * std::cos(angle)));  // dx/d(angle)
  for (const Given& given : {Given{speed, {}, {}, speed}, Given{speed, 0, {}, speed}, Given{speed, 0, 0, speed},
                             Given{{}, {}, 2, 2 / slope}, Given{0, {}, 2, 2 / slope}}) {
    Model model;
    BodySpec crank = bar("crank", r, pin, ground, 0, angle), rod = bar("rod", l, pin, {0}, r, {});
    BodySpec piston = bar("piston", 0.1, Prismatic{.axis = x_axis}, ground, 0, {});
    crank.v = given.crank_v, rod.v = given.rod_v, piston.v = given.piston_v;
    for (const BodySpec& each : {crank, rod, piston}) model.add(each);
    model.add_loop({.name = "wrist", .body = {1}, .to = {2}, .joint = pin, .child_at = {l, 0, 0}});
    for (const Variables variables : {Variables::velocities, Variables::momenta}) {
      const World world(model, variables, variables);
      CHECK(world.loop_status().residual < 1e-13);
      CHECK(world.joint({0}).q[0] == angle);
      CHECK(world.joint({2}).q[0] == doctest::Approx(x).epsilon(1e-12));
      CHECK(world.joint({0}).v[0] == doctest::Approx(given.crank_speed).epsilon(1e-12));
      CHECK(world.joint({2}).v[0] == doctest::Approx(slope * given.crank_speed).epsilon(1e-12));
    }
  }
}

TEST_CASE("rounded start values that contradict each other change by little, whatever follows from them") {
  const World exact(four_bar(-1.05, {}, {}, pin));
  const double rocker = exact.joint({2}).q[0];
  CHECK(exact.joint({0}).q[0] == -1.05);
  const World world(four_bar(-1.05, {}, std::round(rocker * 100) / 100, pin));
  CHECK(world.loop_status().residual < 1e-13);
  CHECK(world.joint({0}).q[0] == doctest::Approx(-1.05).epsilon(0.01));
  CHECK(world.joint({1}).q[0] == doctest::Approx(exact.joint({1}).q[0]).epsilon(0.01));
  CHECK(world.joint({2}).q[0] == doctest::Approx(rocker).epsilon(0.01));
}

TEST_CASE("the given pose and velocity of a floating mechanism are kept") {
  Model model;
  BodySpec hull = bar("hull", 1, Free{}, ground, 0, {1, 2, 3, 0.8, 0, 0.6, 0});
  hull.v = {0.1, 0.2, 0.3, 1, 2, 3};
  const BodyId base = model.add(hull);
  BodySpec crank = bar("crank", 0.12, pin, base, 0, -1.05);
  crank.v = 5;
  const BodyId a = model.add(crank), b = model.add(bar("coupler", 0.38, pin, a, 0.12, {}));
  const BodyId c = model.add(bar("rocker", 0.25, pin, base, 0.4, {}));
  model.add_loop({.name = "eye", .body = b, .to = c, .joint = pin, .at = {0.25, 0, 0}, .child_at = {0.38, 0, 0}});
  const World world(model);
  CHECK(world.loop_status().residual < 1e-13);
  const JointView root = world.joint({base.index});
  for (int i = 0; i < 7; ++i) CHECK(root.q[static_cast<std::size_t>(i)] == doctest::Approx(hull.q[i]).epsilon(1e-14));
  for (int i = 0; i < 6; ++i) CHECK(root.v[static_cast<std::size_t>(i)] == doctest::Approx(hull.v[i]).epsilon(1e-13));
  CHECK(world.joint({a.index}).q[0] == -1.05);
  CHECK(world.joint({a.index}).v[0] == doctest::Approx(5).epsilon(1e-13));
}

TEST_CASE("given start values of one mechanism are kept although those of another contradict each other") {
  Model model = four_bar(-1.05, 0.7, -1.5, pin);  // open by some hundredths
  const BodyId crank = model.add(bar("other", 0.1, pin, ground, 0, 0.7));
  const BodyId rod = model.add(bar("rod", 0.25, pin, crank, 0.1, {}));
  const BodyId piston = model.add(bar("piston", 0.1, Prismatic{.axis = x_axis}, ground, 0, {}));
  model.add_loop({.name = "wrist", .body = rod, .to = piston, .joint = pin, .child_at = {0.25, 0, 0}});
  const World world(model);
  CHECK(world.loop_status().residual < 1e-13);
  CHECK(world.joint({crank.index}).q[0] == 0.7);
  CHECK(world.joint({0}).q[0] != -1.05);
}

TEST_CASE("a coupling moves the joint whose start is not given, but not beyond its stop") {
  const auto coupled = [](Values leader, Values follower, double stop) {
    Model model;
    model.add(bar("leader", 1, pin, ground, 0, leader));
    BodySpec follows = bar("follower", 1, pin, ground, 1, follower);
    follows.joint.parameters.limits = {.lower = -stop, .upper = stop};
    model.add(follows);
    model.add_coupling({.joint = {1}, .follows = {0}, .multiplier = 2});
    return model;
  };
  const auto leader = [&](Values one, Values other) { return World(coupled(one, other, 2)).joint({0}).q[0]; };
  CHECK(leader({}, 0.5) == doctest::Approx(0.25).epsilon(1e-12));
  CHECK(leader(0.4, {}) == 0.4);
  CHECK(leader(0.4, 0.5) == 0.4);  // they contradict each other: the joint that follows gives way
  try {
    const World world(coupled(0.4, {}, 0.3));
    FAIL("it starts beyond its stop");
  } catch (const Error& error) {
    CHECK(error.where == "joint 'm/follower'");
    CHECK(error.problem == "it starts beyond its limits, at 0.8, where loops or couplings put it");
  }
}

// The angles of a rocker for a crank of length a at angle `crank`, a coupler b, a rocker c and a ground link g, by Freudenstein's
// equation in tan(rocker/2); NaN if they cannot close.
std::array<double, 2> rocker_angles(double a, double b, double c, double g, double crank) {
  const double k1 = g / a, k2 = g / c, k3 = (a * a - b * b + c * c + g * g) / (2 * a * c), cosine = std::cos(crank);
  const double A = (1 - k2) * cosine - k1 + k3, B = -2 * std::sin(crank), C = k1 - (1 + k2) * cosine + k3;
  const double root = std::sqrt(B * B - 4 * A * C);
  return {2 * std::atan2(-B - root, 2 * A), 2 * std::atan2(-B + root, 2 * A)};
}

TEST_CASE("joints without start values close loops within limits that exclude their zero, or are named") {
  constexpr double turn = 2 * std::numbers::pi;
  std::mt19937_64 random(7);
  const auto draw = [&random](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const JointSpec hinge = Revolute{.axis = z_axis};
  int closed = 0, refused = 0;
  while (closed + refused < 400) {
    const double a = draw(0.1, 0.3), b = draw(0.2, 0.6), c = draw(0.2, 0.5), g = draw(0.3, 0.6), crank = draw(-3, 3), speed = 2;
    auto angles = rocker_angles(a, b, c, g, crank);
    if (draw(0, 1) < 0.5) std::swap(angles[0], angles[1]);
    const auto [rocker, other] = std::array{std::remainder(angles[0], turn), std::remainder(angles[1], turn)};
    const double low = rocker - draw(0.05, 1), high = rocker + draw(0.05, 1);
    // The other branch is outside, by more than a turn, and so is zero.
    if (!(low * high > 0) || !(std::fabs(std::remainder(other - rocker, turn)) > 1.1)) continue;
    const auto start = [&](Variables variables) {
      Model model;
      BodySpec driver = bar("crank", a, hinge, ground, 0, crank), follower = bar("rocker", c, hinge, ground, g, {});
      driver.v = speed, follower.joint.parameters.limits = {.lower = low, .upper = high};
      const BodyId first = model.add(driver), rod = model.add(bar("coupler", b, hinge, first, a, {})), last = model.add(follower);
      model.add_loop({.name = "pin", .body = rod, .to = last, .joint = hinge, .at = {c, 0, 0}, .child_at = {b, 0, 0}});
      return World(model, variables, variables);
    };
    CAPTURE(closed + refused);
    try {
      for (const Variables variables : {Variables::velocities, Variables::momenta}) {
        const World world = start(variables);
        CHECK(world.loop_status().residual < 1e-12);
        CHECK(world.joint({0}).q[0] == crank);
        CHECK(std::fabs(world.joint({2}).q[0] - rocker) < 1e-9);
        const double across = crank + world.joint({1}).q[0];
        const double rate = speed * a * std::sin(crank - across) / (c * std::sin(rocker - across));
        CHECK(std::fabs(world.joint({2}).v[0] - rate) < 1e-8 * (1 + std::fabs(rate)));
      }
      ++closed;
    } catch (const Error& error) {
      CHECK(error.where == "joint 'm/rocker'");
      CHECK(error.problem.find("beyond its limits") != std::string::npos);
      ++refused;
    }
  }
  CHECK(closed > 250);
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
