#pragma once
// One world at one instant: model (names), tree (topology), state, and the results of the recursions for this state.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/base/numbers.hpp>
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/workspace.hpp>
#include <momentree/model/model.hpp>
#include <momentree/simulate/names.hpp>
#include <momentree/simulate/world/connections.hpp>
#include <momentree/topology/snapshot.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

class ContactBodies;

/// A joint as its user sees it, in its declared direction. Spans point into the world and are valid until the world next changes.
struct JointView {
  std::string_view name;
  Kind kind = Kind::weld;
  BodyId child, parent;   ///< as declared; parent.index −1: the ground
  bool reversed = false;  ///< its declared child now carries its declared parent, seen from the root
  unsigned locked = 0;    ///< one bit per locked DoF
  unsigned resting = 0;   ///< one bit per DoF that rests on a stop
  bool driven = false;    ///< its motion is prescribed and not suspended by a lock
  Pose at, child_at;
  Vec3 axis, axis2;
  double pitch = 0;
  const JointParameters* parameters = nullptr;
  Numbers q, v, p, pdot;  ///< lengths nq, nv, nv, nv; p and pdot are zero for driven joints, and empty for loop joints
  bool loop = false;      ///< it closes a loop
};

/// Acceleration and forces of a joint at an instant.
struct JointForces {
  Numbers a;  ///< time derivative of v: nv numbers (m/s², rad/s²); points into the world as in JointView; empty for loop joints
  /// Wrench (N, N m) that the declared parent exerts on the declared child: about the origin of the joint's frame on the child
  /// (`child_at`), in the child's axes. `reaction`: the total through the joint, including drive, spring and damping; `bearing`:
  /// without the effort along the joint's DoFs (momentree::bearing_reaction), the load on its bearings and locks.
  Wrench reaction, bearing;
  /// Effort along each DoF (nv numbers, N m or N): momentree::joint_effort; for a driven joint the effort that its motion
  /// requires.
  Values effort;
  /// False if loops or redundant contacts leave the reaction open: other reactions cause the same motion, and this is one of
  /// them.
  bool determined = true;
};

/// A spring or a cable between two points as its user sees it. The name points into the world.
struct SpringView {
  std::string_view name;
  SpringEnd from{}, to{};
  SpringLaw law{};                      ///< as the model or a change set it
  bool broken = false;                  ///< it broke, or a body at one of its ends left the world: it exerts no force
  double length = 0;                    ///< distance between its ends (m); 0 if one of them left the world
  double rate = 0;                      ///< of the length (m/s)
  double tension = 0;                   ///< N; negative: it pushes its ends apart; 0 if it is broken
  Vec3 place_of_from{}, place_of_to{};  ///< of its ends in the world (m)
  bool inextensible = false;            ///< a cable of length law.rest
};

/// What model.json has of it.
template <class Visitor, Like<SpringView> S>
void describe(Visitor& visit, S& spring) {
  visit("from", spring.from, Field{"Its first end"});
  visit("to", spring.to, Field{"Its second end"});
  describe(visit, spring.law);
  visit("inextensible", spring.inextensible, Field{"A cable, whose length never exceeds `rest`"});
  visit("broken", spring.broken, Field{"It broke, or a body at one of its ends left the world"});
}

/// An exact coupling of joints as its user sees it.
struct CouplingView {
  Coupling coupling;
  bool ended = false;  ///< one of its joints broke, left the world, or was changed
  double effort = 0;  ///< on the joint along its DoF (N m or N); −f′(q) times that on the joint that it follows; 0 if it ended
  bool determined = true;  ///< false if the equations leave the effort open
};

/// A point at which two bodies touch.
struct ContactPoint {
  BodyId one, other;       ///< of two bodies `one` was added first; `other` may be the ground
  Vec3 point{}, normal{};  ///< in the world (m); the unit normal points from `other` to `one`
  Vec3 force{};            ///< on `one`, normal force and friction (N), world axes
  Vec3 slip{};             ///< velocity of `one`, less that of `other`, along the surface (m/s)
  bool slips = false;      ///< false: it sticks, or has no friction
  /// False if the equations of motion leave the force open, as under four legs: others cause the same motion, and this is one of
  /// them. Empty while the contact is stepped through.
  std::optional<bool> determined{};
  Vec3 moment{};  ///< on `one`, of torsional and rolling friction (N m), world axes
};

/// The same point in the one order that all contacts of a pair have: see ContactPoint::one.
ContactPoint in_order(ContactPoint point);

/// The gap between two bodies: the least distance of their solids (m), negative where they overlap, and its rate (m/s).
struct BodyGap {
  double distance = 0, rate = 0;
  bool passes = false;  ///< all of their solids pass through each other
};

