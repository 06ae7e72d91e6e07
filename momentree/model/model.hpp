#pragma once
// The model as the user declares it: named bodies, joints, placements. Checked as it is built; never used inside a step.
#include <concepts>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/copy_on_write.hpp>
#include <momentree/base/error.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/math/vec.hpp>
#include <momentree/model/body_force.hpp>
#include <momentree/model/collider.hpp>
#include <momentree/model/coupling.hpp>
#include <momentree/model/ids.hpp>
#include <momentree/model/joint_element.hpp>
#include <momentree/model/spring.hpp>

namespace momentree {

/// A body with its inboard joint, SI units. The joint's frame is located at `at` in the parent's frame (parent side) and at
/// `child_at` in the body's own frame (child side; identity: the body's frame is the joint's child-side frame).
struct BodySpec {
  std::string name;  ///< "mechanism/body"
  double mass = 0;   ///< kg
  Vec3 com{};        ///< centre of mass (m), body axes
  Sym3 inertia{};    ///< about the centre of mass (kg m²), body axes: diagonal(…) or {xx, yy, zz, xy, xz, yz}
  BodyId parent = ground;
  Pose at{};
  JointSpec joint{};  ///< Revolute{…}, Ball{…}, …; default: a weld
  Values q{};         ///< start coordinates; empty: zero (within stops), or what closes loops; overridden by a prescribed motion
  Values v{};         ///< start velocities; empty: zero, or what loops allow; overridden by a prescribed motion
  Pose child_at{};
  std::string joint_name{};  ///< "mechanism/joint"; empty: the body's name
};

/// A joint that closes a loop: between two bodies of the model, or a body and the ground, in addition to their inboard joints.
/// Its frame is at `at` in the frame of `to` (parent side) and at `child_at` in that of `body` (child side).
struct LoopSpec {
  std::string name;  ///< unique among the joints
  BodyId body, to = ground;
  JointSpec joint{};  ///< any kind but `free`
  Pose at{}, child_at{};
  /// A simulation starts from the nearest coordinates at which the loop is closed; false: an Error if it is open at the start.
  bool assemble = true;
};

namespace detail {
/// Hash that allows look-up of names without copying them.
struct NameHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view name) const { return std::hash<std::string_view>{}(name); }
};
}  // namespace detail

class Tree;

namespace detail {
/// Holds the tree of a model once it is compiled. Copies of the model share it.
class CompiledOnce;
std::shared_ptr<CompiledOnce> not_compiled();
/// Before a model changes: from then on it has a tree of its own, which is not compiled yet.
void forget(std::shared_ptr<CompiledOnce>& compiled);
}  // namespace detail

/// The mechanisms of one world. Copies share their bodies until one of them changes. `add` throws Error for faults of a single
/// body; faults of the whole model (a singular joint-space mass) are found by `singular_joints`.
class Model {
 public:
  struct Options {
    Vec3 gravity{0, 0, -9.81};
  };
  Model() = default;
  /// Throws Error for a gravity (m/s², world axes) that is not finite.
  explicit Model(Options options) { set_gravity(options.gravity); }

  /// Adds a body; its parent must have been added before. Throws Error: no or duplicate name, unknown parent, impossible mass or
  /// inertia, zero axis, wrong number of coordinates.
  BodyId add(BodySpec spec);
  /// The same without checking the inertia by itself: check_masses() checks it together with the bodies that are rigidly joined
  /// to it. Real robots have odd links in sound groups.
  BodyId add_unjudged(BodySpec spec);

  /// Adds a force on a body of this model; a body may have several. Throws Error: no such body, a number that is not finite, a
  /// negative drag.
  void add_force(BodyForce force);
  const std::vector<BodyForce>& forces() const { return forces_; }

