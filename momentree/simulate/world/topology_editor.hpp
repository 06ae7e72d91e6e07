#pragma once
// Topology changes of one world at one instant, with their accounting: the operations of which actions are composed.
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/events/event.hpp>
#include <momentree/simulate/world/world_edit.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/new_joint.hpp>

namespace momentree {

/// The joint that results from a change, planned before anything of the instant has changed the old one.
struct JointPlan {
  Joint joint;
  Values q;
  bool keeps_parameters = false;
};

/// An impulse from outside on a body, in world axes.
struct AppliedImpulse {
  int body = -1;
  Vec3 force{}, torque{}, point{};  ///< N s, N m s, m
};

/// A DoF of a joint, transformed from the joint's moving frame to the declared child's frame: about its origin, in its axes.
Motion<double> seen_from_child(const Joint& joint, const Motion<double>& dof);

/// By number of a coupling: 1 if it acts.
std::vector<unsigned char> acting_couplings(const Tree& tree);

class TopologyEditor {
 public:
  /// `dry_run`: coordinates are not those of the instant, so nothing may be judged by them.
  explicit TopologyEditor(World& world, bool dry_run = false);

  /// The following changes belong to this event; a joint that is made gets that name.
  void begin(Event& event, std::string made_name);
  /// Writes the impulses transmitted by the joints at the event, and the joints that the event made and changed, into its
  /// certificate.
  void certify(Event& event);
  /// Adds what happened in `part`, which is no event of its own, to the certificate of an event that has one.
  void certify_part(const Event& part, Event& event);

  const World& world() const { return world_; }
  const Tree& tree() const { return edit_.tree(); }
  /// Number of the joint that has that name now; −1: there is none.
  int joint(std::string_view name) const;
  /// The parameters of a joint, in the tree or closing a loop; null: there are none.
  const JointParameters* parameters(int joint) const;
  /// Number of a body of this world; −1: the ground; −2: there is none.
  int body(std::string_view name) const;
  /// Number of the spring of that name, broken or not; −1: there is none.
  int spring(std::string_view name) const { return world_.find_spring(name); }
  std::string mechanism_of(int body) const;
  const Joint& declared(int joint) const { return is_loop({joint}) ? loop_of(joint).joint : tree().joint(tree().carrier(joint)); }
  /// Whether a joint, which may close a loop, supports these parameters; otherwise the result of the action.
  ActionResult supports(int joint, const JointParameters& parameters) const;
  /// Whether coordinates of a joint are between the hard stops of these limits. In a dry run only those that are `known` count.
  ActionResult is_within(const Values& q, const JointLimits& limits, bool known = false) const;
  /// Whether hard stops can stop the joints that couplings connect with this one if it has these parameters.
  ActionResult can_be_stopped(int joint, const JointParameters& parameters) const;
  /// Whether the prescribed motions of joints in loops are independent now.
  ActionResult can_move() const;
  Values coordinates(int joint) const;
  /// Locked DoFs, except those that rest on a stop.
  unsigned locked(int joint) const { return declared(joint).locked & ~world_.constraints().held(joint); }
  /// Pose of a joint's declared child in its declared parent.
  Pose joint_pose(int joint);
  /// Spatial velocities that a joint allows, except in locked DoFs: about the child's origin, in its axes.
  std::vector<Motion<double>> dofs(const Joint& joint, const Values& q) const;

