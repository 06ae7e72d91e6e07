#include <tests/fuzz/instant_laws.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include <momentree/simulate/events/topology_record.hpp>

namespace momentree::fuzz {

namespace {

struct Load {
  Vec3 force{}, torque{};  // about the body's origin, world axes
  double force_size = 0, torque_size = 0;
  void add(const Vec3& f, const Vec3& t) {
    force += f, torque += t;
    force_size += norm(f), torque_size += norm(t);
  }
};

// The loads of everything that acts on bodies, as it is reported.
class Loads {
 public:
  explicit Loads(const World& world) : world_(world), loads_(static_cast<std::size_t>(world.model().size())) {
    add_weights();
    add_forces();
    add_joints();
    add_springs();
    for (const ContactPoint& point : world.contacts()) {
      push(point.one, point.point, point.force, point.moment);
      push(point.other, point.point, -point.force, -point.moment);
    }
  }
  const Load& operator[](std::size_t body) const { return loads_[body]; }
  double force_size() const {
    double size = 0;
    for (const Load& load : loads_) size = std::max(size, load.force_size);
    return size;
  }
  double torque_size() const {
    double size = 0;
    for (const Load& load : loads_) size = std::max(size, load.torque_size);
    return size;
  }
  /// Some reactions are one choice of many.
  bool determined() const { return determined_; }

 private:
  const BodyMotion& motion(BodyId body) const { return world_.motions()[static_cast<std::size_t>(body.index)]; }
  void push(BodyId body, const Vec3& point, const Vec3& force, const Vec3& torque = {}) {
    if (body == ground) return;
    loads_[static_cast<std::size_t>(body.index)].add(force, torque + cross(point - motion(body).pose.position, force));
  }
  void add_weights() {
    for (int b = 0; b < world_.model().size(); ++b) {
      if (!world_.alive({b})) continue;
      const BodySpec& body = world_.model()[BodyId{b}];
      push({b}, motion({b}).pose * body.com, body.mass * world_.model().gravity());
    }
  }
  void add_forces() {
    for (const BodyForce& given : world_.model().forces()) {
      if (!world_.alive(given.body)) continue;
      const BodyMotion& m = motion(given.body);
      const Mat3 axes = rotation_matrix(m.pose.rotation);
      const auto now = [&](const std::array<Signal, 3>& s) {
        const Vec3 value{s[0].value(world_.time()), s[1].value(world_.time()), s[2].value(world_.time())};
        return given.body_axes ? axes * value : value;
      };
      const Vec3 v = velocity_of(m, given.point);
      const double drag = given.drag.linear + given.drag.quadratic * given.drag.area * norm(v);
      push(given.body, m.pose * given.point, now(given.force) - drag * v, now(given.torque));
    }
  }
  void add_joints() {
    for (const JointId id : present_joints(world_)) {
      const JointView joint = world_.joint(id);
      const JointForces forces = world_.joint_forces(id);
      determined_ = determined_ && forces.determined;
      const Pose& child = motion(joint.child).pose;
      const Mat3 axes = rotation_matrix(child.rotation);
      const Vec3 force = axes * forces.reaction.force, torque = axes * forces.reaction.torque;
      const Vec3 point = child * joint.child_at.position;
      push(joint.child, point, force, torque);
      push(joint.parent, point, -force, -torque);
    }
  }
  void add_springs() {
    for (int s = 0; s < world_.springs(); ++s) {
      const SpringView spring = world_.spring({s});
      if (spring.broken || spring.tension == 0 || spring.length == 0) continue;
      const Vec3 pull = (spring.tension / spring.length) * (spring.place_of_to - spring.place_of_from);
      push(spring.from.body, spring.place_of_from, pull);
      push(spring.to.body, spring.place_of_to, -pull);
    }
  }