  /// Adds a loop joint between bodies of this model. Throws Error: no or duplicate name, unknown or equal bodies, an impossible
  /// joint, parameters that loop joints do not support.
  JointId add_loop(LoopSpec spec);
  const std::vector<LoopSpec>& loops() const { return loops_; }
  /// Adds an exact coupling of joints of this model. At the start a joint that is coupled takes the position and velocity that
  /// follow from the joint that it follows, not its own. Throws Error: no such joint, a joint that closes a loop or does not have
  /// one DoF, a joint that follows itself, numbers that are not finite, joints whose motions are all prescribed.
  CouplingId add_coupling(const Coupling& coupling);
  const std::vector<Coupling>& couplings() const { return couplings_; }
  /// Adds an element between joints of this model. Throws Error: no such joint, a joint that closes a loop, does not have one DoF
  /// or has a prescribed motion, the same joint twice, numbers outside of their ranges.
  void add_element(JointElement element);
  const std::vector<JointElement>& elements() const { return elements_; }
  /// Adds a spring between two points of different bodies of this model, or of the ground. Throws Error: no name, or one that
  /// another spring or a joint has; no such body; an end that is not finite, or both ends on one body; a negative stiffness,
  /// damping or rest length; a strength that is not positive; neither stiffness nor damping.
  SpringId add_spring(Spring spring);
  /// Adds an inextensible cable between two points, which is then one of the springs. Throws Error like add_spring, and for a
  /// length that is not positive or a restitution outside of 0 to 1.
  SpringId add_cable(Cable cable) { return add_spring(spring_of(std::move(cable))); }
  /// The springs and cables as added, with their rest lengths.
  const std::vector<Spring>& springs() const { return springs_; }
  /// The spring of that name; throws Error with a suggestion.
  SpringId spring(std::string_view name) const;
  bool has_spring(std::string_view name) const;

  /// Adds a solid, or a plane of the ground, that other bodies can touch. Throws Error: no such body, a plane of a body other
  /// than the ground, a size that is not positive, a solid without volume.
  ColliderId add_collider(Collider collider);
  const std::vector<Collider>& colliders() const { return colliders_; }
  /// True with solids or cables: there may be one-sided contacts.
  bool has_contact() const { return !colliders_.empty() || has_cables_; }
  /// Adds a rule for contacts of bodies; of several for one pair of bodies the last one applies. Throws Error: a negative
  /// friction, a restitution outside of 0 to 1, no such body.
  void add_contact_rule(ContactRule rule);
  const std::vector<ContactRule>& contact_rules() const { return contact_rules_; }
  /// The rule for contacts between two bodies, or a body and the ground; null: none applies.
  const ContactRule* contact_rule(BodyId one, BodyId other) const;
  /// Its law; without a rule the default law.
  ContactLaw contact_law(BodyId one, BodyId other) const;

  /// Reserves space for that many bodies in total.
  void reserve(int count);

  /// Removes all bodies but the first `count` (≥ 0), with the forces and springs on them, their loops and couplings.
  void keep(int count);

  Vec3 gravity() const { return gravity_; }
  /// Throws Error for numbers that are not finite.
  void set_gravity(Vec3 gravity);
  int size() const { return static_cast<int>(bodies_->size()); }
  /// The name of a body, or "ground".
  std::string body_name(BodyId body) const { return body == ground ? "ground" : (*this)[body].name; }
  /// The body as added, but with unit axes, a joint name, and unit quaternions.
  const BodySpec& operator[](BodyId body) const {
    MT_REQUIRE(body.index >= 0 && body.index < size(), "a body of this model, as add() returned it");
    return (*bodies_)[static_cast<std::size_t>(body.index)];
  }
  const std::vector<BodySpec>& bodies() const { return *bodies_; }

  /// The inboard joint of a body, the child of a joint.
  JointId inboard_joint(BodyId body) const { return {body.index}; }
  BodyId child(JointId joint) const { return {joint.index}; }
  /// The child of that joint.
  template <std::same_as<JointId> Joint>  // so that {number} means a body
  const BodySpec& operator[](Joint joint) const {
    return (*this)[child(joint)];
  }

