// What loop joints share with joints of the tree: prescribed motions, armatures, locks. One ring of bodies is built twice, with
// another of its joints as the loop joint: both must move in the same way.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/joint/motion.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

constexpr Integration fine{.method = "dop853", .rtol = 1e-12, .atol = 1e-13};
constexpr Integration fine_in_momenta{.method = "dop853", .variables = Variables::momenta, .rtol = 1e-12, .atol = 1e-13};

// A ring from the ground to the ground: bodies 0 … n − 1, joints 0 … n; joint k has the child k (the last one: n − 1) and the
// parent k − 1 (the ground for the first and the last one). The joints between bodies are revolute.
struct Ring {
  std::vector<BodySpec> bodies;
  struct Joint {
    JointSpec spec;
    Pose at, child_at;
    Values q, v;
  };
  std::vector<Joint> joints;
  Vec3 gravity{0, 0, -9.81};

  int size() const { return static_cast<int>(bodies.size()); }

  // Open at the last joint.
  Model tree() const {
    Model model({.gravity = gravity});
    for (int k = 0; k < size(); ++k) {
      const Joint& joint = joints[static_cast<std::size_t>(k)];
      model.add(body(k, k == 0 ? ground : BodyId{k - 1}, joint.spec, joint.at, joint.child_at, joint.q, joint.v, name(k)));
    }
    return model;
  }
  Model forward() const {
    Model model = tree();
    add_loop(model, BodyId{size() - 1}, joints.back(), name(size()));
    return model;
  }
  // The same in the other direction, open at the first joint; joints between bodies have their bodies exchanged.
  Model backward() const {
    Model model({.gravity = gravity});
    for (int i = 0; i < size(); ++i) {
      const int k = size() - 1 - i;
      if (i == 0) {
        const Joint& last = joints.back();
        model.add(body(k, ground, last.spec, last.at, last.child_at, last.q, last.v, name(size())));
        continue;
      }
      const Joint& joint = joints[static_cast<std::size_t>(k + 1)];
      model.add(
          body(k, BodyId{i - 1}, exchanged(joint.spec), joint.child_at, joint.at, {-joint.q[0]}, {-joint.v[0]}, name(k + 1)));
    }
    add_loop(model, BodyId{size() - 1}, joints.front(), name(0));
    return model;
  }

  static std::string name(int joint) { return "joint" + std::to_string(joint); }
  static std::string body_name(int k) { return "body" + std::to_string(k); }

 private:
  static JointSpec exchanged(JointSpec joint) {
    JointParameters& p = joint.parameters;
    if (!p.rest.empty()) p.rest = {-p.rest[0]};
    if (!p.effort.empty()) p.effort = {-p.effort[0]};
    if (p.drive != nullptr && p.drive->moves()) {  // only sines are used
      const Signal& s = p.drive->motion[0].signal();
      p.drive = motion_drive(Signal::sine(-s.amplitude(), s.frequency(), s.phase(), -s.offset()));
    }
    const Values lower = p.limits.lower, upper = p.limits.upper;
    if (!upper.empty()) p.limits.lower = {-upper[0]};
    if (!lower.empty()) p.limits.upper = {-lower[0]};
    return joint;
  }
  BodySpec body(int k, BodyId parent, const JointSpec& joint, const Pose& at, const Pose& child_at, const Values& q,
                const Values& v, const std::string& joint_name) const {
    BodySpec spec = bodies[static_cast<std::size_t>(k)];
    spec.name = body_name(k), spec.joint_name = joint_name;
    spec.parent = parent, spec.joint = joint, spec.at = at, spec.child_at = child_at, spec.q = q, spec.v = v;
    return spec;
  }
  static void add_loop(Model& model, BodyId body, const Joint& joint, const std::string& name) {
    LoopSpec loop;
    loop.name = name, loop.body = body, loop.to = ground;
    loop.joint = joint.spec, loop.at = joint.at, loop.child_at = joint.child_at;
    model.add_loop(loop);
  }
};

Pose random_pose(Prng& random, double size) {
  const Vec3 axis = random.direction();
  return {random.vector(size), from_axis_angle(axis, random.uniform(-1, 1))};
}

