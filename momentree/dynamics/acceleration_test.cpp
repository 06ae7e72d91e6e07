// The second recursion on small machines with results that can be derived by hand. (Random trees of all kinds against an
// independent oracle: tests/oracle.)
#include <momentree/dynamics/evaluate.hpp>

#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>

using namespace momentree;

namespace {

struct Machine {
  Tree tree;
  State state;
  Workspace<double> workspace;
  explicit Machine(const Model& model) : tree(compile(model)), state(start_state(model, tree)), workspace(tree) {
    locate_bodies(tree, state, workspace);
    accelerate(tree, state, workspace);
  }
  double a(int i) const { return workspace.a[static_cast<std::size_t>(i)]; }
};

void check_near(const Vec3& a, const Vec3& b, double bound = 1e-12) {
  INFO(a.x, " ", a.y, " ", a.z, " for ", b.x, " ", b.y, " ", b.z);
  CHECK(norm(a - b) <= bound);
}

}  // namespace

TEST_CASE("(30) (32) (47) a rod on a revolute joint: acceleration, and the wrench that the joint transmits") {
  // Of length 2l, on a revolute joint about y at its end, rotated by q from +x downwards.
  const double m = 1.5, l = 0.4, q = 0.7, w = 2.3, g = 9.81, rotor = 0.2, damping = 0.3, effort = 1.1, I = m * l * l / 3;
  Model model({.gravity = {0, 0, -g}});
  model.add({.name = "rod",
             .mass = m,
             .com = {l, 0, 0},
             .inertia = diagonal(1e-3, I, I),
             .joint = Revolute{.axis = y_axis, .damping = damping, .armature = rotor, .effort = effort},
             .q = q,
             .v = w});
  const Machine at(model);
  const double tau = effort - damping * w;
  const double a = (tau + m * g * l * std::cos(q)) / (I + m * l * l + rotor);
  CHECK(at.a(0) == doctest::Approx(a).epsilon(1e-14));
  // Rod axes: x along it, z perpendicular and upward; gravity is g (sin q, 0, −cos q) there.
  const Force<double> W = as_force(reaction(at.tree, at.state, at.workspace, at.tree.inboard_joint({0})));
  check_near(W.l, {-m * l * w * w - m * g * std::sin(q), 0, -m * l * a + m * g * std::cos(q)});
  check_near(W.h, {0, tau - rotor * a, 0});
  const Force<double> pure = as_force(bearing_reaction(at.tree, at.state, at.workspace, at.tree.inboard_joint({0})));
  check_near(pure.l, W.l);
  check_near(pure.h, {});
  const BodyAcceleration b = body_acceleration(at.tree, at.state, at.workspace, BodyId{0});
  check_near(b.linear, {});
  check_near(b.angular, {0, a, 0});
}

TEST_CASE("(45) (51) outboard bodies load every joint inboard of them: a chain at rest, and in free fall") {
  Model model({.gravity = {0, 0, -10}});
  BodyId last = ground;
  for (int k = 0; k < 5; ++k)
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = 1.0 + k,
                      .com = {0, 0, -0.5},
                      .inertia = diagonal(0.1),
                      .parent = last,
                      .at = {0, 0, k == 0 ? 0.0 : -1.0},
                      .joint = k % 2 ? JointSpec(Ball{}) : JointSpec(Universal{})});
  const Machine hanging(model);
  double outboard = 15;
  for (int k = 0; k < 5; ++k) {
    const Force<double> W = as_force(reaction(hanging.tree, hanging.state, hanging.workspace, hanging.tree.inboard_joint({k})));
    check_near(W.l, {0, 0, 10 * outboard}, 1e-11);
    check_near(W.h, {}, 1e-11);
    outboard -= 1 + k;
  }
  model.add({.name = "d/0", .mass = 2, .com = {0.3, 0, 0}, .inertia = diagonal(0.1), .joint = Free{}});
  const BodyId base{5};
  model.add(
      {.name = "d/1", .mass = 3, .inertia = diagonal(0.2), .parent = base, .at = {1, 2, 3}, .joint = Prismatic{}, .q = 0.2});
  const Machine falling(model);
  for (const int k : {5, 6}) {
    const Force<double> W = as_force(reaction(falling.tree, falling.state, falling.workspace, falling.tree.inboard_joint({k})));
    check_near(W.l, {}, 1e-14);
    check_near(W.h, {}, 1e-14);
    const BodyAcceleration b = body_acceleration(falling.tree, falling.state, falling.workspace, BodyId{k});
    check_near(b.linear, {0, 0, -10}, 1e-13);
    check_near(b.angular, {}, 1e-13);
  }
}

