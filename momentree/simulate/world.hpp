#pragma once
// One world at one instant: model (names), tree (topology), state, and what the recursions found at this state.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <momentree/base/numbers.hpp>
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/totals.hpp>
#include <momentree/dynamics/workspace.hpp>
#include <momentree/simulate/names.hpp>
#include <momentree/topology/snapshot.hpp>
#include <momentree/tree/model.hpp>
#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// A joint as its user sees it, in its declared direction. Spans point into the world; valid until it next changes.
struct JointView {
  std::string_view name;
  Kind kind = Kind::weld;
  BodyId child, parent;   ///< as declared; parent.index −1: the ground
  bool reversed = false;  ///< its child carries its parent now, seen from the root
  unsigned locked = 0;    ///< a bit per freedom that is locked
  unsigned resting = 0;   ///< a bit per freedom that rests on a stop
  bool driven = false;    ///< its motion is prescribed, and not suspended by a lock
  Pose at, child_at;
  Vec3 axis, axis2;
  double pitch = 0;
  const JointParameters* parameters = nullptr;
  Numbers q, v, p, pdot;  ///< nq, nv, nv, nv numbers; p and pdot are zeros where it is driven
};

/// What a joint does and carries at an instant.
struct JointForces {
  Numbers a;  ///< time derivative of v: nv numbers (m/s², rad/s²); points into the world as in JointView
  /// By which the declared parent holds the declared child: about the origin of the child's frame (not of `at`), in its axes.
  /// `reaction`: all that goes through the joint, drive, spring and damping included; `pure`: without what acts along the
  /// joint's freedoms (momentree::pure_reaction), what its bearings and locks carry.
  Wrench reaction, pure;
  /// What acts along each freedom (nv numbers, N m or N): momentree::joint_effort; for a driven joint the effort that its motion
  /// takes.
  Values effort;
};

struct Mechanism {
  std::string_view name;
  BodyId root;
  bool grounded = true;
  std::vector<BodyId> bodies;  ///< root first, in evaluation order
};

/// A joint's freedom that rests on a stop (sign +1: the upper one).
struct ActiveLimit {
  int joint, dof, sign;
};

/// All that a world is at an instant: a small value to go back to and to branch from.
struct WorldSnapshot {
  Snapshot engine;
  std::vector<std::pair<int, std::string>> joint_names, mechanism_names;  ///< those that are not the model's
  std::vector<ActiveLimit> active_limits;
  std::vector<BodySpec> added;  ///< bodies that came after the start
};

/// Who hangs on whom by which joints, and what that is called, where it is not as the model has it: what a state document says
/// of the topology.
struct Forest {
  /// A joint that is not the model's of that number, or has another name.
  struct Changed {
    int joint = -1;
    std::string name;
    Joint as;  ///< without parameters
    JointParameters parameters;
  };
  std::vector<Topology::Place> places;                  ///< by body; empty: as in the model, and so are the names of mechanisms
  std::vector<Changed> changed;                         ///< in the order of numbers
  std::vector<std::pair<int, std::string>> mechanisms;  ///< by root
  std::vector<ActiveLimit> active_limits;
};

/// What a state document says of one joint: empty lists keep the start value. Where p is given it is used, and v is not.
struct JointStart {
  JointId joint;
  Values q, v, p;
};

/// Evaluates its state where it is asked for something that needs it: a world is used by one thread at a time, reading included.
class World {
 public:
  /// Compiles the model. Throws Error where a joint-space mass is singular.
  explicit World(const Model& model);

  const Model& model() const { return model_; }
  /// The model without the bodies that were added to the world.
  Model first_model() const;
  const Tree& tree() const { return tree_; }
  const State& state() const {
    MT_REQUIRE(!workspace_.in_function, inside_function);
    return state_;
  }
  double time() const { return state().time(); }

  /// These evaluate the state first where that has not been done.
  const CheckedVector<BodyMotion>& motions() const;  ///< by body number
  /// The joint of that number: at the start that of the body's, and the same joint for as long as it is there, whatever carries
  /// it then. Every world has a joint for each of its bodies.
  JointView joint(JointId joint) const;
  /// These cost another half of an evaluation, once for each state of which they are asked for, and nothing where they are not.
  /// By body number: time derivatives of `linear` and `angular` of its motion; zeros for a body that was removed.
  const std::vector<BodyAcceleration>& accelerations() const;
  JointForces joint_forces(JointId joint) const;
  Wrench reaction(JointId joint) const;  ///< the reaction alone
  /// Coordinate and velocity of a joint with one freedom; nothing for others.
  std::optional<std::pair<double, double>> single_dof(JointId joint) const;
  /// Number of the present joint of that name, −1 if there is none.
  int find_joint(std::string_view name) const { return names_.find_joint(name); }
  int find_joint(std::string_view name, std::atomic<int>& number) const { return names_.find_joint(name, number); }
  /// Another one whenever anything of the state or the topology has changed.
  Stamp stamp() const { return state_.stamp(); }
  Totals totals() const;
  /// Present mechanisms, in the order of their root's body number.
  std::vector<Mechanism> mechanisms() const;
  std::vector<std::string> mechanism_names() const;
  /// Name of the joint of that number: as declared; once the joint broke, that of the body that came off.
  std::string_view joint_name(JointId joint) const { return names_.joint(joint.index); }
  std::string_view mechanism_name(BodyId root) const { return names_.mechanism(root.index); }

  /// False for a body that was removed: any other use of its handle, or of its joint's, stops the program.
  bool alive(BodyId body) const { return body.index >= 0 && body.index < tree_.bodies() && tree_.alive(body.index); }

  /// Going back is exact to the last bit, across any number of changes.
  WorldSnapshot snapshot() const;
  void restore(const WorldSnapshot& snapshot);

  /// The model at `time`, its joints and bodies put together as `forest` says and start values replaced: what a state document
  /// restores. Quaternions are taken bit for bit: of length one, but for rounding. Joints that are not the model's start at zero
  /// where `joints` says nothing of them. The forest must be one: each joint carried once, no body outboard of itself.
  void restore(double time, const Forest& forest, std::span<const JointStart> joints);

  /// The first instant after t at which a table bends, infinite where there is none: steps end there.
  double next_bend(double t) const { return tree_.next_bend(t); }

  /// Freedoms that rest on stops.
  std::span<const ActiveLimit> active_limits() const { return active_limits_; }

 private:
  friend class Simulation;
  friend class TopologyEditor;
  friend class Stops;
  void put_together(const Forest& forest);
  void put_values(double time, const Forest& forest, std::span<const JointStart> joints, State& state) const;
  void evaluate() const;
  int carrier(JointId joint) const;
  BodyId add(BodySpec spec);
  void remove(BodyId body);
  void make_room();
  void drive(int joint, JointFunction function);
  void load(int body, BodyFunction function);
  void set_time(double time);
  void set_gravity(Vec3 gravity);
  int held(int joint, int dof) const;
  unsigned held(int joint) const;
  void forget_active_limits();

  Model model_;
  int first_bodies_ = 0;    // those that the world was made with
  Names declared_, names_;  // as the model has them, and now
  std::vector<ActiveLimit> active_limits_;
  Tree tree_;
  State state_;
  mutable Workspace<double> workspace_;
  mutable CheckedVector<BodyMotion> motions_;
  mutable std::vector<BodyAcceleration> accelerations_;  // none until they are asked for
  mutable Stamp motions_of_, accelerations_of_;
};

}  // namespace momentree