JointSpec joint_of_kind(Prng& random, Kind kind) {
  JointSpec joint;
  joint.kind = kind, joint.axis = random.direction(), joint.axis2 = random.direction(), joint.pitch = random.uniform(0.1, 0.5);
  return joint;
}

// Armature, damping and springs per DoF.
void give_parameters(Prng& random, JointSpec& joint, bool damped) {
  const KindInfo& kind = info(joint.kind);
  for (int i = 0; i < kind.nv; ++i) {
    joint.parameters.armature.push_back(random.chance(0.7) ? std::exp(random.uniform(-3, 2)) : 0.0);
    joint.parameters.stiffness.push_back(random.uniform(0, 3));
    if (damped) joint.parameters.damping.push_back(random.uniform(0, 0.3));
  }
}

// A ring that is closed at its start, with velocities that its joints allow.
Ring random_ring(std::uint64_t seed, Kind first, Kind last, int bodies, bool damped = true, bool moved = false) {
  Prng random(seed);
  Ring ring;
  for (int k = 0; k < bodies; ++k) {
    BodySpec body;
    body.mass = random.uniform(0.5, 3), body.com = random.vector(0.2);
    body.inertia = diagonal(random.uniform(0.05, 0.06), random.uniform(0.05, 0.06), random.uniform(0.05, 0.06));
    ring.bodies.push_back(body);
  }
  for (int k = 0; k <= bodies; ++k) {
    Ring::Joint joint;
    joint.spec = joint_of_kind(random, k == 0 ? first : k == bodies ? last : Kind::revolute);
    joint.at = random_pose(random, 0.6), joint.child_at = random_pose(random, 0.3);
    joint.q = random_coordinates(random, joint.spec.kind), joint.v = random_velocities(random, joint.spec.kind);
    give_parameters(random, joint.spec, damped);
    ring.joints.push_back(joint);
  }
  Ring::Joint& end = ring.joints.back();
  {
    const World open(ring.tree());
    const Pose pose = open.motions().back().pose;
    end.at = pose * end.child_at * inverse(joint_motion(end.spec, end.q.begin()));
  }
  if (moved) {
    const double here = end.q[0], amplitude = random.uniform(0.1, 0.3), phase = random.uniform(-1, 1);
    end.spec.parameters.drive = motion_drive(Signal::sine(amplitude, 0.5, phase, here - amplitude * std::sin(phase)));
  }
  const World closed(ring.forward(), Variables::velocities);
  const auto copy = [](Numbers from, Values& to) {
    to = {};
    for (const double x : from) to.push_back(x);
  };
  for (int k = 0; k <= bodies; ++k) {
    const JointView view = closed.joint({closed.find_joint(Ring::name(k))});
    Ring::Joint& joint = ring.joints[static_cast<std::size_t>(k)];
    copy(view.q, joint.q), copy(view.v, joint.v);
  }
  return ring;
}

double size_of(const Wrench& w) { return norm(w.force) + norm(w.torque); }

// Poses, motions, energies and what the joints at the ground transmit.
void compare(const World& one, const World& other, int joints, double tolerance) {
  CHECK(std::fabs(one.totals().kinetic - other.totals().kinetic) < tolerance * (1 + one.totals().kinetic));
  CHECK(std::fabs(one.totals().potential - other.totals().potential) < tolerance * (1 + std::fabs(one.totals().potential)));
  for (int k = 0; k + 1 < joints; ++k) {
    const auto a = static_cast<std::size_t>(one.model().body(Ring::body_name(k)).index),
               b = static_cast<std::size_t>(other.model().body(Ring::body_name(k)).index);
    const BodyMotion &m = one.motions()[a], &n = other.motions()[b];
    const BodyAcceleration &am = one.accelerations()[a], &an = other.accelerations()[b];
    CHECK(norm(m.pose.position - n.pose.position) < tolerance);
    CHECK(norm(m.linear - n.linear) + norm(m.angular - n.angular) < tolerance * (1 + norm(m.linear) + norm(m.angular)));
    CHECK(norm(am.linear - an.linear) + norm(am.angular - an.angular) <
          10 * tolerance * (1 + norm(am.linear) + norm(am.angular)));
  }
  for (const int k : {0, joints - 1}) {
    const JointId a{one.find_joint(Ring::name(k))}, b{other.find_joint(Ring::name(k))};
    const JointForces f = one.joint_forces(a), g = other.joint_forces(b);
    const double size = 1 + size_of(f.reaction) + size_of(f.pure);
    for (int i = 0; i < f.effort.size(); ++i)
      CHECK(std::fabs(f.effort[i] - g.effort[i]) < 10 * tolerance * (size + std::fabs(f.effort[i])));
    CHECK(f.determined == g.determined);
    if (!f.determined) continue;
    CHECK(norm(f.reaction.force - g.reaction.force) + norm(f.reaction.torque - g.reaction.torque) < 10 * tolerance * size);
    CHECK(norm(f.pure.force - g.pure.force) + norm(f.pure.torque - g.pure.torque) < 10 * tolerance * size);
  }
}

