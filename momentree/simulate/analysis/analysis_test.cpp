// Linearisation, equilibria and inverse kinematics of machines whose answers can be derived by hand.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/analysis/equilibrium.hpp>
#include <momentree/simulate/analysis/inverse_kinematics.hpp>
#include <momentree/simulate/analysis/linearization.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81, pi = 3.14159265358979323846;

// Hangs along −z for q = 0.
BodySpec rod(std::string name, double length, double mass, BodyId parent = ground, double at = 0) {
  const double I = mass * length * length / 12;
  return {.name = std::move(name),
          .mass = mass,
          .com = {0, 0, -length / 2},
          .inertia = diagonal(I, I, 1e-4),
          .parent = parent,
          .at = Vec3{0, 0, -at},
          .joint = Revolute{.axis = y_axis}};
}
template <class F>
std::string problem(const F& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("a damped pendulum, linearised: A and B, hanging, upright and moving") {
  const double l = 0.6, m = 2, c = 0.3, I = m * l * l / 3;
  for (const double q : {0.0, pi, 0.7}) {
    Model model({.gravity = {0, 0, -g}});
    BodySpec body = rod("rod", l, m);
    body.joint = Revolute{.axis = y_axis, .damping = c};
    body.q = q, body.v = 1.3;
    model.add(body);
    const Linearization all = linearize(World(model));
    REQUIRE(all.nv == 1);
    CHECK(all.A(0, 0) == 0);
    CHECK(all.A(0, 1) == 1);
    CHECK(all.A(1, 0) == doctest::Approx(-m * g * l / 2 / I * std::cos(q)).epsilon(1e-13));
    CHECK(all.A(1, 1) == doctest::Approx(-c / I).epsilon(1e-13));
    CHECK(all.B(0, 0) == 0);
    CHECK(all.B(1, 0) == doctest::Approx(1 / I).epsilon(1e-13));
  }
}

TEST_CASE("a spinning free body: displacements rotate with it, and its angular velocity obeys Euler's linearised equations") {
  Model model;
  const double Ix = 2, Iy = 2.5, Iz = 3.5, wz = 4;
  model.add({.name = "top", .mass = 1, .inertia = diagonal(Ix, Iy, Iz), .joint = Free{}, .v = {0, 0, 0, 0, 0, wz}});
  const Linearization all = linearize(World(model));
  REQUIRE(all.nv == 6);
  CHECK(all.A(3, 4) == doctest::Approx(wz));  // dφx/dt = ωz φy + δωx
  CHECK(all.A(4, 3) == doctest::Approx(-wz));
  CHECK(all.A(9, 10) == doctest::Approx((Iy - Iz) / Ix * wz));
  CHECK(all.A(10, 9) == doctest::Approx((Iz - Ix) / Iy * wz));
  CHECK(all.A(11, 9) == doctest::Approx(0));
}

TEST_CASE("a double pendulum comes to rest hanging from anywhere, with its two modes; upright it is unstable") {
  const auto pendulum = [](double q0, double q1) {
    Model model({.gravity = {0, 0, -g}});
    BodySpec one = rod("one", 1, 1), two = rod("two", 1, 1, BodyId{0}, 1);
    one.q = q0, two.q = q1;
    model.add(one), model.add(two);
    return equilibrium(World(model));
  };
  for (const double q0 : {0.3, 2.0, -3.0})
    for (const double q1 : {0.1, -2.5}) {
      const Equilibrium rest = pendulum(q0, q1);
      CHECK(std::fabs(std::sin(rest.q[0] / 2)) < 1e-9);
      CHECK(std::fabs(std::sin(rest.q[1] / 2)) < 1e-9);
      CHECK(rest.stable());
      // Two equal rods: ω² = (3 ∓ 6/√7) g / l.
      REQUIRE(rest.modes.size() == 2);
      CHECK(rest.modes[0].square == doctest::Approx((3 - 6 / std::sqrt(7.0)) * g).epsilon(1e-10));
      CHECK(rest.modes[1].square == doctest::Approx((3 + 6 / std::sqrt(7.0)) * g).epsilon(1e-10));
      CHECK(rest.modes[0].frequency() == doctest::Approx(std::sqrt(rest.modes[0].square) / (2 * pi)));
    }
  const Equilibrium upright = pendulum(pi, 0);
  CHECK(upright.q[0] == doctest::Approx(pi));
  CHECK(!upright.stable());
  CHECK(upright.modes[0].square < 0);
  CHECK(upright.modes[1].square < 0);
  CHECK(pendulum(pi, pi).modes[0].square < 0);
}

TEST_CASE("springs and stops hold a lever at rest") {
  const double l = 0.8, m = 3, k = 5;
  Model model({.gravity = {0, 0, -g}});
  BodySpec body = rod("lever", l, m);
  body.joint = Revolute{.axis = y_axis, .stiffness = k, .rest = 2.0};
  model.add(body);
  const Equilibrium sprung = equilibrium(World(model));
  CHECK(m * g * l / 2 * std::sin(sprung.q[0]) == doctest::Approx(k * (2 - sprung.q[0])).epsilon(1e-10));
  CHECK(sprung.modes[0].square == doctest::Approx((k + m * g * l / 2 * std::cos(sprung.q[0])) / (m * l * l / 3)).epsilon(1e-10));
  CHECK(sprung.resting.empty());

  Model stopped({.gravity = {0, 0, -g}});
  body.joint = Revolute{.axis = y_axis, .limits = {.lower = 0.5, .upper = 2}};
  body.q = 1.2;
  stopped.add(body);
  BodySpec second = rod("second", 1, 1, BodyId{0}, l);
  stopped.add(second);
  const Equilibrium rest = equilibrium(World(stopped));
  CHECK(rest.q[0] == 0.5);
  CHECK(std::fabs(rest.q[0] + rest.q[1]) < 1e-9);
  CHECK(rest.resting == std::vector<int>{0});
  CHECK(rest.modes.size() == 1);
  CHECK(rest.modes[0].square == doctest::Approx(1.5 * g).epsilon(1e-10));
}

TEST_CASE("stops that hold several joints, and one that another makes superfluous") {
  // Both rods fall towards +q; the first one's stop carries both, and the second one's stop holds it before it hangs.
  Model model({.gravity = {0, 0, -g}});
  BodySpec one = rod("one", 1, 1), two = rod("two", 1, 1, BodyId{0}, 1);
  one.joint = Revolute{.axis = y_axis, .limits = {.lower = 0.8, .upper = 2}};
  two.joint = Revolute{.axis = y_axis, .limits = {.lower = -0.5, .upper = 2}};
  one.q = 1.5, two.q = 0.3;
  model.add(one), model.add(two);
  const Equilibrium both = equilibrium(World(model));
  CHECK(both.q[0] == doctest::Approx(0.8).epsilon(1e-12));
  CHECK(both.q[1] == doctest::Approx(-0.5).epsilon(1e-12));
  CHECK(both.resting == std::vector<int>{0, 1});
  CHECK(both.modes.empty());
  // After a run that ends on the stops, it is the same.
  Simulation sim(model, {.method = "dopri5"});
  REQUIRE(sim.run_until(20));
  const Equilibrium after = equilibrium(sim.world());
  CHECK(after.q[0] == doctest::Approx(0.8).epsilon(1e-9));
  CHECK(after.q[1] == doctest::Approx(-0.5).epsilon(1e-9));
}

TEST_CASE("a load on two cables, and a boom that a cable holds") {
  Model model({.gravity = {0, 0, -g}});
  model.add({.name = "load", .mass = 5, .inertia = diagonal(0.1, 0.1, 0.1), .joint = Free{}, .q = {0.2, 0.1, 0.4, 1, 0, 0, 0}});
  model.add_cable({.name = "left", .from = {{0}, {}}, .to = {ground, {-1, 0, 1}}, .length = 1.5});
  model.add_cable({.name = "right", .from = {{0}, {}}, .to = {ground, {1, 0, 1}}, .length = 1.5});
  const Equilibrium rest = equilibrium(World(model));
  const double depth = std::sqrt(1.5 * 1.5 - 1);
  CHECK(rest.q[0] == doctest::Approx(0).epsilon(1e-9));
  CHECK(rest.q[1] == doctest::Approx(0).epsilon(1e-9));
  CHECK(rest.q[2] == doctest::Approx(1 - depth).epsilon(1e-9));
  CHECK(rest.taut == std::vector<int>{0, 1});
  CHECK(rest.stable());
  // It swings as a pendulum of that depth; it turns freely about its centre.
  REQUIRE(rest.modes.size() == 4);
  CHECK(rest.modes[3].square == doctest::Approx(g / depth).epsilon(1e-7));
  for (int k = 0; k < 3; ++k) CHECK(rest.modes[static_cast<std::size_t>(k)].square == 0);

  Model boom({.gravity = {0, 0, -g}});
  BodySpec spec = rod("boom", 4, 100);
  spec.q = -1.7;
  boom.add(spec);
  boom.add_cable({.name = "guy", .from = {{0}, {0, 0, -4}}, .to = {ground, {0, 0, 3}}, .length = 5});
  const Equilibrium held = equilibrium(World(boom));
  // 3² + 4² = 5²: it holds the boom level.
  CHECK(std::fabs(held.q[0]) == doctest::Approx(pi / 2).epsilon(1e-10));
  CHECK(held.taut == std::vector<int>{0});
  CHECK(held.modes.empty());
  boom = Model({.gravity = {0, 0, -g}});
  spec.q = -1.2;
  boom.add(spec);
  boom.add_cable({.name = "slack", .from = {{0}, {0, 0, -4}}, .to = {ground, {0, 0, 3}}, .length = 8});
  CHECK(std::fabs(equilibrium(World(boom)).q[0]) < 1e-10);
  CHECK(equilibrium(World(boom)).taut.empty());
  boom.add_cable({.name = "short", .from = {{0}, {0, 0, -4}}, .to = {ground, {0, 0, 3}}, .length = 4});
  CHECK(problem([&] { static_cast<void>(equilibrium(World(boom))); }).find("cable 'short' is longer than its length") !=
        std::string::npos);
}

TEST_CASE("a body on four springs: six modes, of which gravity changes none") {
  Model model({.gravity = {0, 0, -g}});
  const double m = 10, k = 400, I = 0.5;
  model.add({.name = "plate", .mass = m, .inertia = diagonal(I, I, I), .joint = Free{}});
  int number = 0;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) {
      Spring spring{.name = "s" + std::to_string(number++), .from = {{0}, {x, y, 0}}, .to = {ground, {x, y, 1}}};
      spring.stiffness = k, spring.rest = 0.5;
      model.add_spring(spring);
    }
  const Equilibrium rest = equilibrium(World(model));
  // Each spring carries a quarter of the weight: its length is 0.5 + m g / 4 k.
  CHECK(rest.q[2] == doctest::Approx(1 - 0.5 - m * g / (4 * k)).epsilon(1e-10));
  REQUIRE(rest.modes.size() == 6);
  CHECK(rest.stable());
  const double length = 0.5 + m * g / (4 * k);
  CHECK(rest.modes[0].square == doctest::Approx(g / length).epsilon(1e-9));  // it swings as a pendulum of the springs' length
  CHECK(rest.modes[1].square == doctest::Approx(g / length).epsilon(1e-9));
  bool bounces = false;
  for (const Mode& mode : rest.modes) bounces = bounces || std::fabs(mode.square - 4 * k / m) < 1e-6;
  CHECK(bounces);
}