  const World& world_;
  std::vector<Load> loads_;
  bool determined_ = true;
};

Vec3 times(const Sym3& inertia, const Vec3& w) {
  return {inertia.xx * w.x + inertia.xy * w.y + inertia.xz * w.z, inertia.xy * w.x + inertia.yy * w.y + inertia.yz * w.z,
          inertia.xz * w.x + inertia.yz * w.y + inertia.zz * w.z};
}

// The momentum of a body about its origin, and how it changes according to its acceleration.
struct Momentum {
  Vec3 linear, angular;       // kg m/s; kg m²/s about the world's origin
  Vec3 rate, turning, about;  // N; N m about `about`
  // Sizes of the terms, of which rounding remains where they cancel.
  double linear_terms = 0, rate_terms = 0, turning_terms = 0;
};
Momentum momentum_of(const BodySpec& body, const BodyMotion& m, const BodyAcceleration& a) {
  const Mat3 axes = rotation_matrix(m.pose.rotation);
  const auto world_inertia = [&](const Vec3& w) { return axes * times(body.inertia, transpose(axes) * w); };
  const Vec3 arm = axes * body.com;
  const Vec3 velocity = m.linear + cross(m.angular, arm);
  const Vec3 acceleration = a.linear + cross(a.angular, arm) + cross(m.angular, cross(m.angular, arm));
  const Vec3 spin = world_inertia(m.angular);
  Momentum all;
  all.linear = body.mass * velocity;
  all.angular = cross(m.pose.position + arm, all.linear) + spin;
  all.rate = body.mass * acceleration;
  all.turning = cross(arm, all.rate) + world_inertia(a.angular) + cross(m.angular, spin);
  all.about = m.pose.position;
  const double reach = norm(arm), w = norm(m.angular);
  all.linear_terms = body.mass * (norm(m.linear) + w * reach);
  all.rate_terms = body.mass * (norm(a.linear) + (norm(a.angular) + w * w) * reach);
  all.turning_terms = reach * all.rate_terms + norm(world_inertia(a.angular)) + w * norm(spin);
  return all;
}

// Forces, torques and momenta whose rounding may be all that is there.
double small(const World& world) {
  double size = 0;
  for (const BodySpec& body : world.model().bodies())
    size += 1e-5 * (body.mass + body.inertia.xx + body.inertia.yy + body.inertia.zz);
  return size;
}

// Bodies that are welded to the ground, directly or by others, do not touch it. `most`: bodies may be welded in a circle.
bool welded_to_ground(const World& world, BodyId body, int most = 20) {
  for (const JointId id : present_joints(world)) {
    const JointView joint = world.joint(id);
    if (joint.child == body && joint.kind == Kind::weld &&
        (joint.parent == ground || (most > 0 && welded_to_ground(world, joint.parent, most - 1))))
      return true;
  }
  return false;
}

// Equations of cables between the same two bodies may contradict each other by roundings.
bool doubly_tied(const World& world) {
  for (int s = 0; s < world.springs(); ++s)
    for (int t = 0; t < s; ++t) {
      const SpringView one = world.spring({s}), other = world.spring({t});
      const auto taut = [](const SpringView& spring) {
        return spring.inextensible && !spring.broken && spring.length > spring.law.rest * (1 - 1e-6);
      };
      if (taut(one) && taut(other) &&
          std::minmax(one.from.body.index, one.to.body.index) == std::minmax(other.from.body.index, other.to.body.index))
        return true;
    }
  return false;
}

bool moves_points(Kind kind) {
  return kind != Kind::revolute && kind != Kind::universal && kind != Kind::ball && kind != Kind::weld;
}

// Whether nothing that acts on the bodies changes with time, and nothing that lies still rattles.
bool is_constant(const Model& model) {
  for (const BodyForce& force : model.forces())
    for (std::size_t k = 0; k < 3; ++k)
      if (!force.force[k].constant() || !force.torque[k].constant()) return false;
  for (const Collider& one : model.colliders())
    if (!(one.solid.belt == Vec3{})) return false;
  for (const ContactRule& rule : model.contact_rules())
    if (rule.law.restitution > 0) return false;
  return std::ranges::none_of(model.bodies(), [](const BodySpec& body) { return body.joint.parameters.drive != nullptr; });
}

}  // namespace

void InstantLaws::look(const Simulation& simulation) {
  const World& world = simulation.world();
  char text[40];
  const bool steps = simulation.integration().method == "stepping" || step_memory(simulation).stepping.on;
  std::snprintf(text, sizeof text, "at %.9g s%s", world.time(), steps ? " (stepped)" : "");
  at_ = text;
  ++found_.counts["instants"];
  require_equations_of_motion(world);
  require_contact_law(world, steps);
  require_joints(world, steps);
  require_totals(world);
  require_rest(simulation);
  if (steps) return;  // overlaps are of the order of the distance of a step
  require_nothing_below_floor(world);
  require_cables(world);
}

// Newton's and Euler's equations of every body.
void InstantLaws::require_equations_of_motion(const World& world) {
  const Loads loads(world);
  // Torques leave round-off in forces.
  const double torques = loads.torque_size() + small(world), forces = loads.force_size() + 1e-5 * torques + small(world);
  if (doubly_tied(world)) {
    ++found_.counts["left out: two bodies between which several cables are at their length"];
    return;
  }
  for (int b = 0; b < world.model().size(); ++b) {
    const auto i = static_cast<std::size_t>(b);
    if (!world.alive({b})) continue;
    const Momentum m = momentum_of(world.model()[BodyId{b}], world.motions()[i], world.accelerations()[i]);
    const std::string where = world.model()[BodyId{b}].name + " " + at_;
    found_.within(norm(m.rate - loads[i].force), 1e-9 * (forces + norm(m.rate)) + 1e-12 * m.rate_terms,
                  "forces explain m a of every body", where);
    found_.within(norm(m.turning - loads[i].torque), 1e-9 * (torques + forces + norm(m.turning)) + 1e-12 * m.turning_terms,
                  "torques explain the spin of every body", where);
  }
}

// No contact pulls or leaves its cone, and friction opposes slip.
void InstantLaws::require_contact_law(const World& world, bool stepped) {
  const std::vector<ContactPoint> points = world.contacts();
  double size = small(world);
  for (const ContactPoint& point : points) size = std::max(size, norm(point.force));
  constexpr double beyond_cone = 2e-4;  // contacts that stick at their limit may exert 1e-4 more
  for (const ContactPoint& point : points) {
    const std::string where = world.model().body_name(point.one) + " on " + world.model().body_name(point.other) + " " + at_;
    const double normal = dot(point.force, point.normal);
    const Vec3 friction = point.force - normal * point.normal;
    const ContactLaw law = world.model().contact_law(point.one, point.other);
    found_.within(-normal, 1e-9 * size, "no contact pulls", where);
    const double limit = std::max(law.friction, law.static_friction) * std::max(normal, 0.0);
    found_.within(norm(friction), limit * (1 + beyond_cone) + 1e-9 * size, "contact forces are in their cones", where);
    const double twist = std::fabs(dot(point.moment, point.normal)), roll = norm(cross(point.moment, point.normal));
    found_.within(twist - law.torsional * normal, 1e-9 * size, "moments are within their bounds", where);
    found_.within(roll - law.rolling * normal, 1e-9 * size, "moments are within their bounds", where);
    const double speed = norm(point.slip);
    if (point.slips && speed > 1e-2 && !stepped)  // the force of a step opposes the slip after it
      found_.within(dot(friction, point.slip), 1e-9 * size * speed, "friction opposes slip", where);
    if (!point.slips && limit > 0) found_.within(speed, 1e-6, "a contact that sticks does not slip", where);
    found_.within(std::fabs(norm(point.normal) - 1), 1e-12, "normals have unit length", where);
    ++found_.counts["contact points"];
  }
}

// The lowest point of everything that can touch is not below the floor.
void InstantLaws::require_nothing_below_floor(const World& world) {
  const std::vector<Collider>& all = world.model().colliders();
  for (const Collider& floor : all) {
    if (!floor.plane) continue;
    for (const Collider& one : all) {
      if (one.plane || one.body == ground || one.solid.rim > 0 || !world.alive(one.body)) continue;
      if (world.model().contact_law(one.body, ground).off || !world.gap(one.body, ground)) continue;
      if (world.gap(one.body, ground)->passes || welded_to_ground(world, one.body)) continue;
      const Pose& pose = world.motions()[static_cast<std::size_t>(one.body.index)].pose;
      double lowest = std::numeric_limits<double>::infinity(), size = norm(pose.position) + one.solid.reach;
      for (const Vec3& corner : one.solid.vertices)
        lowest = std::min(lowest, dot(pose * corner - floor.point, floor.normal) - one.solid.radius);
      found_.within(-lowest, 1e-8 * (1 + size), "nothing is below the floor", world.model()[one.body].name + " " + at_);
    }
  }
}

// Points and axes of loop joints agree, couplings hold, coordinates are within hard stops, bearings do no work.
void InstantLaws::require_joints(const World& world, bool stepped) {
  for (const JointId id : present_joints(world)) {
    const JointView joint = world.joint(id);
    const std::string where = std::string(joint.name) + " " + at_;
    static const BodyMotion still{};
    const auto motion_of = [&](BodyId body) {
      return body == ground ? still : world.motions()[static_cast<std::size_t>(body.index)];
    };
    const BodyMotion child = motion_of(joint.child), parent = motion_of(joint.parent);
    const double size = 1 + norm(child.pose.position) + norm(parent.pose.position);
    const Vec3 apart = child.pose * joint.child_at.position - parent.pose * joint.at.position;
    const Mat3 sides[] = {rotation_matrix(parent.pose.rotation) * rotation_matrix(joint.at.rotation),
                          rotation_matrix(child.pose.rotation) * rotation_matrix(joint.child_at.rotation)};
    const bool along = joint.kind == Kind::prismatic || joint.kind == Kind::cylindrical || joint.kind == Kind::helical;
    const double closed = joint.loop ? 1e-8 : 1e-10;
    if (!moves_points(joint.kind)) found_.within(norm(apart), closed * size, "points of joints agree", where);
    if (along || joint.kind == Kind::revolute) {
      const Vec3 axis = sides[0] * joint.axis;
      found_.within(norm(axis - sides[1] * joint.axis), closed * size, "axes of joints agree", where);
      if (along) found_.within(norm(cross(axis, apart)), closed * size, "points of joints agree along their axes", where);
    }
    if (joint.parameters != nullptr && joint.parameters->limits.hard() && joint.locked == 0)
      for (int dof = 0; dof < static_cast<int>(joint.q.size()) && joint.q.size() == joint.v.size(); ++dof) {
        const double q = joint.q[static_cast<std::size_t>(dof)];
        const double beyond = std::max(joint.parameters->limits.lower_of(dof) - q, q - joint.parameters->limits.upper_of(dof));
        // Changes and sets may give a joint stops that it is beyond: it then goes no farther.
        double& known = beyond_[std::string(joint.name) + std::to_string(dof)];
        if (known == 0 && beyond > 0.01) known = beyond;
        const double speed = std::fabs(joint.v[static_cast<std::size_t>(dof)]);
        found_.within(beyond - known, (stepped ? 2e-3 * (1 + speed) : 1e-8) * (1 + std::fabs(q)),
                      "coordinates are within hard stops", where);
      }
    // `pure` is about the joint's frame on the child, and has no effort along the joint's DoFs.
    const JointForces forces = world.joint_forces(id);
    const Mat3 axes = rotation_matrix(child.pose.rotation);
    const Vec3 force = axes * forces.bearing.force, torque = axes * forces.bearing.torque;
    const Vec3 point = child.pose * joint.child_at.position;
    const Vec3 carried = parent.linear + cross(parent.angular, point - parent.pose.position);
    const Vec3 velocity = velocity_of(child, joint.child_at.position) - carried, turning = child.angular - parent.angular;
    const double scale = norm(force) * (norm(velocity_of(child, joint.child_at.position)) + norm(carried) + norm(child.angular)) +
                         norm(torque) * (norm(child.angular) + norm(parent.angular));
    constexpr double rounding = 1e-11;  // of velocities that impacts stop (m/s, rad/s)
    found_.within(std::fabs(dot(force, velocity) + dot(torque, turning)),
                  1e-9 * scale + 1e-9 + rounding * (norm(force) + norm(torque)), "bearings do no work", where);
  }
  for (int c = 0; c < world.couplings(); ++c) {
    const CouplingView view = world.coupling({c});
    if (view.ended) continue;
    const auto joint = world.single_dof(view.coupling.joint);
    const auto follows = view.coupling.leads() ? world.single_dof(view.coupling.follows) : joint;
    if (!joint || !follows) continue;
    found_.within(std::fabs(joint->first - view.coupling.value(follows->first)), 1e-8 * (1 + view.coupling.size(follows->first)),
                  "couplings hold", coupling_names(world, {c}).first + " " + at_);
  }
}

void InstantLaws::require_cables(const World& world) {
  for (int s = 0; s < world.springs(); ++s) {
    const SpringView spring = world.spring({s});
    if (!spring.inextensible || spring.broken) continue;
    found_.within(spring.length - spring.law.rest, 1e-8 * (1 + spring.law.rest), "cables are not too long",
                  std::string(spring.name) + " " + at_);
    found_.within(-spring.tension, 1e-9 * (1 + std::fabs(spring.tension)), "no cable pushes",
                  std::string(spring.name) + " " + at_);
  }
}

// The momenta that certificates use are those of the bodies.
void InstantLaws::require_totals(const World& world) {
  const Totals totals = world.totals();
  Vec3 linear{}, angular{};
  double linear_size = small(world), angular_size = small(world), kinetic = 0;  // sizes of the terms
  bool armatures = false;
  for (const JointId id : present_joints(world))
    if (const JointParameters* p = world.joint(id).parameters) armatures = armatures || p->armature.any();
  for (int b = 0; b < world.model().size(); ++b) {
    if (!world.alive({b})) continue;
    const BodySpec& body = world.model()[BodyId{b}];
    const BodyMotion& motion = world.motions()[static_cast<std::size_t>(b)];
    const Momentum m = momentum_of(body, motion, {});
    linear += m.linear, angular += m.angular;
    linear_size += m.linear_terms, angular_size += norm(m.angular) + m.linear_terms * norm(motion.pose.position);
    const Vec3 centre = motion.linear + cross(motion.angular, rotation_matrix(motion.pose.rotation) * body.com);
    const Vec3 spin = transpose(rotation_matrix(motion.pose.rotation)) * motion.angular;
    kinetic += 0.5 * (body.mass * dot(centre, centre) + dot(spin, times(body.inertia, spin)));
  }
  found_.within(norm(totals.linear - linear), 1e-10 * linear_size, "totals: linear momentum", at_);
  found_.within(norm(totals.angular - angular), 1e-10 * angular_size, "totals: angular momentum", at_);
  found_.within(armatures ? kinetic - totals.kinetic : std::fabs(totals.kinetic - kinetic), 1e-10 * (kinetic + 1e-12),
                "totals: kinetic energy", at_);
}

// What is at rest stays where it is until an event.
void InstantLaws::require_rest(const Simulation& simulation) {
  const auto& motions = simulation.world().motions();
  if (!is_constant(scenario_.model)) return;
  double moved = 0, speed = 0;
  for (std::size_t b = 0; b < at_rest_.size(); ++b) {
    const Mat3 one = rotation_matrix(motions[b].pose.rotation), other = rotation_matrix(at_rest_[b].pose.rotation);
    moved = std::max(moved, norm(motions[b].pose.position - at_rest_[b].pose.position));
    for (const Vec3& axis : {Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) moved = std::max(moved, norm(one * axis - other * axis));
    speed = std::max({speed, norm(motions[b].linear), norm(motions[b].angular)});
  }
  const bool stays = !at_rest_.empty() && simulation.events().size() == rest_events_;
  if (stays && rested_ > 1)
    found_.within(moved, 1e-9, "what is at rest stays where it is", at_), ++found_.counts["rows at rest"];
  else if (stays && speed < 1e-9 && moved < 1e-10)
    ++rested_;
  else
    rested_ = 0, at_rest_.assign(motions.begin(), motions.end()), rest_events_ = simulation.events().size();
}

void InstantLaws::follow(const Simulation& simulation) {
  const World& world = simulation.world();
  if (doubly_tied(world) || followed_ != simulation.events().size() || (!last_.empty() && last_.back().time == world.time()))
    last_.clear();
  followed_ = simulation.events().size();
  // Slow slip keeps its direction for a step, in part, and the next step keeps another part.
  const std::vector<ContactPoint> points = world.contacts();
  if (std::ranges::any_of(points, [](const ContactPoint& point) { return point.slips && norm(point.slip) < 1e-3; }))
    last_.clear();
  if (last_.size() == 3) last_.erase(last_.begin());
  const auto& motions = world.motions();
  const bool stepped = simulation.integration().method == "stepping" || step_memory(simulation).stepping.on;
  last_.push_back({world.time(), stepped, {motions.begin(), motions.end()}, world.accelerations()});
  if (last_.size() < 3) return;
  char text[40];
  std::snprintf(text, sizeof text, "until %.9g s", world.time());
  require_motion_follows_accelerations(text);
}

// Velocities change by the integral of accelerations, where three steps resolve them: a coarse law for gross faults, as the error
// of a step may be that large. Coordinates are relative to the other bodies of a mechanism, so that of the fastest body counts.
void InstantLaws::require_motion_follows_accelerations(const std::string& at) {
  const double h = last_[1].time - last_[0].time, k = last_[2].time - last_[1].time, all = h + k;
  if (h < 0.2 * k || k < 0.2 * h) return;
  if (last_[1].stepped || last_[2].stepped) return;  // contact forces are then means of a step
  double fastest = 1;
  for (const BodyMotion& motion : last_[0].motions) fastest = std::max({fastest, norm(motion.linear), norm(motion.angular)});
  for (std::size_t b = 0; b < last_[0].motions.size(); ++b)
    for (const bool turning : {false, true}) {
      const auto velocity = [&](std::size_t i) { return turning ? last_[i].motions[b].angular : last_[i].motions[b].linear; };
      const auto rate = [&](std::size_t i) {
        return turning ? last_[i].accelerations[b].angular : last_[i].accelerations[b].linear;
      };
      const Vec3 parabola = (all / 6) * ((2 - k / h) * rate(0) + (all * all / (h * k)) * rate(1) + (2 - h / k) * rate(2));
      const Vec3 trapezoids = (0.5 * h) * (rate(0) + rate(1)) + (0.5 * k) * (rate(1) + rate(2));
      const double size = all * (norm(rate(0)) + norm(rate(1)) + norm(rate(2))), unsure = norm(parabola - trapezoids);
      if (unsure > 1e-3 * size) continue;
      ++found_.counts["steps of bodies compared with accelerations"];
      found_.within(norm(velocity(2) - velocity(0) - parabola), 0.05 * size + 4e-6 * (1 + fastest),
                    turning ? "turning follows accelerations" : "motion follows accelerations",
                    scenario_.model.bodies()[b].name + " " + at);
    }
}

}  // namespace momentree::fuzz