TEST_CASE("(39) (44) a bead that slides outward on a rotating rod") {
  // The rod rotates about z at the rate w; the bead moves along x at the distance r with the speed s.
  const double w = 3, r = 0.5, s = 0.8, m = 0.2, J = 0.7;
  Model model({.gravity = {}});
  const BodyId rod = model.add({.name = "rod", .mass = 1, .inertia = diagonal(0.4, 0.4, J), .joint = Revolute{}, .v = w});
  model.add({.name = "bead", .mass = m, .parent = rod, .joint = Prismatic{.axis = x_axis}, .q = r, .v = s});
  const Machine at(model);
  const double turning = -2 * m * r * s * w / (J + m * r * r);  // d(J + m r²)w/dt = 0
  CHECK(at.a(0) == doctest::Approx(turning).epsilon(1e-13));
  CHECK(at.a(1) == doctest::Approx(r * w * w).epsilon(1e-13));
  const Force<double> W = as_force(reaction(at.tree, at.state, at.workspace, at.tree.inboard_joint({1})));
  check_near(W.l, {0, m * (2 * s * w + r * turning), 0});
  check_near(W.h, {});
  const BodyAcceleration b = body_acceleration(at.tree, at.state, at.workspace, BodyId{1});
  check_near(b.linear, {0, 2 * s * w + r * turning, 0});
  check_near(b.angular, {0, 0, turning});
}

TEST_CASE("the drive's effort is subtracted from the reaction along the joint's own DoFs") {
  // Some joints hold their body against gravity, some do not; the body's frame is not the joint's.
  const Vec3 to{0.3, -0.2, 0.1};
  const double m = 2, g = 10;
  Model model({.gravity = {0, 0, -g}});
  const auto add = [&](const char* name, JointSpec joint, Values q) {
    model.add({.name = name,
               .mass = m,
               .com = {0.1, 0.2, -0.3},
               .inertia = diagonal(0.4, 0.5, 0.6),
               .joint = joint,
               .q = q,
               .child_at = Pose{to, normalized(Quat{0.9, 0.1, -0.3, 0.2})}});
  };
  add("slide", Prismatic{.effort = 7.0}, 0.3);
  add("screw", Helical{.pitch = 0.5, .effort = 7.0}, 0.3);
  add("tube", Cylindrical{.effort = {7.0, 3.0}}, {0.3, 0.2});
  add("hooke", Universal{.axis = x_axis, .axis2 = normalized(Vec3{1, 1, 0}), .effort = {7.0, 3.0}}, {0.3, 0.2});
  const Machine at(model);
  const auto drive = [&](int b) {  // joint's child-side axes, about its origin
    const Force<double> W = as_force(reaction(at.tree, at.state, at.workspace, at.tree.inboard_joint({b}))) -
                            as_force(bearing_reaction(at.tree, at.state, at.workspace, at.tree.inboard_joint({b})));
    const Pose& side = model[{b}].child_at;
    const Mat3 R = rotation_matrix(side.rotation);
    return Force<double>{transpose_times(R, W.l), transpose_times(R, W.h - cross(side.position, W.l))};
  };
  check_near(drive(0).l, {0, 0, 7});
  check_near(drive(0).h, {});
  check_near(drive(1).l, {});
  check_near(drive(1).h, {0, 0, 7});
  check_near(drive(2).l, {0, 0, 3});
  check_near(drive(2).h, {0, 0, 7});
  // Torques t with n1·t = 7, n2·t = 3 and no component normal to both: n1 is the first axis after the second rotation.
  const Vec3 n2 = model[{3}].joint.axis2;
  const Vec3 n1 = transpose_times(rotation_matrix(from_axis_angle(n2, 0.2)), x_axis), t = drive(3).h;
  check_near(drive(3).l, {});
  CHECK(dot(n1, t) == doctest::Approx(7).epsilon(1e-13));
  CHECK(dot(n2, t) == doctest::Approx(3).epsilon(1e-13));
  CHECK(std::fabs(dot(cross(n1, n2), t)) < 1e-12);
}

TEST_CASE("accelerations carry the stamp of their state") {
  Model model;
  model.add({.name = "a", .mass = 1, .com = {1, 0, 0}, .inertia = diagonal(1), .joint = Ball{}});
  Machine at(model);
  CHECK(at.workspace.accelerated == at.state.stamp());
  static_cast<void>(at.state.edit());
  CHECK(at.workspace.accelerated != at.state.stamp());
  accelerate(at.tree, at.state, at.workspace);
  CHECK(at.workspace.accelerated == at.state.stamp());
  evaluate_rates(at.tree, at.state.q().data(), at.state.p().data(), at.workspace);  // a stage, which belongs to no state
  CHECK(at.workspace.accelerated != at.state.stamp());
}
