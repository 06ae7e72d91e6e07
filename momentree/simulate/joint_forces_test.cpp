#include <cmath>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

// A point mass at 2 m from a revolute joint about y, driven and damped.
Model pendulum() {
  Model model({.gravity = {0, 0, -9.81}});
  model.add({.name = "bob",
             .mass = 3,
             .com = {0, 0, -2},
             .joint = Revolute{.axis = y_axis, .damping = 0.5, .effort = 4},
             .q = 0.7,
             .v = 1.5,
             .joint_name = "pin"});
  return model;
}

// Three floating bodies; each joint has further bodies on both sides.
Model floating() {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId hull = model.add({.name = "hull",
                                 .mass = 2,
                                 .com = {0.1, 0, 0.2},
                                 .inertia = diagonal(0.3, 0.4, 0.5),
                                 .joint = Free{},
                                 .v = {0.1, -0.2, 0.3, 1, 2, -3}});
  const BodyId arm = model.add({.name = "arm",
                                .mass = 1,
                                .com = {0.25, 0, 0},
                                .inertia = diagonal(0.1, 0.2, 0.3),
                                .parent = hull,
                                .at = {0, 0, 0.5},
                                .joint = Ball{.damping = {0.1, 0.2, 0.3}},
                                .v = {0.5, 0.25, -0.125}});
  model.add({.name = "hand",
             .mass = 0.5,
             .com = {0, 0.1, 0},
             .inertia = diagonal(0.01),
             .parent = arm,
             .at = {0.5, 0, 0},
             .joint = Revolute{.axis = y_axis, .stiffness = 2},
             .q = 0.7,
             .v = -1});
  return model;
}

double distance(const Wrench& a, const Wrench& b) { return norm(a.force - b.force) + norm(a.torque - b.torque); }

}  // namespace

TEST_CASE("a pendulum: acceleration, joint reaction and the drive's share of it, step by step") {
  Simulation sim(pendulum(), {.step = 1e-2});
  for (int k = 0; k < 10; ++k) {
    const World& world = sim.world();
    const JointView hinge = world.joint({0});
    const JointForces forces = world.joint_forces({0});
    const double q = hinge.q[0], v = hinge.v[0], drive = 4 - 0.5 * v;
    const double a = (drive - 3 * 9.81 * 2 * std::sin(q)) / 12;
    REQUIRE(forces.a.size() == 1);
    CHECK(forces.a[0] == doctest::Approx(a).epsilon(1e-13));
    // In the bob's axes: along the rod the force that keeps it on its circle, across it the force that balances the drive's
    // torque.
    const Vec3 pull{-drive / 2, 0, 3 * (9.81 * std::cos(q) + 2 * v * v)};
    CHECK(distance(forces.reaction, {pull, {0, drive, 0}}) < 1e-12 * norm(pull));
    CHECK(distance(forces.bearing, {pull, {}}) < 1e-12 * norm(pull));
    CHECK(norm(world.accelerations()[0].linear) < 1e-13);
    CHECK(norm(world.accelerations()[0].angular - Vec3{0, a, 0}) < 1e-13);
    CHECK(sim.step(0.1) == Status::ok);
  }
}

TEST_CASE("torques of reactions are about the joint's frame: a pin has none about its axis, and a hook none at all") {
  // A rod of mass 3 whose frame is at its centre, 0.8 m from the point where it hangs: the weight is taken there alone.
  const Pose end{{0, 0, 0.8}, from_axis_angle(x_axis, 0.3)};
  for (const bool hook : {false, true}) {
    Model model({.gravity = {0, 0, -9.81}});
    BodySpec rod{.name = "rod", .mass = 3, .inertia = diagonal(0.2, 0.3, 0.1), .child_at = end, .joint_name = "pin"};
    if (hook)
      rod.joint = Ball{}, rod.q = {std::cos(0.4), 0, std::sin(0.4), 0}, rod.v = {0.3, -1.5, 2};
    else
      rod.joint = Revolute{.axis = y_axis}, rod.q = {0.8}, rod.v = {-1.5};
    model.add(rod);
    Simulation sim(model, {.step = 1e-3});
    CHECK(sim.run_until(0.1) == Status::ok);
    const JointForces forces = sim.world().joint_forces({0});
    const Vec3 axis = rotation_matrix(end.rotation) * y_axis;
    REQUIRE(norm(forces.reaction.force) > 10);
    CHECK(std::fabs(hook ? norm(forces.reaction.torque) : dot(forces.reaction.torque, axis)) <
          1e-13 * norm(forces.reaction.force));
    CHECK(distance(forces.bearing, forces.reaction) < 1e-13 * norm(forces.reaction.force));
    // About the centre of mass the same wrench turns the rod: Euler's equation.
    const BodyMotion& motion = sim.world().motions()[0];
    const Mat3 R = rotation_matrix(motion.pose.rotation);
    const Vec3 w = transpose_times(R, motion.angular), rate = transpose_times(R, sim.world().accelerations()[0].angular);
    const Sym3 J = diagonal(0.2, 0.3, 0.1);
    const Vec3 turns = J * rate + cross(w, J * w);
    CHECK(norm(forces.reaction.torque + cross(end.position, forces.reaction.force) - turns) <
          1e-12 * norm(forces.reaction.force));
  }
}

