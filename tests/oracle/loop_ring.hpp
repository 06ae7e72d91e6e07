#pragma once
// Rings of bodies, each of whose joints can be the one that closes the loop: for the laws of loop joints. A joint under test is a
// loop joint in one world and a joint of the tree in another; both worlds must obey the laws of mechanics, and agree.
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/loop_rows.hpp>

namespace momentree::oracle {

inline std::vector<Kind> loop_kinds() {
  std::vector<Kind> kinds;
  for (const KindInfo& kind : all_kinds())
    if (kind.kind != Kind::free) kinds.push_back(kind.kind);
  return kinds;
}

/// Bodies 0 … n − 1 between two places of a base: the ground, or a body that floats. Joint k, of 0 … n, has the child k (the last
/// one: n − 1) and the parent k − 1 (the first and the last one: the base).
struct Ring {
  struct Joint {
    JointSpec spec;
    Pose at, child_at;
    Values q, v;
  };
  std::vector<BodySpec> bodies;
  std::vector<Joint> joints;
  std::optional<BodySpec> base;  ///< floats; none: the ground
  Vec3 gravity{0, 0, -9.81};
  int tested = 0, other = 0;  ///< the joint under test, and the one that closes the loop when the former is in the tree

  struct Coupled {
    int joint, follows;
    double multiplier;
  };
  std::optional<Coupled> coupling;  ///< of joints that are in both trees

  int size() const { return static_cast<int>(bodies.size()); }
  static std::string name(int joint) { return "joint" + std::to_string(joint); }
  static std::string body_name(int body) { return "body" + std::to_string(body); }
  std::string under_test() const { return name(tested); }
  Joint& joint_under_test() { return joints[static_cast<std::size_t>(tested)]; }

  /// The ring with the loop closed by joint `open`, or open there. Joints beyond it carry the bodies on their other side.
  Model open_at(int open, bool closed = true) const {
    Model model({.gravity = gravity});
    const BodyId start = base ? model.add(*base) : ground;
    BodyId left = start, right = start;
    for (int k = 0; k < std::min(open, size()); ++k) left = model.add(body(k, left, k, joint(k)));
    for (int k = size() - 1; k >= open; --k)
      right = model.add(body(k, right, k + 1, k + 1 == size() ? joint(k + 1) : exchanged(joint(k + 1))));
    if (coupling && closed) {
      const double s = sign(coupling->joint, open), t = sign(coupling->follows, open);
      const double offset = joint(coupling->joint).q[0] - coupling->multiplier * joint(coupling->follows).q[0];
      model.add_coupling({.joint = model.joint(name(coupling->joint)),
                          .follows = model.joint(name(coupling->follows)),
                          .multiplier = s * t * coupling->multiplier,
                          .offset = s * offset});
    }
    if (!closed) return model;
    LoopSpec loop;
    loop.name = name(open);
    loop.body = open == size() ? left : right, loop.to = open == size() ? start : left;
    loop.joint = joint(open).spec, loop.at = joint(open).at, loop.child_at = joint(open).child_at;
    model.add_loop(loop);
    return model;
  }
  Model as_loop() const { return open_at(tested); }
  Model as_tree() const { return open_at(other); }

