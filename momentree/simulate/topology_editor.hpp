#pragma once
// Changes of one world at one instant, with their books: what actions are made of.
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/simulate/action.hpp>
#include <momentree/simulate/event.hpp>
#include <momentree/simulate/world.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

/// What a joint shall become, found before anything of the instant has changed it.
struct JointPlan {
  Joint joint;
  Values q;
};

/// A freedom of a joint, from the joint's frame after its motion to the declared child's: about its origin, in its axes.
Motion<double> seen_from_child(const Joint& joint, const Motion<double>& dof);

class TopologyEditor {
 public:
  /// `rehearsal`: coordinates are not those of the instant, and nothing is judged by them.
  explicit TopologyEditor(World& world, bool dry_run = false);

  /// What follows belongs to this event; a joint that is made gets that name.
  void begin(Event& event, std::string made_name);
  /// Writes what the joints of the event transmitted into its certificate, and which of them it made and changed.
  void certify(Event& event);

  const World& world() const { return world_; }
  const Tree& tree() const { return world_.tree_; }
  /// Number of the present joint of that name, −1: there is none.
  int joint(std::string_view name) const;
  /// Number of a body of this world, −1: the ground, −2: there is none.
  int body(std::string_view name) const;
  const std::string& joint_name(int number) const { return world_.names_.joint(number); }
  std::string body_name(int body) const;
  std::string mechanism_of(int body) const;
  const Joint& declared(int joint) const { return tree().joint(tree().carrier(joint)); }
  Values coordinates(int joint) const;
  /// Freedoms that are locked: those that rest on a stop apart.
  unsigned locked(int joint) const { return declared(joint).locked & ~world_.held(joint); }
  /// User's frame of a body (−1: the ground) in the world; of a joint's declared child in its declared parent.
  Pose pose(int body);
  Pose joint_pose(int joint);
  /// Spatial velocities that a joint allows, locked freedoms apart: about the child's origin, in its axes.
  std::vector<Motion<double>> dofs(const Joint& joint, const Values& q) const;

  // What changes no velocity: energy can only leave with springs and rotors.
  void break_off(int joint);
  void unlock(int joint, unsigned dofs);
  void loosen(int joint, const JointPlan& plan);
  void reroot(int body);
  // Impacts.
  void lock(int joint, unsigned dofs);
  void become(int joint, const JointPlan& plan);
  /// Joins `body` to `to` (−1: the ground) by a joint at `at` in to's frame, the present pose its zero; whichever floats is
  /// re-rooted. Refused where that would close a loop.
  ActionResult attach(int body, int to, const JointSpec& joint, const std::optional<Pose>& at);
  /// A stop of the joint throws the freedom back; takes hold of it; lets go of it.
  void apply_restitution(int joint, int dof, double restitution);
  void engage_limit(int joint, int dof, int sign);
  void release_limit(int joint, int dof);
  // Energy from outside.
  void push(int body, const Vec3& force, const Vec3& torque, const Vec3& point);
  void set(int joint, const JointParameters& parameters);
  /// The same parameters, where their motion begins where the joint stands now: it does.
  JointParameters begun(int joint, JointParameters parameters) const;
  /// Whether a motion that these parameters prescribe can begin, or go on, where the joint stands now.
  ActionResult can_follow(int joint, const JointParameters& parameters) const;

  /// Plans by action, from before the first impact of the instant, and the joints that are let go until they are carried out:
  /// what hangs on such a joint is no less held for that.
  std::map<const ActionBase*, JointPlan> plans;
  std::set<int> loosened;
  double seconds = 0;  ///< spent in changes alone
  long changes = 0;
  double brought = 0;  ///< kinetic energy that came from outside: with impulses, and with parameters, such as an armature

  /// How far a joint may stand from where its motion begins (rad, m).
  static constexpr double motion_tolerance = 1e-6;

 private:
  bool drifts(int body) const;
  enum class Nature { workless, impact, outside };
  template <class Change>
  void carry_out(const Change& change, Nature nature);
  void remember_momenta();
  void book_impulses(const Impulse* applied);
  void evaluate() { world_.evaluate(); }
  /// The current event makes or changes that joint: to be called before it does.
  void touch(int joint);

  double work_of_motions();

  World& world_;
  bool rehearsal_;
  Event* event_ = nullptr;
  std::string made_name_;
  std::vector<Force<double>> before_;                            // Pb by body, user's frames
  std::map<const Event*, std::vector<Force<double>>> impulses_;  // by joint number, declared child's frame
  std::map<const Event*, std::map<int, std::string>> touched_;   // by joint number its name before the event
};

}  // namespace momentree