TEST_CASE("accelerations are the rates of the velocities of motions and joints") {
  const double h = 1e-5;
  Simulation sim(floating(), {.step = h});
  CHECK(sim.run_until(0.02) == Status::ok);
  const auto velocities = [&] {
    std::vector<double> v;
    for (int j = 0; j < 3; ++j)
      for (const double x : sim.world().joint({j}).v) v.push_back(x);
    return v;
  };
  const std::vector<BodyMotion> before = sim.world().motions();
  const std::vector<double> v_before = velocities();
  CHECK(sim.step(h) == Status::ok);
  const std::vector<BodyAcceleration> accelerations = sim.world().accelerations();
  std::vector<double> a;
  for (int j = 0; j < 3; ++j)
    for (const double x : sim.world().joint_forces({j}).a) a.push_back(x);
  CHECK(sim.step(h) == Status::ok);
  const std::vector<BodyMotion> after = sim.world().motions();
  for (std::size_t b = 0; b < 3; ++b) {
    CHECK(norm(0.5 / h * (after[b].linear - before[b].linear) - accelerations[b].linear) < 1e-5);
    CHECK(norm(0.5 / h * (after[b].angular - before[b].angular) - accelerations[b].angular) < 1e-5);
    CHECK(norm(accelerations[b].linear) > 1);
  }
  const std::vector<double> v_after = velocities();
  REQUIRE(a.size() == 10);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(std::fabs((v_after[i] - v_before[i]) / (2 * h) - a[i]) < 1e-5);
}

TEST_CASE("reactions do not depend on the root; a lock transmits the effort along its DoF") {
  Simulation sim(floating(), {.step = 1e-3});
  CHECK(sim.run_until(0.1) == Status::ok);
  const Wrench arm = sim.world().joint_forces({1}).reaction, hand = sim.world().joint_forces({2}).reaction;
  const BodyAcceleration hull = sim.world().accelerations()[0];
  sim.apply(reroot("hand"));
  REQUIRE(sim.world().joint({1}).reversed);
  CHECK(distance(sim.world().joint_forces({1}).reaction, arm) < 1e-11 * norm(arm.force));
  CHECK(distance(sim.world().joint_forces({2}).reaction, hand) < 1e-11 * norm(arm.force));
  CHECK(norm(sim.world().accelerations()[0].linear - hull.linear) < 1e-11 * norm(hull.linear));
  sim.apply(lock("hand"));
  const JointForces locked = sim.world().joint_forces({2});
  REQUIRE(locked.a.size() == 1);
  CHECK(locked.a[0] == 0);
  CHECK(std::fabs(locked.bearing.torque.y) > 0.01);
  CHECK(distance(locked.bearing, locked.reaction) == 0);
}

TEST_CASE("joint forces belong to the state: after undo they are the same to the last bit; removed bodies have none") {
  Simulation sim(floating(), {.step = 1e-3});
  CHECK(sim.run_until(0.05) == Status::ok);
  const WorldSnapshot then = sim.world().snapshot();
  const std::vector<BodyAcceleration> accelerations = sim.world().accelerations();
  const Wrench arm = sim.world().joint_forces({1}).reaction;
  World world(floating());
  CHECK(norm(world.accelerations()[1].linear - accelerations[1].linear) > 1e-3);
  world.restore(then);
  CHECK(world.accelerations()[1].linear == accelerations[1].linear);
  CHECK(distance(world.joint_forces({1}).reaction, arm) == 0);
  sim.remove({2});
  REQUIRE_FALSE(sim.world().alive({2}));
  CHECK(sim.world().accelerations()[2].linear == Vec3{});
  CHECK(norm(sim.world().accelerations()[1].linear - accelerations[1].linear) > 1e-3);
}
