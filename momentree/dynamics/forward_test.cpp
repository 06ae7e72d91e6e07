// The recursions against their own equations, on small trees that show each of them. (Random trees of all kinds against an
// independent oracle: tests/oracle.)
#include <momentree/dynamics/evaluate.hpp>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>

using namespace momentree;

namespace {

// One body per kind of joint on a trunk, two of them branching, and one mechanism on a free root.
Model all_kinds_model() {
  Model model({.gravity = {0.5, -2, -9}});
  const auto body = [&](const char* name, BodyId parent, JointSpec joint, Values q, Values v) {
    return model.add({.name = name,
                      .mass = 1.25,
                      .com = {0.1, -0.05, 0.2},
                      .inertia = {0.05, 0.06, 0.07, 0.004, -0.003, 0.002},
                      .parent = parent,
                      .at = Pose{{0.3, 0.1, -0.2}, normalized(Quat{0.9, 0.1, -0.3, 0.2})},
                      .joint = joint,
                      .q = q,
                      .v = v,
                      .child_at = Pose{{0.02, -0.03, 0.01}, normalized(Quat{0.8, -0.2, 0.1, 0.4})}});
  };
  const Quat r = normalized(Quat{0.7, 0.3, -0.5, 0.4});
  const BodyId trunk = body("a/trunk", ground, Revolute{.axis = {1, 2, 2}, .armature = 0.3}, 0.4, 1.2);
  const BodyId slide = body("a/slide", trunk, Prismatic{.axis = {0, 1, 1}}, 0.2, -0.7);
  const BodyId screw = body("a/screw", slide, Helical{.axis = {1, 0, 0}, .pitch = 0.5}, -0.6, 0.9);
  body("a/tip", screw, Ball{.armature = {0.1, 0.2, 0.3}}, {r.w, r.x, r.y, r.z}, {0.3, -0.8, 0.5});
  const BodyId hooke = body("a/hooke", slide, Universal{.axis = {1, 0.2, 0}, .axis2 = {0, 1, 0.5}}, {0.3, -0.9}, {1, -0.4});
  body("a/rod", hooke, Cylindrical{}, {0.5, 0.3}, {-0.6, 0.8});
  const BodyId base = body("b/base", ground, Free{}, {1, 2, 3, r.w, r.x, r.y, r.z}, {0.1, 0.2, 0.3, -0.4, 0.5, -0.6});
  const BodyId plate = body("b/plate", base, Planar{}, {0.1, -0.2, 0.7}, {0.9, 0.1, -0.5});
  body("b/knob", plate, Weld{}, {}, {});
  return model;
}

struct Fixture {
  Model model = all_kinds_model();
  Tree tree = compile(model);
  State state = start_state(model, tree);
  Workspace<double> workspace{tree};
  Fixture() { forward_dynamics(tree, state, workspace); }

  // Pb by definition: the sum of the momenta of all outboard bodies, transformed to b's frame through the world frame.
  Force<double> summed_momentum(int b) {
    locate_bodies(tree, state, workspace);
    const Kinematics<double>& frame = workspace.bodies[static_cast<std::size_t>(b)];
    Force<double> sum{};
    for (int k = 0; k < tree.bodies(); ++k) {
      int a = k;
      while (a >= 0 && a != b) a = tree.parent(a);
      if (a != b) continue;
      const Kinematics<double>& body = workspace.bodies[static_cast<std::size_t>(k)];
      const Force<double> P = momentum(tree.link(k).body, body.velocity);
      const Vec3 l = body.R * P.l;
      sum.l += l;
      sum.h += body.R * P.h + cross(body.r - frame.r, l);
    }
    return {transpose_times(frame.R, sum.l), transpose_times(frame.R, sum.h)};
  }
};

}  // namespace

TEST_CASE("(12) (19) velocities to momenta and back, for every kind and with armature") {
  Fixture f;
  for (int b = 0; b < f.tree.bodies(); ++b) {
    const Values& v = f.model[{b}].v;
    for (int i = 0; i < v.size(); ++i)
      CHECK(f.workspace.v[static_cast<std::size_t>(f.tree.first_p(b) + i)] == doctest::Approx(v[i]).epsilon(1e-12));
  }
}

TEST_CASE("(14) (21) (22) (23) the articulated momentum is the sum over all outboard bodies") {
  Fixture f;
  for (int b = 0; b < f.tree.bodies(); ++b) {
    const Force<double> Pb = articulated_momentum(f.tree, f.state, f.workspace, b), sum = f.summed_momentum(b);
    CHECK(norm(Pb.l - sum.l) < 1e-12);
    CHECK(norm(Pb.h - sum.h) < 1e-12);
  }
}

