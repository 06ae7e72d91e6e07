#pragma once
// What the user said: named bodies, joints, placements. Checked as it is built; never used inside a step.
#include <concepts>
#include <functional>
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
#include <momentree/tree/body_force.hpp>
#include <momentree/tree/ids.hpp>

namespace momentree {

/// A body with its inboard joint, SI units. Frames: the joint's frame stands at `at` in the parent's frame, and at `child_at` in
/// the body's own frame (identity: the body's frame is the joint's frame after its motion).
struct BodySpec {
  std::string name;  ///< "mechanism/body"
  double mass = 0;   ///< kg
  Vec3 com{};        ///< centre of mass, body axes
  Sym3 inertia{};    ///< about the centre of mass, body axes: diagonal(…) or {xx, yy, zz, xy, xz, yz}
  BodyId parent = ground;
  Pose at{};
  JointSpec joint{};  ///< Revolute{…}, Ball{…}, …; default: a weld
  Values q{};         ///< start coordinates in the order of the kind; empty: zero (identity); a prescribed motion says its own
  Values v{};         ///< start velocities; empty: zero; a prescribed motion says its own
  Pose child_at{};
  std::string joint_name{};  ///< "mechanism/joint"; empty: the body's name
};

/// Names are looked up without being copied.
struct NameHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view name) const { return std::hash<std::string_view>{}(name); }
};

/// The mechanisms of one world. Copies share their bodies until one of them changes. `add` throws Error for what is wrong with
/// one body; `validate` finds what only the whole shows (a joint-space mass that would be singular).
class Model {
 public:
  struct Options {
    Vec3 gravity{0, 0, -9.81};
  };
  Model() = default;
  /// Throws Error for a gravity that is not finite.
  explicit Model(Options options) { set_gravity(options.gravity); }

  /// Adds a body; the parent must have been added before.
  /// Throws Error: no or duplicate name, unknown parent, mass or inertia impossible, zero axis, wrong number of coordinates.
  BodyId add(BodySpec spec);
  /// The same for a body whose inertia is judged with what it is rigidly joined to, by check_masses(): real robots have odd
  /// single links in sound groups.
  BodyId add_unjudged(BodySpec spec);

  /// Adds a force on a body of this model: as many as one likes.
  /// Throws Error: no such body, a number that is not finite, a negative drag.
  void add_force(BodyForce force);
  const std::vector<BodyForce>& forces() const { return forces_; }

  /// Makes room for so many bodies in all.
  void reserve(int count);

  /// Forgets the bodies that were added after the first `count`, and forces on them; none of those may hang on them.
  void keep(int count);

  Vec3 gravity() const { return gravity_; }
  /// Throws Error for numbers that are not finite.
  void set_gravity(Vec3 gravity);
  int size() const { return static_cast<int>(bodies_->size()); }
  /// As added, but with unit axes, full q and v (never empty), a joint name, and unit quaternions.
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

  /// The body or joint of that name; throws Error with a suggestion.
  BodyId body(std::string_view name) const;
  JointId joint(std::string_view name) const;
  bool has_body(std::string_view name) const { return by_body_->find(name) != by_body_->end(); }
  bool has_joint(std::string_view name) const { return by_joint_->find(name) != by_joint_->end(); }

  /// Name of the mechanism rooted at `root` at the start: what stands before the first '/' of its name; all of it where there is
  /// none, or where an earlier root has that name already.
  std::string mechanism_name(BodyId root) const;

 private:
  using Numbers = std::unordered_map<std::string, int, NameHash, std::equal_to<>>;

  Vec3 gravity_{0, 0, -9.81};
  CopyOnWrite<std::vector<BodySpec>> bodies_;
  std::vector<BodyForce> forces_;
  CopyOnWrite<Numbers> by_body_, by_joint_, by_mechanism_;  // the last: first root with that name
};

/// What is wrong with a body by itself, its inertia apart. `field` names the scenario key at fault: of the body or of its joint.
struct BodyProblem {
  std::string field, what, hint;
};
std::vector<BodyProblem> check_body(const BodySpec& spec);

/// What is wrong with a mass and an inertia about the centre of mass: empty if nothing. `warning` is set where it is only odd
/// (beyond the triangle inequality by less than a rounding of CAD values).
struct MassProblem {
  std::string what, hint;
  bool warning = false;
};
MassProblem check_mass(double mass, const Sym3& inertia);

/// Judges the inertia of every body together with those it is rigidly joined to (by welds, at the start): a problem is a warning
/// where the group as a whole is sound. Parents stand before their children. By body; empty if nothing is odd.
struct GroupMassProblem {
  BodyId body;
  MassProblem problem;
};
std::vector<GroupMassProblem> check_masses(std::span<const BodySpec> bodies);

/// What is wrong with a joint by itself (zero axis, parallel axes, negative or too many parameters): empty if nothing.
/// `field` names the scenario key at fault.
struct JointProblem {
  std::string field, what, hint;
};
std::vector<JointProblem> check_joint(const JointSpec& joint);

/// Joints at which the joint-space mass is singular at the start: what is wrong, by joint. Empty if none.
struct SingularJoint {
  BodyId body;
  std::string what, hint;
};
std::vector<SingularJoint> singular_joints(const Model& model);

}  // namespace momentree
