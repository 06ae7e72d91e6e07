// Velocities as the state against momenta as the state: both describe the same motion, so all results of an evaluation are equal.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/test_support.hpp>

namespace momentree {
namespace {

using namespace test;

constexpr double bound = 1e-11;

JointSpec any_joint(Random& random) {
  const Values damping{random.between(0, 1)}, armature{random.chance(0.3) ? random.between(0.01, 0.1) : 0.0};
  switch (random.below(12)) {
    case 0: return Prismatic{.axis = {0.2, 0.4, 1}, .damping = damping, .armature = armature};
    case 1: return Helical{.axis = {0, 1, 0.3}, .pitch = 0.2, .stiffness = {3.0}};
    case 2: return Cylindrical{.axis = {1, 0, 0.1}, .damping = {0.1, 0.4}};
    case 3: return Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}, .armature = {0.02, armature[0]}};
    case 4: return Ball{.damping = {0.1, 0.2, 0.3}};
    case 5: return Planar{};
    case 6: return Free{};
    case 7: return Weld{};
    case 8: return Revolute{.axis = {0.3, 0, 1}, .armature = {0.05}, .friction = {.coulomb = {0.4}, .speed = {0.1}}};
    default: return Revolute{.damping = damping, .stiffness = {2.0}, .armature = armature};
  }
}

Model any_model(Random& random) {
  Model model({.gravity = random.vector(10)});
  const int bodies = 1 + random.below(14);
  const bool flat = random.chance(0.2), chain = random.chance(0.5);
  for (int k = 0; k < bodies; ++k) {
    BodySpec body{.name = "b" + std::to_string(k), .mass = random.between(0.5, 2)};
    body.com = random.vector(0.2);
    body.inertia = diagonal(random.between(0.06, 0.1), random.between(0.06, 0.1), random.between(0.06, 0.1));
    const int outer = chain ? k - 1 : random.below(k + 1) - 1;
    body.parent = outer < 0 ? ground : BodyId{outer};
    body.at = random_place(random);
    if (flat) body.at = {random.vector(0.4), outer < 0 ? body.at.rotation : from_axis_angle(z_axis, random.between(-1, 1))};
    body.joint = flat                           ? JointSpec(Revolute{.damping = {0.3}})
                 : k == 0 && random.chance(0.3) ? JointSpec(Free{})
                                                : any_joint(random);
    model.add(body);
  }
  if (random.chance(0.3)) {
    BodyForce force{.body = {random.below(bodies)}, .force = {Signal(1.0), Signal(2.0), Signal(-1.0)}};
    force.drag.linear = 0.3;
    model.add_force(force);
  }
  return model;
}

/// Breaks, re-roots or locks a joint.
void change(Tree& tree, State& state, Workspace<double>& workspace, Random& random) {
  if (random.chance(0.6)) return change_at_random(tree, state, workspace, random, 0.5);
  forward_dynamics(tree, state, workspace);
  apply(Lock{{random.below(tree.bodies())}, static_cast<unsigned>(1 + random.below(7))}, tree, state, workspace);
}

}  // namespace

TEST_CASE("velocities: an evaluation equals that of the same motion in momenta") {
  Random random(23);
  double stage = 0, accelerations = 0, momenta = 0, rates = 0, wrenches = 0;
  for (int round = 0; round < 3000; ++round) {
    const Model model = any_model(random);
    Tree tree = compile(model);
    State p(tree);
    Workspace<double> one(tree), other(tree);
    for (int k = random.below(4); k > 0; --k) change(tree, p, one, random);
    put_at_random(tree, p, random);
    for (const int b : tree.order())
      for (int i = 0; i < info(tree.kind(b)).nv; ++i)
        if ((tree.link(b).locked >> i & 1u) != 0) p.edit().p[static_cast<std::size_t>(tree.first_p(b) + i)] = 0;
    forward_dynamics(tree, p, one);
    accelerate(tree, p, one);
    State u(tree, Variables::velocities);
    u.assign(p.time(), p.q(), {one.v.get(), static_cast<std::size_t>(tree.nv())}, tree);
    const int nv = tree.nv(), nq = tree.nq();
    accelerate(tree, u, other);
    CHECK(other.evaluated == u.stamp());
    accelerations = std::max(accelerations, difference(one.a.get(), other.a.get(), nv));
    momenta = std::max(momenta, difference(p.p().data(), other.p.get(), nv));
    find_momentum_rates(tree, u, other);
    rates = std::max({rates, difference(one.pdot.get(), other.pdot.get(), nv), difference(one.qdot.get(), other.qdot.get(), nq)});
    std::vector<Force<double>> x, y;  // those of free joints are zero
    for (const int b : tree.order()) {
      x.push_back(transmitted_wrench(tree, one, b)), y.push_back(transmitted_wrench(tree, other, b));
      const Force<double> P = articulated_momentum(tree, p, one, b), Q = articulated_momentum(tree, u, other, b);
      momenta = std::max(momenta, difference(&P.l.x, &Q.l.x, 6));
    }
    wrenches = std::max(wrenches, difference(&x.front().l.x, &y.front().l.x, 6 * tree.bodies()));
    CHECK(other.power.dissipated == doctest::Approx(one.power.dissipated).epsilon(1e-9));
    CHECK(other.power.work == doctest::Approx(one.power.work).epsilon(1e-9));
    poison(tree, other);
    evaluate_velocity_stage(tree, u.time(), u.q().data(), u.u().data(), other);
    stage = std::max(stage, difference(one.a.get(), other.a.get(), nv));
    CHECK(difference(one.qdot.get(), other.qdot.get(), nq) <= bound);
    std::string kinds;
    for (const int b : tree.order())
      kinds += std::string(info(tree.kind(b)).name) + (tree.reversed(b) ? "~" : "") + (tree.link(b).locked ? "!" : "") + "<" +
               std::to_string(tree.parent(b)) + " ";
    CAPTURE(stage);
    CAPTURE(accelerations);
    CAPTURE(momenta);
    CAPTURE(rates);
    CAPTURE(wrenches);
    CAPTURE(round);
    CAPTURE(kinds);

    REQUIRE(std::max({stage, accelerations, momenta, rates}) <= bound);
  }
  MESSAGE("stage ", stage, ", accelerations ", accelerations, ", momenta ", momenta, ", rates ", rates, ", wrenches ", wrenches);
  CHECK(wrenches <= 1e-10);
}

}  // namespace momentree