TEST_CASE("the path to one body gives the same pose as the pass over all bodies") {
  Fixture f;
  Workspace<double> other(f.tree);
  forward_dynamics(f.tree, f.state, other);
  locate_bodies(f.tree, f.state, f.workspace);
  for (int b = 0; b < f.tree.bodies(); ++b) {
    const DenseTransform<double> path = locate_body(f.tree, f.state, other, b);
    const Kinematics<double>& all = f.workspace.bodies[static_cast<std::size_t>(b)];
    CHECK(norm(path.r - all.r) < 1e-14);
    CHECK(norm(path.R * Vec3{1, 2, 3} - all.R * Vec3{1, 2, 3}) < 1e-14);
  }
}

TEST_CASE("(11) kinetic energy is half of p.v, on fixed ground") {
  Fixture f;
  double pv = 0;
  for (int i = 0; i < f.tree.nv(); ++i)
    pv += f.state.p()[static_cast<std::size_t>(i)] * f.workspace.v[static_cast<std::size_t>(i)];
  CHECK(totals(f.tree, f.state, f.workspace).kinetic == doctest::Approx(pv / 2).epsilon(1e-13));
}

TEST_CASE("(15) (20) energy is conserved along the rates: gravity does the work that the potential loses") {
  // d(T + V)/dt by differences along (qdot, pdot), which must be zero by (20) and the accumulated weight (15).
  Fixture f;
  const auto energy_at = [&](double h) {
    State moved = f.state;
    for (std::size_t i = 0; i < moved.q().size(); ++i) moved.edit().q[i] += h * f.workspace.qdot[i];
    for (std::size_t i = 0; i < moved.p().size(); ++i) moved.edit().p[i] += h * f.workspace.pdot[i];
    Workspace<double> workspace(f.tree);
    const Totals t = totals(f.tree, moved, workspace);
    return t.kinetic + t.potential;
  };
  const double h = 1e-5;
  CHECK(std::fabs(energy_at(h) - energy_at(-h)) / (2 * h) < 1e-6);
}

TEST_CASE("a free root's rate of momentum is its weight, in its own rotating axes") {
  Fixture f;
  const int base = f.model.body("b/base").index, at = f.tree.first_p(base);
  locate_bodies(f.tree, f.state, f.workspace);
  const Kinematics<double>& k = f.workspace.bodies[static_cast<std::size_t>(base)];
  const Vec3 l{f.state.p()[static_cast<std::size_t>(at)], f.state.p()[static_cast<std::size_t>(at + 1)],
               f.state.p()[static_cast<std::size_t>(at + 2)]};
  const Vec3 weight = f.tree.subtree_mass(base) * transpose_times(k.R, f.tree.gravity());
  const Vec3 rate{f.workspace.pdot[static_cast<std::size_t>(at)], f.workspace.pdot[static_cast<std::size_t>(at + 1)],
                  f.workspace.pdot[static_cast<std::size_t>(at + 2)]};
  CHECK(norm(rate - (weight - cross(k.velocity.w, l))) < 1e-12);
}

TEST_CASE("damping, springs and efforts: forces and power") {
  Model model({.gravity = {}});
  const BodyId a = model.add({.name = "m/a",
                              .mass = 2,
                              .inertia = diagonal(0.5),
                              .joint = Revolute{.damping = 0.3, .stiffness = 4, .rest = 0.25, .effort = 0.7},
                              .q = 1.0,
                              .v = 2.0});
  model.add({.name = "m/b",
             .mass = 1,
             .inertia = diagonal(0.1),
             .parent = a,
             .at = {1, 0, 0},
             .joint = Cylindrical{.damping = {0.1, 0.2}, .effort = {0.0, 3.0}},
             .q = {0.0, 0.0},
             .v = {0.0, -1.5}});
  const Tree tree = compile(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  CHECK(workspace.power.dissipated == doctest::Approx(0.3 * 4 + 0.2 * 2.25).epsilon(1e-14));
  CHECK(workspace.power.work == doctest::Approx(0.7 * 2 - 3 * 1.5).epsilon(1e-14));
  CHECK(workspace.pdot[0] == doctest::Approx(0.7 - 0.3 * 2 - 4 * 0.75).epsilon(1e-13));
  double force[6];
  CHECK(joint_spring(tree, state.q().data(), 0, force) == doctest::Approx(0.5 * 4 * 0.75 * 0.75).epsilon(1e-14));
  CHECK(joint_energy(tree, state, workspace, 0) == doctest::Approx(0.5 * 4 * 0.75 * 0.75).epsilon(1e-14));
}

TEST_CASE("stamps: results evaluated at one state are not used for another") {
  Fixture f;
  CHECK(f.workspace.evaluated == f.state.stamp());
  State copy = f.state;
  CHECK(f.workspace.evaluated != copy.stamp());
  static_cast<void>(f.state.edit());
  CHECK(f.workspace.evaluated != f.state.stamp());
  forward_dynamics(f.tree, f.state, f.workspace);
  CHECK(f.workspace.evaluated == f.state.stamp());
  evaluate_rates(f.tree, f.state.q().data(), f.state.p().data(), f.workspace);  // a stage, which belongs to no state
  CHECK(f.workspace.evaluated != f.state.stamp());
}
