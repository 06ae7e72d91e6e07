#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/change.hpp>

using namespace momentree;

namespace {

Model bent_chain(int links) {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < links; ++k) {
    const Vec3 axis{1.0 - 0.3 * k, 0.2 * k, 1};
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = 0.5 + 0.1 * k,
                      .com = {0.1, 0.02, -0.03},
                      .inertia = {0.01, 0.012, 0.013, 0.001, 0, 0.0005},
                      .parent = last,
                      .at = Pose{{0.2, 0.05, 0}, normalized(Quat{1, 0.1, 0.2, -0.3})},
                      .joint = Revolute{.axis = axis, .stiffness = 2.0, .rest = 0.1, .armature = 0.02},
                      .q = 0.3 + 0.1 * k,
                      .v = 1.0 - 0.4 * k,
                      .child_at = Pose{{0.01, 0.02, 0.03}, normalized(Quat{1, -0.2, 0.1, 0.1})}});
  }
  return model;
}

struct Motions {
  std::vector<Vec3> place, linear, angular;
};
Motions motions(const Tree& tree, const State& state) {
  Workspace<double> workspace(tree);
  locate_bodies(tree, state, workspace);
  Motions m;
  for (int b = 0; b < tree.bodies(); ++b) {
    const Kinematics<double>& k = workspace.bodies[static_cast<std::size_t>(b)];
    const Pose pose = user_pose(tree, k, b);
    const Vec3 w = k.R * k.velocity.w;
    m.place.push_back(pose * Vec3{0.1, 0.2, 0.3});
    m.angular.push_back(w);
    m.linear.push_back(k.R * k.velocity.v + cross(w, pose * Vec3{0.1, 0.2, 0.3} - k.r));
  }
  return m;
}

}  // namespace

TEST_CASE("(28) (29) a break changes no pose and no velocity; the ancestors lose the momentum of the part") {
  for (int broken = 0; broken < 5; ++broken) {
    const Model model = bent_chain(5);
    Tree tree = compile(model);
    State state = start_state(model, tree);
    Workspace<double> workspace(tree);
    forward_dynamics(tree, state, workspace);
    const Motions before = motions(tree, state);
    const Totals total = totals(tree, state, workspace);
    const double rotor_and_spring = joint_energy(tree, state, workspace, broken);
    const Released released = apply(Break{tree.inboard_joint({broken})}, tree, state, workspace);
    CHECK(released.energy == doctest::Approx(rotor_and_spring).epsilon(1e-15));
    CHECK(rotor_and_spring > 0);
    CHECK(workspace.evaluated != state.stamp());
    CHECK(tree.bodies() == 5);
    CHECK(tree.parent(broken) == -1);
    CHECK(tree.joint(broken).kind == Kind::free);
    CHECK(tree.nq() == 11);
    CHECK(tree.nv() == 10);
    CHECK(state.q().size() == 11);
    CHECK(state.p().size() == 10);
    const Motions after = motions(tree, state);
    for (std::size_t b = 0; b < 5; ++b) {
      CHECK(norm(after.place[b] - before.place[b]) < 1e-14);
      CHECK(norm(after.linear[b] - before.linear[b]) < 1e-12);
      CHECK(norm(after.angular[b] - before.angular[b]) < 1e-12);
    }
    Workspace<double> fresh(tree);
    const Totals now = totals(tree, state, fresh);
    CHECK(now.kinetic + now.potential + released.energy == doctest::Approx(total.kinetic + total.potential).epsilon(1e-13));
    CHECK(norm(now.linear - total.linear) < 1e-13);
    CHECK(norm(now.angular - total.angular) < 1e-13);
  }
}

TEST_CASE("a broken joint can't break again, and every order of breaks ends in free bodies") {
  const Model model = bent_chain(6);
  Tree tree = compile(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  const Motions before = motions(tree, state);
  for (int b : {3, 0, 5, 1, 4, 2}) {
    REQUIRE(can_break(tree, tree.inboard_joint({b})));
    forward_dynamics(tree, state, workspace);
    apply(Break{tree.inboard_joint({b})}, tree, state, workspace);
    CHECK_FALSE(can_break(tree, tree.inboard_joint({b})));
  }
  const Motions after = motions(tree, state);
  for (std::size_t b = 0; b < 6; ++b) {
    CHECK(tree.parent(static_cast<int>(b)) == -1);
    CHECK(norm(after.linear[b] - before.linear[b]) < 1e-11);
    CHECK(norm(after.angular[b] - before.angular[b]) < 1e-11);
  }
  CHECK(tree.tables().runs.size() == 1);
  for (const unsigned char f : tree.tables().node_flags) CHECK((f & (node::root | node::leaf)) == (node::root | node::leaf));
}
