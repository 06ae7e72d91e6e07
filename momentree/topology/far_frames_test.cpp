// The frame in which the user describes a body has no influence on the motion: floating mechanisms whose frames are far from the
// centres of mass, against the same mechanisms with frames near them, through every change that a floating mechanism takes part
// in.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/test_support.hpp>
#include <momentree/topology/velocities.hpp>

namespace momentree {
namespace {

using namespace test;

Quat any_rotation(Random& random) {
  const Vec3 e = random.vector(2);
  return normalized(Quat{1, e.x, e.y, e.z});
}
Pose any_pose(Random& random, double size) {
  const Vec3 r = random.vector(size);
  return {r, any_rotation(random)};
}

JointSpec any_joint_on(Random& random) {
  switch (random.below(6)) {
    case 0: return Prismatic{.axis = {0.6, 0, 0.8}};
    case 1: return Ball{};
    case 2: return Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}};
    case 3: return Free{};
    case 4: return Weld{};
    default: return Revolute{.axis = {0, 0.6, 0.8}};
  }
}

/// The same bodies twice: `far` is `near` with the frame of body k at frames[k] of its frame there.
struct Twins {
  Model near, far;
  std::vector<Pose> frames;

  Twins(Random& random, double distance) : near({.gravity = random.vector(10)}), far({.gravity = near.gravity()}) {
    const int bodies = 2 + random.below(7), mechanisms = 1 + random.below(3);
    for (int k = 0; k < bodies; ++k) {
      BodySpec body{.name = "b" + std::to_string(k), .mass = random.between(0.5, 2)};
      body.com = random.vector(0.2);
      body.inertia = diagonal(random.between(0.06, 0.1), random.between(0.06, 0.1), random.between(0.06, 0.1));
      const int outer = k < mechanisms ? -1 : random.below(k);
      body.parent = outer < 0 ? ground : BodyId{outer};
      body.at = any_pose(random, 0.4), body.child_at = any_pose(random, 0.3);
      body.joint = outer < 0 ? JointSpec(Free{}) : any_joint_on(random);
      near.add(body);
      frames.push_back(any_pose(random, distance));
      const Pose back = inverse(frames.back());
      body.com = back.position + rotation_matrix(back.rotation) * body.com;
      body.inertia = rotate(rotation_matrix(back.rotation), body.inertia);
      body.child_at = back * body.child_at;
      if (outer >= 0) body.at = inverse(frames[static_cast<std::size_t>(outer)]) * body.at;
      far.add(body);
    }
  }
};

struct Side {
  Tree tree;
  State state;
  Workspace<double> workspace;
  Side(const Model& model, Variables variables) : tree(compile(model)), state(tree, variables), workspace(tree) {}
  void evaluate() { forward_dynamics(tree, state, workspace); }
  Pose pose(int b) { return user_pose(tree, locate_body(tree, state, workspace, b), b); }
  template <class Change>
  void change(const Change& what) {
    evaluate();
    apply(what, tree, state, workspace);
  }
};

/// Positions and velocities of the centres of mass, and angular velocities, of all bodies.
std::vector<double> motion(Side& world, const Model& model) {
  world.evaluate();
  std::vector<double> all;
  for (const int b : world.tree.order()) {
    const Pose at = world.pose(b);
    const Mat3 R = rotation_matrix(at.rotation);
    const Vec3 c = model[BodyId{b}].com;
    const Motion<double> m = user_velocity(world.tree, world.workspace, b);
    for (const Vec3& x : {at.position + R * c, R * (m.v + cross(m.w, c)), R * m.w}) all.insert(all.end(), {x.x, x.y, x.z});
  }
  return all;
}

}  // namespace

TEST_CASE("floating mechanisms move alike wherever the frames of their bodies are, through every change") {
  constexpr double distance = 30;
  int changes[5] = {};
  double worst = 0;
  for (const Variables variables : {Variables::momenta, Variables::velocities})
    for (unsigned seed = 0; seed < 300; ++seed) {
      CAPTURE(seed);
      Random random(seed);
      const Twins twins(random, distance);
      Side near(twins.near, variables), far(twins.far, variables);
      {  // The coordinates of a model's joints are the same: its joints are at the same places.
        std::vector<double> q(near.state.q().begin(), near.state.q().end()), u(near.state.y().size()), p(u.size());
        for (const int b : near.tree.order()) {
          double* const x = q.data() + near.tree.first_q(b);
          const KindInfo& kind = info(near.tree.kind(b));
          if (kind.nq == kind.nv)
            for (int i = 0; i < kind.nq; ++i) x[i] = random.between(-1, 1);
        }
        for (double& x : u) x = random.between(-1, 1);
        project_momentum(near.tree, q.data(), u.data(), p.data());
        for (Side* world : {&near, &far}) {
          const State::Edit edit = world->state.edit();
          std::copy(q.begin(), q.end(), edit.q.begin());
          const std::vector<double>& y = variables == Variables::momenta ? p : u;
          std::copy(y.begin(), y.end(), edit.y.begin());
        }
      }
      const auto check = [&] {
        const std::vector<double> a = motion(near, twins.near), b = motion(far, twins.far);
        REQUIRE(a.size() == b.size());
        double most = 0;
        for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::fabs(a[i] - b[i]));
        worst = std::max(worst, most);
        CHECK(most < 1e-9);
      };
      check();
      for (int k = 0; k < 6; ++k) {
        const int b = random.below(near.tree.bodies()), to = random.below(near.tree.bodies());
        const JointId joint = near.tree.inboard_joint({b});
        const auto both = [&](const auto& of_near, const auto& of_far, int which) {
          near.change(of_near), far.change(of_far);
          ++changes[which];
        };
        const int which = random.below(5);
        const bool floating = floats(near.tree, {b}), apart = root_of(near.tree, {b}).index != root_of(near.tree, {to}).index;
        if (which == 0 && can_break(near.tree, joint)) {
          both(Break{joint}, Break{joint}, 0);
        } else if (which == 1 && floating && near.tree.parent(b) >= 0) {
          both(Reroot{{b}}, Reroot{{b}}, 1);
        } else if (which == 2 && floating && apart) {
          both(Join{{b}, {to}}, Join{{b}, {to}}, 2);
        } else if (which == 3 && floating && apart) {  // a capture by a ball joint between their present places
          near.evaluate(), far.evaluate();
          Attach a{{b}, {to}, {}, {}}, c{{b}, {to}, {}, {}};
          a.joint.kind = c.joint.kind = Kind::ball;
          a.joint.at = inverse(near.pose(to)) * near.pose(b), c.joint.at = inverse(far.pose(to)) * far.pose(b);
          // The joint is at the same place of the body.
          const Pose place = inverse(twins.frames[static_cast<std::size_t>(b)]);
          c.joint.at = c.joint.at * place, c.joint.child_at = place;
          a.q = c.q = joint_zero(Kind::ball);
          both(a, c, 3);
        } else if (which == 4 && near.tree.joint(b).locked == 0 && info(near.tree.joint(b).kind).nv == 6 &&
                   near.tree.parent(b) < 0 && random.chance(0.3)) {
          // Its rotation: the frame is the origin of its displacement.
          both(Lock{joint, 56}, Lock{joint, 56}, 4);
          check();
          both(Unlock{joint, 56}, Unlock{joint, 56}, 4);
        } else {
          continue;
        }
        check();
      }
    }
  MESSAGE("largest difference ", worst);
  for (const int many : changes) CHECK(many > 30);
}

}  // namespace momentree