struct Mechanism {
  std::string_view name;
  BodyId root;
  bool grounded = true;
  std::vector<BodyId> bodies;  ///< root first, in evaluation order
};

/// A DoF of a joint that rests on a stop (sign +1: the upper one).
struct ActiveLimit {
  int joint, dof, sign;
};

/// A stop that acts beyond its limit, because its force is no more than rounding there.
struct DeeperStop {
  int joint, dof, sign;
  double edge;  ///< sign times the coordinate at which it acts
  friend bool operator==(const DeeperStop&, const DeeperStop&) = default;
};

/// The complete state of a world at an instant: a small value for going back and for branching.
struct WorldSnapshot {
  Snapshot engine;
  std::vector<std::pair<int, std::string>> joint_names, mechanism_names;  ///< those that differ from the model's
  std::vector<ActiveLimit> active_limits;
  std::vector<BodySpec> added{};            ///< bodies that were added after the start
  std::vector<Collider> added_colliders{};  ///< and what they touch with
  std::vector<Contact> former_contacts{};   ///< as of WorldConstraints
  std::vector<int> overlapping{};           ///< as of WorldConstraints
  std::optional<Vec3> gravity{};            ///< m/s²; absent: gravity stays as it is when the snapshot is restored
};

/// Gravity, topology and names where they differ from the model: which body is carried by which, and by which joint, as in a
/// state document.
struct Forest {
  /// A joint that differs from the model's joint of that number, or has another name.
  struct Changed {
    int joint = -1;
    std::string name;
    Joint as;  ///< without parameters
    JointParameters parameters;
  };
  std::optional<Vec3> gravity{};        ///< m/s²; without it, gravity stays as it is
  std::vector<Topology::Place> places;  ///< by body, with or without those that were added to the world; empty: topology and
                                        ///< names of mechanisms are the model's, without them
  std::vector<Changed> changed;         ///< in the order of numbers
  std::vector<std::pair<int, std::string>> mechanisms;  ///< by root
  std::vector<ActiveLimit> active_limits;
  /// All loop joints, with their names and angles; their own numbers are unused.
  struct LoopJoint {
    std::string name;
    Loop loop;
    Turns turns{};
    std::vector<ActiveLimit> active_limits{};  ///< their joint is this one
  };
  std::vector<LoopJoint> loops;
  std::vector<Topology::SpringChange> springs;  ///< that broke or whose law was set; also where places are empty
  std::vector<int> ended_couplings;             ///< the same
  std::vector<Contact> contacts;                ///< that were closed; their features and friction, which are unused, follow
  std::vector<Contact> former_contacts{};       ///< as of WorldConstraints
  std::vector<int> overlapping{};               ///< as of WorldConstraints
};

/// The state of one joint in a state document: empty lists keep the start value. If p is given, it is used instead of v; in a
/// world in velocities v is used if both are given.
struct JointStart {
  JointId joint;
  Values q, v, p;
};

/// What a world was made with: the number of its bodies, and the gravity (m/s²).
struct WorldStart {
  int bodies = 0;
  Vec3 gravity{};
};

/// Constraints of a world beside those of its tree.
struct WorldConstraints {
  std::vector<ActiveLimit> active_limits;  ///< DoFs that rest on stops
  /// The contacts that were closed when the last run ended, if forces or the state have changed since: the next run finds out
  /// which of them stay closed, and reports what changes. Empty otherwise.
  std::vector<Contact> former_contacts;
  /// Pairs of colliders that overlapped when the joint between their bodies ended: they pass through each other until they are
  /// apart. By their numbers (pair_of_colliders()), in ascending order.
  std::vector<int> overlapping;

  /// The sign of the stop on which a DoF rests, or 0; a bit per DoF of a joint that rests on one.
  int held(int joint, int dof) const;
  unsigned held(int joint) const;
};

/// The equations of motion of a world in its present state: see dynamics/equations.hpp. M has nv·nv numbers, J 6·nv, the others
/// nv. Valid until the world next changes.
class WorldEquations {
 public:
  WorldEquations(const Tree& tree, const State& state, Workspace<double>& workspace)
      : tree_(tree), state_(state), workspace_(workspace) {}
  void mass_matrix(double* M) const { momentree::mass_matrix(tree_, state_, workspace_, M); }
  void solve_mass(const double* r, double* u) const { momentree::solve_mass(tree_, state_, workspace_, r, u); }
  void inverse_mass_matrix(double* inverse) const { momentree::inverse_mass_matrix(tree_, state_, workspace_, inverse); }
  void bias(double* c) const { momentree::bias(tree_, state_, workspace_, c); }
  void efforts(double* tau) const { momentree::efforts(tree_, state_, workspace_, tau); }
  void inverse_dynamics(const double* a, double* effort) const {
    momentree::inverse_dynamics(tree_, state_, workspace_, a, effort);
  }
  void point_jacobian(BodyId body, Vec3 point, double* J) const;

