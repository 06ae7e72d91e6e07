// Every change of a state in velocities against the same change of a state in momenta, on random mechanisms, and the accuracy
// that velocities keep in long chains.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/snapshot.hpp>
#include <momentree/topology/test_support.hpp>
#include <momentree/topology/velocities.hpp>

namespace momentree {
namespace {

using namespace test;

JointSpec any_joint(Random& random) {
  const Values armature{random.chance(0.3) ? random.between(0.01, 0.1) : 0.0};
  switch (random.below(9)) {
    case 0: return Prismatic{.axis = {0.2, 0.4, 1}, .armature = armature};
    case 1: return Helical{.axis = {0, 1, 0.3}, .pitch = 0.2};
    case 2: return Cylindrical{.axis = {1, 0, 0.1}};
    case 3: return Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}, .armature = {0.02, armature[0]}};
    case 4: return Ball{};
    case 5: return Planar{};
    case 6: return Free{};
    default: return Revolute{.axis = {0.3, 0, 1}, .armature = armature};
  }
}

Model any_model(Random& random) {
  Model model({.gravity = random.vector(10)});
  const int bodies = 2 + random.below(10);
  for (int k = 0; k < bodies; ++k) {
    BodySpec body{.name = "b" + std::to_string(k), .mass = random.between(0.5, 2)};
    body.com = random.vector(0.2);
    body.inertia = diagonal(random.between(0.06, 0.1), random.between(0.06, 0.1), random.between(0.06, 0.1));
    const int outer = random.below(k + 1) - 1;
    body.parent = outer < 0 ? ground : BodyId{outer};
    body.at = random_place(random);
    body.joint = outer < 0 && random.chance(0.5) ? JointSpec(Free{}) : any_joint(random);
    model.add(body);
  }
  return model;
}

struct Side {
  Tree tree;
  State state;
  Workspace<double> workspace;

  Side(const Model& model, Variables variables) : tree(compile(model)), state(tree, variables), workspace(tree) {}
  void evaluate() { forward_dynamics(tree, state, workspace); }
  template <class Change>
  double change(const Change& what) {
    evaluate();
    if constexpr (std::is_same_v<Change, Impact>)
      return apply(what, tree, state, workspace);
    else
      return apply(what, tree, state, workspace).energy;
  }
};

enum Which { broken, rerooted, locked, unlocked, changed, freed, pushed, hit, set, joined, attached, removed, kinds_of_change };

/// Applies one random change to both sides; returns which, or nothing if the one drawn is impossible.
std::optional<Which> change_both(Side& p, Side& u, Random& random) {
  const Tree& tree = p.tree;
  const int b = random.below(tree.bodies());
  if (!tree.alive(b)) return {};
  const JointId joint = tree.inboard_joint({b});
  const KindInfo& kind = info(tree.joint(b).kind);
  double released[2] = {};
  const auto both = [&](const auto& change) { released[0] = p.change(change), released[1] = u.change(change); };
  const auto done = [&](Which which) {
    CHECK(released[0] == doctest::Approx(released[1]).epsilon(1e-7));
    return std::optional(which);
  };
  const auto replaced = [&](JointSpec to) {
    ChangeJoint change;
    change.joint = joint;
    change.to.kind = to.kind, change.to.axis = normalized(to.axis), change.to.axis2 = normalized(to.axis2),
    change.to.pitch = to.pitch;
    p.evaluate();
    Pose pose = user_pose(tree, locate_body(tree, p.state, p.workspace, b), b);
    if (tree.parent(b) >= 0)
      pose = inverse(user_pose(tree, locate_body(tree, p.state, p.workspace, tree.parent(b)), tree.parent(b))) * pose;
    change.to.at = pose, change.direction = ChangeJoint::Direction::declared;
    change.q = joint_zero(to.kind);
    both(change);
  };
  switch (random.below(kinds_of_change)) {
    case broken:
      if (!can_break(tree, joint)) return {};
      both(Break{joint});
      return done(broken);
    case rerooted:
      if (!floats(tree, {b}) || tree.parent(b) < 0) return {};
      both(Reroot{{b}});
      return done(rerooted);
    case locked:
      if (kind.nv == 0 || tree.joint(b).locked != 0) return {};
      both(Lock{joint, static_cast<unsigned>(1 + random.below(7))});
      return done(locked);
    case unlocked:
      if (tree.joint(b).locked == 0) return {};
      both(Unlock{joint});
      return done(unlocked);
    case changed: replaced(any_joint(random)); return done(changed);
    case freed: replaced(Free{}); return done(freed);
    case pushed: both(Impulse{{b}, random.vector(1), random.vector(1), random.vector(0.3)}); return done(pushed);
    case hit: {
      const int dof = random.below(std::max(kind.nv, 1));
      if (kind.nv == 0 || (tree.link(b).locked >> dof & 1u) != 0) return {};
      both(Impact{joint, dof, random.between(0, 1)});
      return done(hit);
    }
    case set: {
      if (kind.kind != Kind::revolute && kind.kind != Kind::prismatic) return {};
      JointParameters parameters;
      parameters.armature = {random.between(0.01, 0.2)};
      if (random.chance(0.4) && tree.joint(b).locked == 0) {
        const double q = p.state.q()[static_cast<std::size_t>(tree.first_q(b))];
        parameters.drive = motion_drive(Signal::ramp(random.between(-1, 1), q));
      }
      both(SetParameters{joint, parameters});
      return done(set);
    }
    case joined:
    case attached: {
      const int to = random.below(tree.bodies() + 1) - 1;
      if (!floats(tree, {b}) || (to >= 0 && (!tree.alive(to) || root_of(tree, {to}).index == root_of(tree, {b}).index)))
        return {};
      if (random.chance(0.3)) {
        both(Join{{b}, {to}});
        return done(joined);
      }
      p.evaluate();
      Pose pose = user_pose(tree, locate_body(tree, p.state, p.workspace, b), b);
      if (to >= 0) pose = inverse(user_pose(tree, locate_body(tree, p.state, p.workspace, to), to)) * pose;
      Joint made;
      const JointSpec spec = any_joint(random);
      made.kind = spec.kind, made.axis = normalized(spec.axis), made.axis2 = normalized(spec.axis2), made.pitch = spec.pitch;
      made.at = pose;
      both(Attach{{b}, {to}, made, joint_zero(spec.kind)});
      return done(attached);
    }
    default:
      if (!floats(tree, {b}) || tree.parent(b) >= 0 || !random.chance(0.2)) return {};
      both(Remove{{b}});
      return done(removed);
  }
}

}  // namespace