double balance_error(const Simulation& sim) {
  const EnergyBalance b = sim.energy();
  return std::fabs(b.error) / (1 + b.largest_kinetic + std::fabs(b.work));
}

const std::vector<Kind> kinds{Kind::revolute,  Kind::prismatic, Kind::helical, Kind::cylindrical,
                              Kind::universal, Kind::ball,      Kind::planar};

}  // namespace

TEST_CASE("loop joints: armatures act as those of the tree, for any choice of the joint that closes the loop") {
  int moving = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    CAPTURE(seed);
    const Kind first = kinds[seed % 7], last = kinds[seed / 7 % 7];
    const int bodies = std::max(3, 7 - info(first).nv - info(last).nv + 1);
    const Ring ring = random_ring(seed, first, last, bodies);
    Simulation one(ring.forward(), fine), other(ring.backward(), fine);
    compare(one.world(), other.world(), bodies + 1, 1e-10);
    if (seed % 5 != 0) continue;
    if (!one.run_until(0.2) || !other.run_until(0.2)) continue;
    ++moving;
    compare(one.world(), other.world(), bodies + 1, 1e-8);
    CHECK(balance_error(one) < 1e-8);
  }
  CHECK(moving > 80);
}

TEST_CASE("loop joints: prescribed motions act as those of the tree") {
  int moving = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    const Kind first = kinds[seed % 7], last = kinds[seed / 7 % 3];
    const int bodies = std::max(4, 7 - info(first).nv + 1);
    const Ring ring = random_ring(seed, first, last, bodies, true, true);
    Simulation one(ring.forward(), fine), other(ring.backward(), fine);
    CHECK(one.world().joint(one.world().loops()[0]).driven);
    compare(one.world(), other.world(), bodies + 1, 1e-10);
    if (seed % 5 != 0) continue;
    if (!one.run_until(0.2) || !other.run_until(0.2)) continue;
    ++moving;
    compare(one.world(), other.world(), bodies + 1, 1e-8);
    CHECK(balance_error(one) < 1e-8);
    CHECK(std::fabs(one.energy().work - other.energy().work) < 1e-7 * (1 + std::fabs(one.energy().work)));
    // A lock suspends the motion, and breaking the first joint makes the loop joint one of the tree, which follows its motion.
    const std::string closing = Ring::name(bodies);
    const double before = one.world().joint({one.world().find_joint(closing)}).q[0];
    for (Simulation* sim : {&one, &other}) sim->apply(break_joint(Ring::name(0)), "cut");
    CHECK(one.world().loops().empty());
    CHECK(one.world().joint({one.world().find_joint(closing)}).q[0] == doctest::Approx(before).epsilon(1e-12));
    CHECK(std::fabs(one.events().back().lost) < 1e-9 * (1 + one.events().back().before.kinetic));
    CHECK(std::fabs(one.world().totals().kinetic - other.world().totals().kinetic) < 1e-7 * (1 + one.world().totals().kinetic));
    if (!one.run_until(0.3) || !other.run_until(0.3)) continue;
    CHECK(std::fabs(one.world().totals().kinetic - other.world().totals().kinetic) < 1e-6 * (1 + one.world().totals().kinetic));
  }
  CHECK(moving > 40);
}