  /// The joint of that number, in the tree or closing a loop.
  const JointSpec& joint_spec(JointId joint) const { return is_loop(joint) ? loop(joint).joint : (*this)[child(joint)].joint; }
  const LoopSpec& loop(JointId joint) const {
    const int place = joint.index - first_loop;
    MT_REQUIRE(place >= 0 && place < static_cast<int>(loops_.size()), "a loop joint of this model, as add_loop() returned it");
    return loops_[static_cast<std::size_t>(place)];
  }
  /// The child of a joint, in the tree or closing a loop.
  BodyId body_of(JointId joint) const { return is_loop(joint) ? loop(joint).body : child(joint); }

  /// The body or joint of that name; throws Error with a suggestion.
  BodyId body(std::string_view name) const;
  JointId joint(std::string_view name) const;
  bool has_body(std::string_view name) const { return by_body_->find(name) != by_body_->end(); }
  bool has_joint(std::string_view name) const { return by_joint_->find(name) != by_joint_->end(); }

  /// The tree of this model, compiled when it is first needed. Copies of the model share it until one of them changes. Threads
  /// may ask for it at once. The reference is valid until this model changes or ends.
  const Tree& compiled() const&;
  const Tree& compiled() const&& = delete;

  /// Name of the mechanism whose root at the start is `root`: the part of the root's name before the first '/'. It is the whole
  /// name if there is no '/', or if an earlier root has that part already.
  std::string mechanism_name(BodyId root) const;

 private:
  using Numbers = std::unordered_map<std::string, int, detail::NameHash, std::equal_to<>>;

  Vec3 gravity_{0, 0, -9.81};
  detail::CopyOnWrite<std::vector<BodySpec>> bodies_;
  std::vector<BodyForce> forces_;
  std::vector<LoopSpec> loops_;
  std::vector<Coupling> couplings_;
  std::vector<JointElement> elements_;
  std::vector<Spring> springs_;
  bool has_cables_ = false;  // among them
  std::vector<Collider> colliders_;
  std::vector<ContactRule> contact_rules_;
  detail::CopyOnWrite<Numbers> by_body_, by_joint_, by_mechanism_;  // the last: the first root with that name
  std::shared_ptr<detail::CompiledOnce> compiled_ = detail::not_compiled();
};

/// True with loop joints or couplings: the model has equations beside its tree.
inline bool has_equations(const Model& model) { return !model.loops().empty() || !model.couplings().empty(); }
/// True if two bodies also touch while a joint connects them: a rule names both.
bool touch_while_joined(const Model& model, BodyId one, BodyId other);

/// A fault of a single body other than its inertia. `field` is the scenario key at fault, of the body or of its joint.
struct BodyProblem {
  std::string field, what, hint;
};
std::vector<BodyProblem> check_body(const BodySpec& spec);

/// The fault of a mass (kg) and an inertia about the centre of mass (kg m²); `what` is empty if there is none. `warning`: merely
/// odd, that is, beyond the triangle inequality by no more than the rounding of CAD values.
struct MassProblem {
  std::string what, hint;
  bool warning = false;
};
MassProblem check_mass(double mass, const Sym3& inertia);

/// The faults of a loop joint between bodies of a model of that size, other than its name.
std::vector<BodyProblem> check_loop(const LoopSpec& spec, int bodies);

/// Checks the inertia of every body together with the bodies rigidly joined to it (by welds, at the start): a fault is a warning
/// if the group as a whole is sound. Parents must come before their children. One entry per faulty body.
struct GroupMassProblem {
  BodyId body;
  MassProblem problem;
};
std::vector<GroupMassProblem> check_masses(std::span<const BodySpec> bodies);

/// The faults of a single joint (zero axis, parallel axes, negative or too many parameters); empty if there are none. `field` is
/// the scenario key at fault.
struct JointProblem {
  std::string field, what, hint;
};
std::vector<JointProblem> check_joint(const JointSpec& joint);

/// A joint at which the joint-space mass is singular at the start. Empty list if there are none.
struct SingularJoint {
  BodyId body;
  std::string what, hint;
};
std::vector<SingularJoint> singular_joints(const Model& model);

}  // namespace momentree