 private:
  const Tree& tree_;
  const State& state_;
  Workspace<double>& workspace_;
};

/// Evaluates its state lazily, when a result is requested: a world may be used by one thread at a time, even for reading.
class World {
 public:
  /// Compiles the model; the state is in these variables, with closed loops in those of `with_loops`. Throws Error if a
  /// joint-space mass is singular, or a loop cannot be closed.
  explicit World(const Model& model, Variables variables = Variables::momenta, Variables with_loops = Variables::velocities);

  const Model& model() const { return model_; }
  /// What the world was made with.
  const WorldStart& start() const { return start_; }
  const Tree& tree() const { return tree_; }
  const State& state() const;
  double time() const { return state().time(); }

  /// These functions evaluate the state first if that has not been done.
  const CheckedVector<BodyMotion>& motions() const;  ///< by body number
  /// The joint with that number: initially the joint of the body with the same number, or a loop joint. It is the same joint for
  /// as long as it exists, whichever body it carries. Every world has one joint for each of its bodies, and its loop joints.
  JointView joint(JointId joint) const;
  /// These cost another half of an evaluation, once for each state for which they are called. By body number: time derivatives of
  /// `linear` and `angular` of the body's motion; zeros for a removed body.
  const std::vector<BodyAcceleration>& accelerations() const;
  JointForces joint_forces(JointId joint) const;
  Wrench reaction(JointId joint) const;  ///< the reaction alone
  /// Whether the equations of loops determine it, or these components of it.
  bool loops_determine(JointId joint, ReactionParts parts = all_parts) const;
  /// A spring of the model, with its length and tension. Only the tension of a cable needs an evaluation.
  SpringView spring(SpringId spring) const;
  /// The points at which bodies touch at present, with their forces. Redundant points, such as the corners of a box, share the
  /// load without pulling. While contacts are stepped through, forces are means over the last step. Evaluates the state.
  std::vector<ContactPoint> contacts() const;
  /// Empty if one of them has no collision, or left the world. `ground` is the floor and everything fixed to the ground.
  std::optional<BodyGap> gap(BodyId one, BodyId other) const;
  /// The least gap of a body of each set. Bodies that pass through each other count only if all do.
  std::optional<BodyGap> gap(const ContactBodies& one, const ContactBodies& other) const;
  int springs() const { return tree_.springs().count(); }
  /// Number of the spring of that name, broken or not; −1 if there is none.
  int find_spring(std::string_view name) const;
  /// The same for repeated look-ups: `number`, −1 at first, caches the result.
  int find_spring(std::string_view name, std::atomic<int>& number) const;
  /// A coupling of the model, with its effort. Costs accelerations(), like joint_forces().
  CouplingView coupling(CouplingId coupling) const;
  int couplings() const { return static_cast<int>(tree_.couplings().size()); }
  /// Coordinate (rad, m) and velocity (rad/s, m/s) of a joint with one DoF; nothing for other joints.
  std::optional<std::pair<double, double>> single_dof(JointId joint) const;
  /// Number of the joint that has that name now; −1 if there is none.
  int find_joint(std::string_view name) const { return names_.find_joint(name); }
  int find_joint(std::string_view name, std::atomic<int>& number) const { return names_.find_joint(name, number); }
  /// The loop joints, in the order in which they were made, and the state of their equations and those of couplings.
  std::vector<JointId> loops() const;
  LoopStatus loop_status() const;
  /// Changes whenever anything of the state or the topology changes.
  Stamp stamp() const { return state_.stamp(); }
  Totals totals() const;

  /// All joints at once, packed in the order of joint numbers, like state().q(): velocities v (nv numbers, rad/s, m/s), q̇ (nq),
  /// momenta p (nv), ṗ (nv) and v̇ (nv, at the cost of accelerations()). They point into the world and are valid until it next
  /// changes. For a prescribed motion p is the rate, and ṗ its derivative.
  Numbers v() const;
  Numbers p() const;
  Numbers qdot() const;
  Numbers pdot() const;
  Numbers a() const;
  /// The packed momenta of velocities v at coordinates q (nq and nv numbers) in the present topology, for
  /// Simulation::set_state(). DoFs with a prescribed motion have its position and rate at `time` (s; by default the present time)
  /// instead of the given ones, and locked DoFs are at rest; so is a DoF that rests on a stop, if its coordinate is the present
  /// one and its velocity 0. Throws Error for lists of other lengths, numbers that are not finite, and quaternions that differ
  /// from unit length by more than 1e-6.
  std::vector<double> momenta_of(std::span<const double> q, std::span<const double> v, std::optional<double> time = {}) const;
  /// The equations of motion M v̇ + c = τ in the present state.
  WorldEquations equations() const { return {tree_, state_, workspace_}; }