  // Changes of no velocity: energy is removed only with springs and armatures.
  /// If a loop still holds the part that comes off, the loop's joint takes the place of this one in the tree.
  void break_off(int joint);
  void break_spring(int spring);
  void unlock(int joint, unsigned dofs);
  void loosen(int joint, const JointPlan& plan);
  void reroot(int body);
  // Impacts.
  void lock(int joint, unsigned dofs);
  void become(int joint, const JointPlan& plan);
  /// Joins `body` to `to` (−1: the ground) by a joint at `at` in `to`'s frame, with the present pose as its zero; a floating
  /// mechanism is re-rooted if necessary. Within a mechanism, or between grounded ones, the joint closes a loop.
  ActionResult attach(int body, int to, const JointSpec& joint, const std::optional<Pose>& at);
  /// A stop of the joint makes the DoF rebound; locks it; releases it.
  void apply_restitution(int joint, int dof, double restitution);
  /// Applies impulses of contacts: generalised impulses, packed as p, which are those of `applied` on the bodies and of the
  /// opposite impulses `on_ground`, for the certificate.
  void apply_contact_impulses(const std::vector<double>& generalised, std::span<const AppliedImpulse> applied,
                              std::span<const AppliedImpulse> on_ground);
  void engage_limit(int joint, int dof, int sign);
  void release_limit(int joint, int dof);
  // Energy from outside.
  void push(int body, const Vec3& force, const Vec3& torque, const Vec3& point);
  void set(int joint, const JointParameters& parameters);
  /// Sets the law of a spring from those parameters that are given; refuses those that a spring does not have.
  ActionResult set_spring(int spring, const JointParameters& given);
  /// The same parameters, with a motion that is to begin at the joint's present position anchored there.
  JointParameters begun(int joint, JointParameters parameters) const;
  /// Whether a motion that these parameters prescribe can begin or resume at the joint's present position.
  ActionResult can_follow(int joint, const JointParameters& parameters) const;

  /// Plans by action, made before the first impact of the instant, and the joints that are released until the actions are carried
  /// out; bodies that such a joint carries still count as held.
  std::map<const ActionBase*, JointPlan> plans;
  std::set<int> loosened;
  /// What the changes so far amount to.
  struct Account {
    double seconds = 0;  ///< time spent in changes alone
    long changes = 0;
    double brought = 0;  ///< kinetic energy from outside: from impulses, and from parameters such as an armature
  };
  const Account& account() const { return account_; }

 private:
  const std::string& joint_name(int number) const { return edit_.names().joint(number); }
  std::string body_name(int body) const;
  /// The loop joint of that number, which must exist.
  const Loop& loop_of(int joint) const;
  /// User frame of a body (−1: the ground) in the world.
  Pose pose(int body);
  void leave_changed_stops(int joint, const JointLimits& limits);
  bool drifts(int body) const;
  ActionResult close_loop(int body, int to, const JointSpec& spec, const std::optional<Pose>& at);
  void hold_by_loop(int body);
  void break_loop(JointId loop);
  void lock_loop(int joint, unsigned locked);
  void change_loop(int joint, const JointPlan& plan, bool impact);
  Turns turns_of_loop(int joint) const;
  void end_couplings(int joint);
  void note_ended_couplings(const std::vector<unsigned char>& before);
  void book_coupling_impulses();
  enum class Nature { workless, impact, outside };
  template <class Change>
  void carry_out(const Change& change, Nature nature);
  void remember_momenta();
  void book_impulses(std::span<const AppliedImpulse> applied);
  void add_impulses(const Event& part, Event& event);
  void evaluate() { edit_.evaluate(); }
  /// Call before the current event makes or changes that joint.
  void touch(int joint);

  ActionResult already_joined(int body, int to, int joint) const;
  // A refusal if the name of the joint that is to be made is in use.
  std::optional<ActionResult> name_taken(int body, int to) const;
  double work_of_motions();
  // The impulse of a loop on its body, about the origin of body b and in its axes. The bodies have been located.
  Force<double> impulse_about(int b, const LoopImpulse& given) const;

  World& world_;
  World::Edit edit_;
  Account account_;
  bool dry_run_;
  Event* event_ = nullptr;
  std::string made_name_;
  std::vector<Force<double>> before_;                                           // Pb by body, user frames
  std::map<const Event*, std::vector<Force<double>>> impulses_;                 // by joint number, declared child's frame
  std::map<const Event*, std::map<std::string, Force<double>>> loop_impulses_;  // by the name of the loop joint
  std::vector<LoopImpulse> loop_impulses_now_;                                  // of the last change, by loop
  std::vector<CouplingImpulse> coupling_impulses_now_;                          // and by coupling that acts
  std::map<const Event*, std::set<int>> touched_;  // numbers of joints that the event makes or changes
  std::map<int, std::string> names_at_start_;      // of these joints, before the first of all events
};

}  // namespace momentree