TEST_CASE("a four-bar comes to rest where its potential energy is least, and stays closed") {
  Model model({.gravity = {0, 0, -g}});
  BodySpec crank = rod("crank", 0.3, 1), coupler = rod("coupler", 0.5, 1, BodyId{0}, 0.3), rocker = rod("rocker", 0.4, 1);
  crank.q = 1.0, coupler.q = -1.8;
  rocker.at = Vec3{0.4, 0, 0};
  rocker.q = 0.2;
  model.add(crank), model.add(coupler), model.add(rocker);
  model.add_loop({.name = "pin",
                  .body = {2},
                  .to = {1},
                  .joint = Revolute{.axis = y_axis},
                  .at = Vec3{0, 0, -0.5},
                  .child_at = Vec3{0, 0, -0.4}});
  Simulation sim(model);
  const Equilibrium rest = equilibrium(sim.world());
  CHECK(rest.stable());
  CHECK(rest.modes.size() == 1);
  // The engine agrees: from there, it does not move, and vibrates at that frequency if it is pushed a little.
  const std::vector<double> still(3);
  sim.set_state(0, rest.q, still, Variables::velocities);
  const double energy = sim.world().totals().potential;
  for (const double a : sim.world().a()) CHECK(std::fabs(a) < 1e-8);
  for (const double push : {1e-3, -1e-3}) {
    std::vector<double> v = rest.modes[0].shape;
    for (double& each : v) each *= push;
    sim.set_state(0, rest.q, v, Variables::velocities);
    REQUIRE(sim.run_until(1 / (4 * rest.modes[0].frequency())));
    CHECK(sim.world().totals().potential > energy);
    CHECK(std::fabs(sim.world().v()[0]) < 1e-3 * std::fabs(v[0]));
  }
}