  /// Present mechanisms, in the order of their root's body number.
  std::vector<Mechanism> mechanisms() const;
  MechanismNames mechanism_names() const;
  /// Name of the joint with that number: as declared; after the joint broke, the name of the body that broke off.
  std::string_view joint_name(JointId joint) const { return names_.joint(joint.index); }
  std::string_view mechanism_name(BodyId root) const { return names_.mechanism(root.index); }

  /// False for a removed body: any other use of its handle or its joint's handle terminates the program.
  bool alive(BodyId body) const { return body.index >= 0 && body.index < tree_.bodies() && tree_.alive(body.index); }

  /// Restoring is exact to the last bit, across any number of changes.
  WorldSnapshot snapshot() const;
  void restore(const WorldSnapshot& snapshot);

  /// Restores a state document: the model at `time` (s), with its joints and bodies assembled as in `forest` and start values
  /// replaced. Quaternions are copied bit for bit; they must have unit length to within rounding. Joints that differ from the
  /// model's start at zero if `joints` does not contain them. The forest must be valid: each joint carries one body, and no body
  /// is outboard of itself.
  void restore(double time, const Forest& forest, std::span<const JointStart> joints);

  const WorldConstraints& constraints() const { return constraints_; }

  /// Write access, for what runs the world (world/world_edit.hpp).
  class Edit;
  Edit edit();

 private:
  void put_together(const Forest& forest);
  void put_springs(const std::vector<Topology::SpringChange>& changes);
  void set_values(double time, std::span<const double> q, std::span<const double> y, Variables given);
  void assign(double time, std::span<const double> q, std::span<const double> y, Variables given);
  bool stays_resting(const ActiveLimit& limit, std::span<const double> q, std::span<const double> rates) const;
  void put_values(double time, const Forest& forest, std::span<const JointStart> joints, State& state) const;
  void evaluate() const;
  double cable_tension(int cable) const;
  JointView loop_view(JointId joint) const;
  JointForces loop_forces(JointId joint) const;
  bool contacts_determine(JointId joint) const;
  int carrier(JointId joint) const;
  BodyId add(BodySpec spec, std::vector<contact::Solid> collision);
  void remove(BodyId body);
  void make_room();
  void drive(int joint, JointFunction function);
  void attach_elements();
  bool as_in_the_model(JointId joint) const;
  void load(int body, BodyFunction function);
  void set_time(double time);
  Variables own_variables() const {
    if (model_.has_contact()) return Variables::velocities;
    return tree_.has_loops() ? loop_variables_ : variables_;
  }
  void take_variables(Variables variables);
  void set_gravity(Vec3 gravity);
  unsigned rests_in_steps(int joint) const;  // on stops that are stepped through, which lock nothing
  void forget_active_limits();
  const Connections& connections() const {
    connections_.update(tree_);
    return connections_;
  }
  bool pass_through(int one_collider, int other_collider) const;

  Model model_;
  Variables variables_ = Variables::momenta, loop_variables_ = Variables::velocities;
  WorldStart start_;
  Names declared_, names_;  // as in the model, and now
  WorldConstraints constraints_;
  mutable std::vector<int> open_joints_;  // by redundant contacts
  Tree tree_;
  State state_;
  mutable Workspace<double> workspace_;
  mutable CheckedVector<BodyMotion> motions_;
  mutable std::vector<BodyAcceleration> accelerations_;  // empty until they are first requested
  mutable Stamp motions_of_, accelerations_of_, open_joints_of_;
  mutable Connections connections_;         // of the tree when they were last asked for
  mutable MechanismNames mechanism_names_;  // when they were last asked for
  struct LoopValues {
    double q[7], v[6];
  };
  mutable std::vector<LoopValues> loop_values_;  // by loop, for the views of loop joints
};

/// The model without the bodies that were added to the world.
Model first_model(const World& world);
/// Names of the joints of a coupling in the model; the second one is empty if there is none.
std::pair<std::string, std::string> coupling_names(const World& world, CouplingId coupling);
/// True if the model's joint of that name broke, and `found`, which now has the name, is the free joint of the part that broke
/// off. Actions and conditions mean the joint that broke.
bool is_broken(const World& world, std::string_view name, JointId found);

}  // namespace momentree