TEST_CASE("loop joints: locks, also of some DoFs, and impacts with armatures act as those of the tree, also in momenta") {
  int moving = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 77);
    const Kind first = kinds[seed % 7], last = kinds[seed / 7 % 7];
    const int nv = info(last).nv, bodies = std::max(3, 9 - info(first).nv);
    Ring ring = random_ring(seed, first, last, bodies);
    const bool momenta = seed % 2 == 1;
    if (momenta) ring.joints.back().spec.parameters.armature = {};
    Simulation one(ring.forward(), momenta ? fine_in_momenta : fine), other(ring.backward(), fine);
    const std::string end = Ring::name(bodies);
    std::vector<int> dofs{random.integer(0, nv - 1)};
    if (nv > 1 && random.chance(0.3)) dofs.push_back((dofs[0] + 1) % nv);
    for (Simulation* sim : {&one, &other}) sim->apply(lock(end, dofs), "jam");
    const Event &e = one.events().back(), &f = other.events().back();
    CHECK(std::fabs(e.lost - f.lost) < 1e-9 * (1 + e.before.kinetic));
    CHECK(std::fabs(e.released - f.released) < 1e-9 * (1 + e.before.kinetic));
    compare(one.world(), other.world(), bodies + 1, 1e-9);
    if (seed % 5 != 0) continue;
    if (!one.run_until(0.2) || !other.run_until(0.2)) continue;
    ++moving;
    compare(one.world(), other.world(), bodies + 1, 1e-8);
    for (Simulation* sim : {&one, &other}) sim->apply(unlock(end, dofs), "free");
    compare(one.world(), other.world(), bodies + 1, 1e-8);
    CHECK(balance_error(one) < 1e-8);
  }
  CHECK(moving > 80);
}

TEST_CASE("loop joints: hard stops act as those of the tree, also in momenta") {
  int hit = 0, rested = 0, moving = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 99);
    const Kind first = kinds[seed % 4];  // some turn far: the second angle of a universal loop joint does not count full turns
    const Kind last =
        std::vector<Kind>{Kind::revolute, Kind::prismatic, Kind::helical, Kind::cylindrical, Kind::planar}[seed % 5];
    const int nv = info(last).nv, bodies = std::max(3, 8 - info(first).nv - nv);
    Ring ring = random_ring(seed, first, last, bodies);
    Ring::Joint& end = ring.joints.back();
    JointLimits& limits = end.spec.parameters.limits;
    for (int i = 0; i < nv; ++i) {
      const double q = end.q[i];
      limits.lower.push_back(q - random.uniform(0.01, 0.2)), limits.upper.push_back(q + random.uniform(0.01, 0.2));
      limits.restitution.push_back(random.chance(0.5) ? 0.0 : random.uniform(0, 0.8));
    }
    const bool momenta = seed % 2 == 1;
    if (momenta) end.spec.parameters.armature = {};
    Simulation one(ring.forward(), momenta ? fine_in_momenta : fine), other(ring.backward(), fine);
    if (!one.run_until(0.4) || !other.run_until(0.4)) continue;
    ++moving;
    const std::vector<Event>&e = one.events(), &f = other.events();
    REQUIRE(e.size() == f.size());
    for (std::size_t i = 0; i < e.size(); ++i) {
      CHECK(std::fabs(e[i].time - f[i].time) < 1e-7);
      CHECK(e[i].actions[0].kind == f[i].actions[0].kind);
      CHECK(std::fabs(e[i].lost - f[i].lost) < 1e-6 * (1 + e[i].before.kinetic));
      CHECK(e[i].lost > -1e-9 * (1 + e[i].before.kinetic));
      hit += e[i].actions[0].kind == "hit" ? 1 : 0, rested += e[i].actions[0].kind == "rest" ? 1 : 0;
    }
    compare(one.world(), other.world(), bodies + 1, 1e-6);
    CHECK(balance_error(one) < 1e-7);
    const JointView view = one.world().joint({one.world().find_joint(Ring::name(bodies))});
    for (int i = 0; i < nv; ++i) {
      CHECK(view.q[static_cast<std::size_t>(i)] > limits.lower[i] - 1e-9);
      CHECK(view.q[static_cast<std::size_t>(i)] < limits.upper[i] + 1e-9);
    }
  }
  CHECK(moving > 100);
  CHECK(hit > 50);
  CHECK(rested > 20);
}