TEST_CASE("without an equilibrium, with contacts and with functions: errors that say what to do") {
  Model falling({.gravity = {0, 0, -g}});
  falling.add({.name = "stone", .mass = 1, .inertia = diagonal(1, 1, 1), .joint = Free{}});
  CHECK(problem([&] { static_cast<void>(equilibrium(World(falling))); }).find("joint 'stone' still accelerates") !=
        std::string::npos);
  Model model({.gravity = {0, 0, -g}});
  model.add(rod("rod", 1, 1));
  Simulation sim(model);
  sim.drive("rod", [](const EvaluationContext&) { return 1.0; });
  CHECK(problem([&] { static_cast<void>(linearize(sim.world())); }).find("joint 'rod' is driven by a function") !=
        std::string::npos);
  CHECK(equilibrium(sim.world()).q[0] == doctest::Approx(std::asin(1 / (0.5 * g))));
}

TEST_CASE("an arm reaches points and orientations, within its limits") {
  Model model;
  BodySpec one = rod("one", 1, 1), two = rod("two", 0.8, 1, BodyId{0}, 1), three = rod("three", 0.5, 1, BodyId{1}, 0.8);
  one.q = 0.4, two.q = 0.5, three.q = 0.3;
  two.joint = Revolute{.axis = y_axis, .limits = {.lower = 0, .upper = 2.5}};
  model.add(one), model.add(two), model.add(three);
  const World world(model);
  for (int k = 0; k < 40; ++k) {
    CAPTURE(k);
    const double angle = 0.31 * k, far = 0.5 + 0.04 * k;
    const Vec3 place{far * std::sin(angle), 0, far * std::cos(angle)};
    const KinematicTarget tip{.body = {2}, .point = {0, 0, -0.5}, .position = place};
    const KinematicSolution found = inverse_kinematics(world, {&tip, 1});
    CHECK(found.reached);
    CHECK(found.position_error <= 1e-9);
    CHECK(found.q[1] >= 0);
    CHECK(found.q[1] <= 2.5);
    // Forward kinematics, by hand.
    const double a = found.q[0], b = a + found.q[1], c = b + found.q[2];
    const double x = -std::sin(a) - 0.8 * std::sin(b) - 0.5 * std::sin(c);
    CHECK(x == doctest::Approx(place.x).epsilon(1e-8));
  }
  const KinematicTarget both{
      .body = {2}, .point = {0, 0, -0.5}, .position = Vec3{-1.2, 0, -0.9}, .orientation = from_axis_angle(y_axis, 1.5)};
  const KinematicSolution found = inverse_kinematics(world, {&both, 1});
  CHECK(found.reached);
  CHECK(found.q[0] + found.q[1] + found.q[2] == doctest::Approx(1.5));
  const KinematicTarget away{.body = {2}, .point = {0, 0, -0.5}, .position = Vec3{3, 0, 0}};
  const KinematicSolution nearest = inverse_kinematics(world, {&away, 1});
  CHECK(!nearest.reached);
  CHECK(nearest.position_error == doctest::Approx(0.7).epsilon(1e-6));  // stretched out towards it
  const KinematicTarget nothing{.body = {2}};
  CHECK(problem([&] {
          static_cast<void>(inverse_kinematics(world, {&nothing, 1}));
        }).find("no position and no orientation") != std::string::npos);
}