TEST_CASE("velocities: every change equals that in momenta") {
  Random random(31);
  std::array<int, kinds_of_change> seen{};
  double worst = 0;
  for (int round = 0; round < 3000; ++round) {
    CAPTURE(round);
    const Model model = any_model(random);
    Side p(model, Variables::momenta), u(model, Variables::velocities);
    put_at_random(p.tree, p.state, random);
    p.evaluate();
    u.state.assign(0, p.state.q(), {p.workspace.v.get(), static_cast<std::size_t>(p.tree.nv())}, u.tree);
    std::string what;
    for (int k = 0; k < 6; ++k) {
      const std::optional<Which> which = change_both(p, u, random);
      if (!which) continue;
      ++seen[static_cast<std::size_t>(*which)];
      what += std::to_string(*which) + ' ';
      CAPTURE(what);
      p.evaluate(), u.evaluate();
      CHECK(difference(p.state.q().data(), u.state.q().data(), p.tree.nq()) <= 1e-12);
      const double off = difference(p.workspace.v.get(), u.state.u().data(), p.tree.nv());
      worst = std::max(worst, off);
      REQUIRE(off <= 1e-8);
      // The two have gone on with different round-off: begin the next change from the same motion.
      u.state.assign(0, p.state.q(), {p.workspace.v.get(), static_cast<std::size_t>(p.tree.nv())}, u.tree);
    }
  }
  MESSAGE("largest difference of velocities ", worst);
  for (std::size_t i = 0; i < seen.size(); ++i) CHECK_MESSAGE(seen[i] > 30, "change ", i, ": ", seen[i]);
}

namespace {

/// What is missing in the velocities of `after`, to first order: the velocities that would give every body the momentum that it
/// had before and does not have now. `before`: momenta of the bodies in user frames.
double missing(Side& after, const std::vector<Force<double>>& before) {
  after.evaluate();
  Tree& tree = after.tree;
  Workspace<double> other(tree);
  for (const int b : tree.order()) {
    const auto i = static_cast<std::size_t>(b);
    const Force<double> now = momentum(tree.link(b).body, after.workspace.motions[i].velocity);
    other.carried[i] = to_kernel_frame(tree.frame(b), before[i]) - now;
  }
  std::vector<double> u(static_cast<std::size_t>(tree.nv()));
  project_velocities(tree, after.state.q().data(), u.data(), other);
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    worst = std::max(worst, std::fabs(u[i]));
    largest = std::max(largest, std::fabs(after.workspace.v[i]));
  }
  return worst / largest;
}

}  // namespace

TEST_CASE("velocities: a lock in a chain of 1000 links loses few digits, in momenta it loses many") {
  Model model({.gravity = {0, -9.81, 0}});
  constexpr int links = 1000;
  for (int k = 0; k < links; ++k)
    model.add({.name = "b" + std::to_string(k),
               .mass = 0.01,
               .com = {0.025, 0, 0},
               .inertia = diagonal(1e-7, 2.083e-6, 2.083e-6),
               .parent = k == 0 ? ground : BodyId{k - 1},
               .at = {{k == 0 ? 0.0 : 0.05, 0, 0}, Quat{}},
               .joint = Revolute{}});
  Side p(model, Variables::momenta), u(model, Variables::velocities);
  {
    const State::Edit edit = u.state.edit(), other = p.state.edit();
    for (std::size_t i = 0; i < links; ++i) {
      edit.q[i] = other.q[i] = 0.001 * std::sin(0.7 * static_cast<double>(i));
      edit.u[i] = std::sin(1.3 * static_cast<double>(i));
    }
  }
  u.evaluate();
  std::vector<Force<double>> before;
  for (int b = 0; b < links; ++b) {
    const auto i = static_cast<std::size_t>(b);
    before.push_back(to_user_frame(u.tree.frame(b), momentum(u.tree.link(b).body, u.workspace.motions[i].velocity)));
  }
  {
    const State::Edit edit = p.state.edit();
    project_momentum(p.tree, edit.q.data(), u.state.u().data(), edit.p.data());
  }
  p.change(Lock{{400}}), u.change(Lock{{400}});
  CHECK(missing(u, before) < 1e-10);
  CHECK(missing(p, before) > 1e-8);
}

}  // namespace momentree
