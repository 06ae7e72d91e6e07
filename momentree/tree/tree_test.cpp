#include <momentree/tree/edit.hpp>

#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/state.hpp>

using namespace momentree;

namespace {
BodyId link(Model& model, const char* name, BodyId parent, JointSpec joint = Revolute{}) {
  return model.add({.name = name, .mass = 1, .inertia = diagonal(1), .parent = parent, .at = {0.5, 0, 0}, .joint = joint});
}
}  // namespace

TEST_CASE("bodies of one kind are one kernel run, with branching bodies and leaves among them") {
  Model model;
  const BodyId a = link(model, "a", ground), b = link(model, "b", a), c = link(model, "c", b);
  const BodyId d = link(model, "d", c, Ball{}), e = link(model, "e", c);
  link(model, "f", d), link(model, "g", e), link(model, "h", ground);
  const Tree tree(model);
  // a b c | d | f e g | h, which is a plane mechanism
  REQUIRE(tree.tables().runs.size() == 4);
  CHECK(tree.tables().runs[0].end == 3);
  CHECK(tree.tables().runs[1].kind == Kind::ball);
  CHECK(tree.tables().runs[2].end == 7);
  CHECK_FALSE(tree.tables().runs[2].planar);
  CHECK(tree.tables().runs[3].planar);
  const std::string order = [&] {
    std::string names;
    for (const int body : tree.order()) names += model[{body}].name;
    return names;
  }();
  CHECK(order == "abcdfegh");
  const auto flags_of = [&](char name) { return tree.tables().node_flags[order.find(name)] & ~(node::aligned | node::grounded); };
  CHECK(flags_of('a') == node::root);
  CHECK(flags_of('b') == node::first_child);
  CHECK(flags_of('c') == (node::first_child | node::branching));
  CHECK(flags_of('d') == node::first_child);
  CHECK(flags_of('f') == (node::first_child | node::leaf));
  CHECK(flags_of('e') == node::last_child);
  CHECK(flags_of('g') == (node::first_child | node::leaf));
  CHECK(flags_of('h') == (node::root | node::leaf));
  CHECK(tree.nq() == 7 + 4);
  CHECK(tree.nv() == 7 + 3);
  CHECK(tree.subtree_mass(0) == 7);
  CHECK(tree.subtree_mass(7) == 1);
}

TEST_CASE("equal links are stored once; a changed tree and its copies do not share") {
  Model model;
  BodyId last = link(model, "0", ground);
  for (int k = 1; k < 20; ++k) last = link(model, std::to_string(k).c_str(), last);
  const Tree tree(model);
  for (int b = 2; b < 19; ++b) {
    CHECK(&tree.link(b) == &tree.link(1));
    CHECK(&tree.frame(b) == &tree.frame(1));
    CHECK(&tree.joint(b) == &tree.joint(1));
  }
  Tree changed = tree;
  changed.edit().detach(10);
  CHECK(tree.joint(10).kind == Kind::revolute);
  CHECK(changed.joint(10).kind == Kind::free);
  CHECK(&changed.link(3) == &tree.link(3));
  CHECK(&changed.link(10) != &tree.link(10));
  Tree copy;
  copy = changed;
  CHECK(&copy.link(3) == &tree.link(3));
  CHECK(&copy.link(10) != &changed.link(10));
  copy.edit().detach(5);
  CHECK(changed.joint(5).kind == Kind::revolute);
  changed.edit().restore(tree.topology());
  for (int b = 0; b < 20; ++b) CHECK(&changed.link(b) == &tree.link(b));
}

TEST_CASE("every body comes after its parent in the order, for bushy trees and after breaks") {
  Model model;
  std::vector<BodyId> bodies{ground};
  for (int k = 0; k < 60; ++k) {
    const std::string name = "m/" + std::to_string(k);
    bodies.push_back(link(model, name.c_str(), bodies[static_cast<std::size_t>((k * 7) % (k + 1))]));
  }
  Tree tree(model);
  const auto check = [&] {
    std::vector<int> place(60, -1);
    for (int i = 0; i < 60; ++i) place[static_cast<std::size_t>(tree.order()[static_cast<std::size_t>(i)])] = i;
    for (int b = 0; b < 60; ++b) {
      CHECK(place[static_cast<std::size_t>(b)] >= 0);
      if (tree.parent(b) >= 0) CHECK(place[static_cast<std::size_t>(tree.parent(b))] < place[static_cast<std::size_t>(b)]);
    }
    int covered = 0;
    for (const KernelRun& s : tree.tables().runs) {
      CHECK(s.begin == covered);
      covered = s.end;
    }
    CHECK(covered == 60);
  };
  check();
  for (int b : {13, 2, 44, 0, 59}) {
    tree.edit().detach(b);
    check();
  }
}