 private:
  const Joint& joint(int k) const { return joints[static_cast<std::size_t>(k)]; }
  bool is_exchanged(int k, int open) const { return k > open && k < size(); }
  double sign(int k, int open) const { return is_exchanged(k, open) ? -1 : 1; }
  // With child and parent exchanged; only for screws with symmetric parameters.
  static Joint exchanged(Joint joint) {
    std::swap(joint.at, joint.child_at);
    joint.q = {-joint.q[0]}, joint.v = {-joint.v[0]};
    return joint;
  }
  BodySpec body(int k, BodyId parent, int number, const Joint& joint) const {
    BodySpec spec = bodies[static_cast<std::size_t>(k)];
    spec.name = body_name(k), spec.joint_name = name(number);
    spec.parent = parent, spec.joint = joint.spec, spec.at = joint.at, spec.child_at = joint.child_at;
    spec.q = joint.q, spec.v = joint.v;
    return spec;
  }
};

struct RingOptions {
  Kind tested = Kind::revolute;
  bool floating = false;
  bool planar = false;   ///< all axes parallel: some of the equations are redundant
  bool coupled = false;  ///< two joints that are in both trees are coupled
  int mobility = 2;      ///< at least, if no motion is prescribed and nothing is coupled
  std::function<void(Prng&, JointSpec&, const Values& q)> give{};  ///< parameters for the joint under test, which is at q
};

namespace detail {
inline Pose ring_pose(Prng& random, double size, bool planar) {
  const Vec3 axis = planar ? z_axis : random.direction();
  const Vec3 at = random.vector(size);
  return {at, from_axis_angle(axis, random.uniform(-1, 1))};
}

inline JointSpec ring_joint(Prng& random, Kind kind, bool planar) {
  JointSpec joint = random_joint(random, kind, {.parameters = false});
  if (!planar) return joint;
  const double angle = random.uniform(-3, 3);
  const Vec3 within{std::cos(angle), std::sin(angle), 0};
  joint.axis = kind == Kind::prismatic ? within : z_axis;
  if (kind == Kind::universal) joint.axis2 = within;
  return joint;
}

inline Values ring_coordinates(Prng& random, Kind kind, bool planar) {
  Values q = random_coordinates(random, kind);
  if (kind == Kind::universal) q[1] = planar ? 0 : random.uniform(-1, 1);
  if (kind == Kind::ball && planar) {
    const double half = random.uniform(-1, 1);
    q = {std::cos(half), 0, 0, std::sin(half)};
  }
  return q;
}
}  // namespace detail

/// A ring that is closed at its start, with velocities that its joints allow.
inline Ring random_ring(std::uint64_t seed, const RingOptions& options) {
  Prng random(seed);
  Ring ring;
  Kind end = Kind::revolute;  // of the other end, if the joint under test is at one end
  if (!options.planar) do
      end = random_kind(random);
    while (end == Kind::free || end == Kind::weld);
  const int n = options.planar ? 4 + options.mobility - std::min(info(options.tested).nv, 2)
                               : std::max(4, options.mobility + 7 - info(options.tested).nv - info(end).nv);
  ring.tested = random.chance(0.4) ? n : random.integer(1, n - 1);
  ring.other = ring.tested == n ? random.integer(0, n - 1) : random.integer(ring.tested + 1, n);
  if (options.floating) {
    ring.gravity = {};
    BodySpec base;
    base.name = base.joint_name = "base", base.joint.kind = Kind::free;
    base.q = random_coordinates(random, Kind::free), base.v = random_velocities(random, Kind::free);
    ring.base = base;
  }
  const auto give_mass = [&random](BodySpec& body) {
    body.mass = random.uniform(0.5, 3), body.com = random.vector(0.2);
    const double x = random.uniform(0.04, 0.06), y = random.uniform(0.04, 0.06), z = random.uniform(0.04, 0.06);
    body.inertia = diagonal(x, y, z);
  };
  if (ring.base) give_mass(*ring.base);
  ring.bodies.resize(static_cast<std::size_t>(n));
  for (BodySpec& body : ring.bodies) give_mass(body);
  bool slides = false;  // at most once: a ring turns only if at least four of its joints do
  for (int k = 0; k <= n; ++k) {
    Kind kind = Kind::revolute;
    if (!options.planar && random.chance(0.3)) kind = slides || random.chance(0.5) ? Kind::helical : Kind::prismatic;
    slides = slides || kind == Kind::prismatic;
    if (k == ring.tested)
      kind = options.tested;
    else if (k == 0 || k == n)
      kind = ring.tested == n || k == n ? end : kind;
    Ring::Joint joint;
    joint.spec = detail::ring_joint(random, kind, options.planar);
    joint.at = detail::ring_pose(random, 0.6, options.planar), joint.child_at = detail::ring_pose(random, 0.3, options.planar);
    joint.q = detail::ring_coordinates(random, kind, options.planar), joint.v = random_velocities(random, kind);
    if (k != ring.tested)
      for (int i = 0; i < info(kind).nv; ++i) {
        joint.spec.parameters.stiffness.push_back(random.chance(0.5) ? random.uniform(0, 3) : 0.0);
        joint.spec.parameters.damping.push_back(random.chance(0.5) ? random.uniform(0, 0.3) : 0.0);
        joint.spec.parameters.armature.push_back(random.chance(0.3) ? random.uniform(0, 0.5) : 0.0);
      }
    ring.joints.push_back(joint);
  }
  Ring::Joint& last = ring.joints.back();
  {
    const World open(ring.open_at(n, false));
    const auto pose = [&](const std::string& name) {
      return open.motions()[static_cast<std::size_t>(open.model().body(name).index)].pose;
    };
    last.at = (ring.base ? inverse(pose("base")) : Pose{}) * pose(Ring::body_name(n - 1)) * last.child_at *
              inverse(joint_motion(last.spec, last.q.begin()));
  }
  if (options.give) options.give(random, ring.joint_under_test().spec, ring.joint_under_test().q);
  if (options.coupled) {  // joints before both, or the end and one before
    std::vector<int> among;
    for (int k = 0; k <= n; ++k)
      if (k != ring.tested && k != ring.other && info(ring.joints[static_cast<std::size_t>(k)].spec.kind).nv == 1)
        among.push_back(k);
    const int first = among[0], second = among[among.size() - 1];
    const double multiplier = random.uniform(-2, 2);
    ring.coupling = {first, second, multiplier};
  }
  // The velocities that the joints allow.
  const World closed(ring.as_loop(), Variables::velocities);
  const auto copy = [](Numbers from, Values& to) {
    to = {};
    for (const double x : from) to.push_back(x);
  };
  const auto take = [&](const std::string& name, Values& q, Values& v) {
    const JointView view = closed.joint({closed.find_joint(name)});
    // Joints beyond the one under test have their bodies exchanged.
    copy(view.q, q), copy(view.v, v);
  };
  if (ring.base) take("base", ring.base->q, ring.base->v);
  for (int k = 0; k <= n; ++k) {
    Ring::Joint& joint = ring.joints[static_cast<std::size_t>(k)];
    take(Ring::name(k), joint.q, joint.v);
    if (k > ring.tested && k < n) joint.q = {-joint.q[0]}, joint.v = {-joint.v[0]};
  }
  return ring;
}

// Laws of one world.

/// The larger one; NaN is the largest of all.
inline void keep_larger(double& worst, double x) {
  if (!(x <= worst) && !std::isnan(worst)) worst = x;
}

inline double size_of(const Wrench& w) { return norm(w.force) + norm(w.torque); }

/// The bodies of a world with their velocities: momenta and their changes about centres of mass, world axes.
struct Momenta {
  std::vector<Eigen::Vector3d> linear, angular;
};

inline Eigen::Matrix3d world_inertia(const World& world, BodyId body) {
  const Sym3& J = world.model()[body].inertia;
  const Mat3 R = rotation_matrix(world.motions()[static_cast<std::size_t>(body.index)].pose.rotation);
  Eigen::Matrix3d I, A;
  I << J.xx, J.xy, J.xz, J.xy, J.yy, J.yz, J.xz, J.yz, J.zz;
  A << R.xx, R.xy, R.xz, R.yx, R.yy, R.yz, R.zx, R.zy, R.zz;
  return A * I * A.transpose();
}
inline Vec3 centre(const World& world, BodyId body) {
  return world.motions()[static_cast<std::size_t>(body.index)].pose * world.model()[body].com;
}
inline Momenta momenta_of(const World& world, const std::vector<BodyMotion>& motions) {
  Momenta sum;
  for (int b = 0; b < world.model().size(); ++b) {
    const BodySpec& body = world.model()[BodyId{b}];
    const BodyMotion& motion = motions[static_cast<std::size_t>(b)];
    sum.linear.push_back(body.mass * eigen(velocity_of(motion, body.com)));
    sum.angular.push_back(world_inertia(world, {b}) * eigen(motion.angular));
  }
  return sum;
}
inline std::vector<BodyMotion> motions_of(const World& world) { return {world.motions().begin(), world.motions().end()}; }

/// What every body's momenta gain, less the wrenches or impulses of its joints: the largest rest, relative to the largest wrench.
/// `through`: of a joint on its declared child, about the origin of the child's frame, in its axes.
inline double unbalanced(const World& world, Momenta gains, const std::function<Wrench(JointId)>& through) {
  double scale = 1e-3;
  for (const auto& gain : gains.linear) scale = std::max(scale, gain.norm());
  for (const auto& gain : gains.angular) scale = std::max(scale, gain.norm());
  std::vector<JointId> joints = world.loops();
  for (int b = 0; b < world.model().size(); ++b) joints.push_back({b});
  for (const JointId id : joints) {
    const JointView joint = world.joint(id);
    const Wrench own = through(id);
    const Pose& pose = world.motions()[static_cast<std::size_t>(joint.child.index)].pose;
    const Mat3 R = rotation_matrix(pose.rotation);
    const Eigen::Vector3d f = eigen(R * own.force), t = eigen(R * own.torque);
    scale = std::max({scale, f.norm(), t.norm()});
    const auto add = [&](BodyId body, double sign) {
      if (body == ground) return;
      const auto b = static_cast<std::size_t>(body.index);
      gains.linear[b] -= sign * f;
      gains.angular[b] -= sign * (t + eigen(pose.position - centre(world, body)).cross(f));
    };
    add(joint.child, 1), add(joint.parent, -1);
  }
  double left = 0;
  for (const auto& gain : gains.linear) keep_larger(left, gain.norm());
  for (const auto& gain : gains.angular) keep_larger(left, gain.norm());
  return left / scale;
}

/// Acceleration of a body's centre of mass, less gravity.
inline Vec3 acceleration_less_gravity(const World& world, BodyId body) {
  const BodyMotion& motion = world.motions()[static_cast<std::size_t>(body.index)];
  const BodyAcceleration& rate = world.accelerations()[static_cast<std::size_t>(body.index)];
  const Vec3 to = centre(world, body) - motion.pose.position, w = motion.angular;
  return rate.linear + cross(rate.angular, to) + cross(w, cross(w, to)) - world.model().gravity();
}

/// A wrench about a joint's frame on its child, about the origin of the child's frame.
inline Wrench at_origin(const JointView& joint, const Wrench& at_joint) {
  return {at_joint.force, at_joint.torque + cross(joint.child_at.position, at_joint.force)};
}

/// Newton's and Euler's equations of every body.
inline double newton_euler_error(const World& world) {
  Momenta rates;
  for (int b = 0; b < world.model().size(); ++b) {
    const BodySpec& body = world.model()[BodyId{b}];
    const BodyMotion& motion = world.motions()[static_cast<std::size_t>(b)];
    const BodyAcceleration& rate = world.accelerations()[static_cast<std::size_t>(b)];
    const Vec3 w = motion.angular, acceleration = acceleration_less_gravity(world, {b});
    const Eigen::Matrix3d I = world_inertia(world, {b});
    rates.linear.push_back(body.mass * eigen(acceleration));
    rates.angular.push_back(I * eigen(rate.angular) + eigen(w).cross(I * eigen(w)));
  }
  return unbalanced(world, rates,
                    [&](JointId joint) { return at_origin(world.joint(joint), world.joint_forces(joint).reaction); });
}

/// Components of a wrench on the child, about the joint's frame there, along the DoFs of a joint: Eᵀ W.
inline Values along_dofs(const JointView& joint, const Wrench& on_child) {
  JointSpec spec;
  spec.kind = joint.kind, spec.axis = joint.axis, spec.axis2 = joint.axis2, spec.pitch = joint.pitch;
  const Mat3 R = rotation_matrix(joint.child_at.rotation);
  const Vec3 f = transpose_times(R, on_child.force), t = transpose_times(R, on_child.torque);
  Values along;
  for (const Motion<double>& E : joint_dofs(spec, joint.q.data())) along.push_back(dot(E.v, f) + dot(E.w, t));
  return along;
}

/// What a joint transmits along its DoFs is its effort less what its armature takes; the pure reaction does no work on them.
/// `accelerations`: of the DoFs. Relative to the reaction.
inline double effort_error(const World& world, JointId id, Numbers accelerations) {
  const JointView joint = world.joint(id);
  const JointForces forces = world.joint_forces(id);
  const Values total = along_dofs(joint, forces.reaction), pure = along_dofs(joint, forces.bearing);
  double worst = 0, scale = 1 + size_of(forces.reaction);
  for (int i = 0; i < total.size(); ++i) {
    if (((joint.locked | joint.resting) >> i & 1u) != 0) continue;
    const double rotor = joint.parameters == nullptr ? 0.0 : joint.parameters->armature.of(i);
    const double taken = rotor == 0 ? 0.0 : rotor * accelerations[static_cast<std::size_t>(i)];
    scale = std::max({scale, std::fabs(forces.effort[i]), std::fabs(taken)});
    keep_larger(worst, std::fabs(total[i] - (forces.effort[i] - taken)));
    keep_larger(worst, std::fabs(pure[i]));
  }
  return worst / scale;
}

/// The rate of the bodies' kinetic energy against the power of gravity and of what the joints transmit along their DoFs.
inline double power_error(const World& world) {
  double left = 0, scale = 1;
  const auto add = [&](double power) { left += power, scale += std::fabs(power); };
  for (int b = 0; b < world.model().size(); ++b) {
    const BodySpec& body = world.model()[BodyId{b}];
    const BodyMotion& motion = world.motions()[static_cast<std::size_t>(b)];
    const BodyAcceleration& rate = world.accelerations()[static_cast<std::size_t>(b)];
    const Vec3 w = motion.angular, acceleration = acceleration_less_gravity(world, {b});
    add(body.mass * dot(velocity_of(motion, body.com), acceleration));
    add(eigen(w).dot(world_inertia(world, {b}) * eigen(rate.angular)));
  }
  std::vector<JointId> joints = world.loops();
  for (int b = 0; b < world.model().size(); ++b) joints.push_back({b});
  for (const JointId id : joints) {
    const JointView joint = world.joint(id);
    const Values along = along_dofs(joint, world.joint_forces(id).reaction);
    for (int i = 0; i < along.size(); ++i) add(-along[i] * joint.v[static_cast<std::size_t>(i)]);
  }
  return std::fabs(left) / scale;
}

/// DoFs of the tree that are neither held nor driven, less the independent equations.
inline int mobility_of(const World& world) {
  int dofs = -world.loop_status().rank;
  for (int b = 0; b < world.model().size(); ++b) {
    const JointView joint = world.joint({b});
    const unsigned held = joint.locked | joint.resting;
    for (int i = 0; i < info(joint.kind).nv; ++i) dofs += (held >> i & 1u) == 0 && !joint.driven ? 1 : 0;
  }
  return dofs;
}

inline double balance_error(const Simulation& sim) {
  const EnergyBalance b = sim.energy();
  return std::fabs(b.error) / (1 + b.largest_kinetic + std::fabs(b.work) + std::fabs(b.dissipated));
}

// Agreement of two worlds.

/// A wrench of a joint of a ring in the world: on the body that is the joint's child in the ring, about the world's origin.
inline Wrench in_world(const Ring& ring, const World& world, int number, const Wrench& on_child) {
  const JointView joint = world.joint({world.find_joint(Ring::name(number))});
  const Pose& pose = world.motions()[static_cast<std::size_t>(joint.child.index)].pose;
  const Mat3 R = rotation_matrix(pose.rotation);
  const bool same = world.model()[joint.child].name == Ring::body_name(std::min(number, ring.size() - 1));
  const double sign = same ? 1 : -1;
  const Vec3 f = R * on_child.force;
  return {sign * f, sign * (R * on_child.torque + cross(pose.position, f))};
}

inline double apart(const Wrench& a, const Wrench& b) { return norm(a.force - b.force) + norm(a.torque - b.torque); }

/// Poses, velocities, accelerations, energies, and what all joints transmit, where redundant equations do not leave it open.
/// `least`: also there; only for rings in which joints that have their bodies exchanged have their frames at one point. Returns
/// the largest disagreement, in units of each quantity's size.
inline double disagreement(const Ring& ring, const World& one, const World& other, bool least = false) {
  double worst = 0;
  const auto differ = [&worst](double difference, double scale) { keep_larger(worst, difference / (1 + scale)); };
  const Totals s = one.totals(), t = other.totals();
  differ(std::fabs(s.kinetic - t.kinetic), s.kinetic);
  differ(std::fabs(s.potential - t.potential), std::fabs(s.potential));
  differ(norm(s.linear - t.linear), norm(s.linear)), differ(norm(s.angular - t.angular), norm(s.angular));
  double fastest = 0, quickest = 0;
  for (const BodyMotion& m : one.motions()) fastest = std::max(fastest, norm(m.linear) + norm(m.angular));
  for (const BodyAcceleration& a : one.accelerations()) quickest = std::max(quickest, norm(a.linear) + norm(a.angular));
  for (int b = 0; b < one.model().size(); ++b) {
    const auto i = static_cast<std::size_t>(b),
               j = static_cast<std::size_t>(other.model().body(one.model()[BodyId{b}].name).index);
    const BodyMotion &m = one.motions()[i], &n = other.motions()[j];
    const BodyAcceleration &am = one.accelerations()[i], &an = other.accelerations()[j];
    differ(norm(m.pose.position - n.pose.position), 0);
    differ(norm(m.linear - n.linear) + norm(m.angular - n.angular), fastest);
    differ(norm(am.linear - an.linear) + norm(am.angular - an.angular), quickest);
  }
  CHECK(mobility_of(one) == mobility_of(other));
  double largest = 0;
  for (int k = 0; k <= ring.size(); ++k)
    if (const int number = one.find_joint(Ring::name(k)); number >= 0)
      largest = std::max(largest, size_of(one.joint_forces({number}).reaction));
  for (int k = 0; k <= ring.size(); ++k) {
    const JointId a{one.find_joint(Ring::name(k))}, b{other.find_joint(Ring::name(k))};
    CHECK((a.index < 0) == (b.index < 0));
    if (a.index < 0 || b.index < 0) continue;
    const JointForces f = one.joint_forces(a), g = other.joint_forces(b);
    CHECK(f.determined == g.determined);
    if (!f.determined && !least) continue;
    const JointView x = one.joint(a), y = other.joint(b);
    const auto differs = [&](const Wrench& v, const Wrench& w) {
      differ(apart(in_world(ring, one, k, at_origin(x, v)), in_world(ring, other, k, at_origin(y, w))), largest);
    };
    differs(f.reaction, g.reaction), differs(f.bearing, g.bearing);
    if (k != ring.tested) continue;
    CHECK(x.kind == y.kind);
    CHECK(x.locked == y.locked);
    CHECK(x.resting == y.resting);
    for (std::size_t i = 0; i < x.q.size(); ++i) differ(std::fabs(x.q[i] - y.q[i]), std::fabs(x.q[i]));
    for (std::size_t i = 0; i < x.v.size(); ++i) differ(std::fabs(x.v[i] - y.v[i]), fastest);
    for (int i = 0; i < f.effort.size(); ++i) differ(std::fabs(f.effort[i] - g.effort[i]), largest + std::fabs(f.effort[i]));
  }
  return worst;
}

}  // namespace momentree::oracle