TEST_CASE("joints with a prescribed motion are held, and must rest") {
  Model model({.gravity = {0, 0, -g}});
  BodySpec one = rod("one", 1, 1), two = rod("two", 1, 1, BodyId{0}, 1);
  JointSpec driven = Revolute{.axis = y_axis};
  driven.parameters.drive = motion_drive(Signal(0.4));
  one.joint = driven;
  model.add(one), model.add(two);
  const Equilibrium rest = equilibrium(World(model));
  CHECK(rest.q[0] == 0.4);
  CHECK(rest.q[1] == doctest::Approx(-0.4).epsilon(1e-10));
  REQUIRE(rest.modes.size() == 1);
  CHECK(rest.modes[0].square == doctest::Approx(1.5 * g).epsilon(1e-10));
  const KinematicTarget away{.body = {0}, .point = {0, 0, -1}, .position = Vec3{-1, 0, 0}};
  CHECK(!inverse_kinematics(World(model), {&away, 1}).reached);
  Model moving({.gravity = {0, 0, -g}});
  one.joint.parameters.drive = motion_drive(Signal::ramp(1, 0));
  moving.add(one), moving.add(two);
  CHECK(problem([&] { static_cast<void>(equilibrium(World(moving))); }).find("prescribed motion of joint 'one'") !=
        std::string::npos);
}

TEST_CASE("a mode that falls slowly beside stiff ones, while a stop holds another joint, is unstable") {
  Model model({.gravity = {0, 0, -g}});
  BodySpec mast = rod("mast", 20, 1), lamp = rod("lamp", 0.1, 0.1), hatch = rod("hatch", 1, 1);
  mast.q = pi;
  lamp.joint = Revolute{.axis = y_axis, .stiffness = 1e5};
  hatch.joint = Revolute{.axis = y_axis, .limits = {.lower = 0.2, .upper = 2}};
  hatch.q = 0.2;
  model.add(mast), model.add(lamp), model.add(hatch);
  const Equilibrium rest = equilibrium(World(model));
  CHECK(rest.resting == std::vector<int>{2});
  CHECK(!rest.stable());
  CHECK(rest.modes[0].square == doctest::Approx(-1.5 * g / 20).epsilon(1e-3));
  Model pressed({.gravity = {0, 0, -g}});
  pressed.add(hatch);
  CHECK(problem([&] { static_cast<void>(linearize(World(pressed))); }).find("is pressed against its stop") != std::string::npos);
}