TEST_CASE("chains of revolute joints are aligned: no link needs a rotation about its parent's z") {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < 20; ++k)
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = 1,
                      .inertia = diagonal(1),
                      .parent = last,
                      .at = Pose{{0.1 * k, 0.2, 0.3}, normalized(Quat{1, 0.1 * k, -0.2, 0.3})},
                      .joint = Revolute{.axis = {1, 0.1 * k, -0.5}}});
  const Tree tree(model);
  CHECK(tree.tables().runs.size() == 1);
  for (int b = 1; b < 20; ++b) {  // the first body is on the ground, whose axes are given
    CHECK((tree.tables().node_flags[static_cast<std::size_t>(b)] & node::aligned) != 0);
    // A link has two lengths: along the parent's x, and along the joint's axis. The last one's frame is at its joint.
    CHECK(tree.link(b).shape == PlacementShape::screw);
  }
}

TEST_CASE("a welded body has the frame of the body that carries it, chosen for the next joint") {
  Model model;
  const Pose askew{{0.1, 0.2, 0.3}, normalized(Quat{1, 0.1, -0.2, 0.3})};
  const auto add = [&](BodyId parent, const JointSpec& joint) {
    return model.add({.name = "b/" + std::to_string(model.size()),
                      .mass = 1,
                      .com = {0.1, 0, 0.2},
                      .inertia = diagonal(1),
                      .parent = parent,
                      .at = askew,
                      .joint = joint,
                      .child_at = inverse(askew) * Pose(0, 0, 0.1)});
  };
  const BodyId base = add(ground, Weld{}), hinge = add(base, Revolute{.axis = {1, 0.2, 0}}), bracket = add(hinge, Weld{}),
               plate = add(bracket, Weld{}), elbow = add(plate, Revolute{.axis = {0, 1, 0.3}});
  add(plate, Ball{});
  Tree tree(model);
  const auto place = [&](BodyId body) { return tree.frame(body.index); };
  const Pose step = askew * inverse(model[bracket].child_at);  // pose of one welded body in the next
  const auto same = [&](const KernelFrame& inner, const KernelFrame& outer) {
    const Vec3 r = step * inner.r, z = rotation_matrix(step.rotation) * Vec3{inner.R.xz, inner.R.yz, inner.R.zz};
    return norm(r - outer.r) < 1e-15 && norm(z - Vec3{outer.R.xz, outer.R.yz, outer.R.zz}) < 1e-15;
  };
  CHECK(same(place(bracket), place(hinge)));
  CHECK(same(place(plate), place(bracket)));
  CHECK(same(place(base), KernelFrame{}));
  CHECK(aligned(tree.link(elbow.index)));
  CHECK(tree.link(elbow.index).shape == PlacementShape::screw);
  tree.edit().detach(plate.index);  // removes the joint on which the frames depended
  CHECK_FALSE(same(place(plate), place(bracket)));
  CHECK(same(place(bracket), place(hinge)));
}

TEST_CASE("state: coordinates and momenta of a body are replaced without moving the storage") {
  Model model;
  link(model, "a", ground), link(model, "b", {0}, Ball{}), link(model, "c", {1});
  Tree tree(model);
  State state(tree);
  for (std::size_t i = 0; i < state.q().size(); ++i) state.edit().q[i] = 10 + static_cast<double>(i);
  const double* storage = state.q().data();
  const double q[7] = {1, 2, 3, 4, 5, 6, 7}, p[6] = {1, 2, 3, 4, 5, 6};
  tree.edit().set_joint(1, floating_root_joint());
  state.replace(1, 4, q, 1, 3, p, tree);  // grows
  REQUIRE(state.q().size() == 9);
  CHECK(state.q()[0] == 10);
  CHECK(state.q()[7] == 7);
  CHECK(state.q()[8] == 15);
  CHECK(state.p().size() == 8);
  tree.edit().set_joint(1, Joint{});
  state.replace(1, 7, {}, 1, 6, {}, tree);  // shrinks
  REQUIRE(state.q().size() == 2);
  CHECK(state.q()[0] == 10);
  CHECK(state.q()[1] == 15);
  CHECK(state.q().data() == storage);
  CHECK(state.topology() == tree.revision());
}

TEST_CASE("joints that move no mass are found and named") {
  Model model;
  const BodyId a = link(model, "a", ground);
  CHECK(singular_joints(model).empty());
  model.add({.name = "point", .mass = 1, .parent = a, .joint = Revolute{}, .joint_name = "pin"});
  REQUIRE(singular_joints(model).size() == 1);
  CHECK(singular_joints(model)[0].body.index == 1);
  CHECK(singular_joints(model)[0].what.find("revolute") != std::string::npos);
  model.add({.name = "massless", .parent = a, .joint = Weld{}});
  CHECK(singular_joints(model).size() == 1);
  Model rotor;
  rotor.add({.name = "point", .mass = 1, .joint = Revolute{.armature = 0.1}});
  CHECK(singular_joints(rotor).empty());
  Model pendulum;
  pendulum.add({.name = "bob", .mass = 1, .com = {0, 0, -1}, .joint = Ball{}});  // a point mass has no inertia about the line to
                                                                                 // it
  CHECK(singular_joints(pendulum).size() == 1);
}
