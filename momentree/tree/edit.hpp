#pragma once
// Elementary edits of a tree. Each relinks what it affects and creates a revision; none changes a state (topology/ does that) or,
// unless stated, allocates. Joints are packed in the order of their numbers, so re-rooting moves no coordinate.
#include <memory>
#include <vector>

#include <momentree/tree/tree.hpp>

namespace momentree {

class Tree::Edit {
 public:
  explicit Edit(Tree& tree) : tree_(tree) {}

  /// Makes the inboard joint of b a free joint to the ground, at the identity, without parameters: b's user frame is then its
  /// joint's frame.
  void detach(int b);
  /// Makes b the root of its tree, whose root joint must be free. Reverses the joints in between; b gets the free joint.
  void reroot(int b);
  /// Re-roots the tree of b at b and attaches it to `parent`, in another tree or the ground; the free joint becomes `joint`.
  void attach(int b, int parent, const Joint& joint, bool reversed);
  /// Removes root b and all bodies outboard of it; their numbers are not used again.
  void remove(int b);
  /// Adds a body, given in the complete form of Model::operator[], and returns the new number of the body and its joint. Storage
  /// for every later topology grows: workspaces must be made anew.
  int add(const BodySpec& spec);

  /// Replaces the inboard joint of b; joint.parameters is an index as the caller wants it. The direction stays.
  void set_joint(int b, const Joint& joint) { set_joint(b, joint, tree_.reversed(b)); }
  /// The same for a joint whose declared child is b or, if reversed, b's parent (which must not be the ground).
  void set_joint(int b, const Joint& joint, bool reversed);
  /// Sets the parameters of b's joint alone.
  void set_parameters(int b, const JointParameters& parameters);
  /// Sets the function that drives b's joint, or null for none. It stays with the joint until that is replaced by another.
  /// Allocates.
  void set_function(int b, std::shared_ptr<const JointFunction> function);
  /// Sets the function that acts on body b, or null for none. It stays until b is removed, whatever b is attached to. Allocates.
  void set_body_function(int b, std::shared_ptr<const BodyFunction> function);
  /// Sets the gravity (m/s², world axes).
  void set_gravity(const Vec3& gravity);

  /// Adds a loop joint, whose `number` is assigned if it is negative, and returned; removes one; replaces joint and parameters.
  /// May allocate.
  int add_loop(Loop loop);
  void remove_loop(int number);
  void set_loop(int number, const Joint& joint, const JointParameters& parameters, const Values& held = {});
  /// Sets the function that drives a loop joint, or null for none: as set_function(), which it stays if the joint becomes one of
  /// the tree. Allocates.
  void set_loop_function(int number, std::shared_ptr<const JointFunction> function);
  void end_coupling(int coupling);
  /// Sets the contacts that are closed, between bodies of the tree. May allocate.
  void set_contacts(std::vector<Contact> contacts);
  void break_spring(int spring);
  void set_spring_law(int spring, const SpringLaw& law);

  /// Sets the topology of the tree, which must be compiled from the same model as `topology` was. Creates a revision like every
  /// edit: earlier evaluations are stale, even if the topology is the same. O(bodies); allocates only if bodies were added.
  void restore(const Topology& topology);

  /// The tree becomes a copy of `other` in which every joint with parameters uses armature kernels, whether or not it has
  /// armature: armature() then holds the whole inertia of these joints apart from the bodies'. O(bodies); copying the same bodies
  /// again allocates nothing.
  void copy_with_armatures(const Tree& other);
  /// Write access to the armature per DoF, for an integration method that changes it between evaluations at bare arrays: no state
  /// belongs to the tree afterwards. Valid until the tree is next changed or copied to.
  double* armature();
  /// Joints with specialised kernels use the generic functions, as locked joints do, although nothing is locked: the reference
  /// for those kernels in tests.
  void use_generic_kernels();

 private:
  Tree& tree_;
};

inline Tree::Edit Tree::edit() { return Edit(*this); }

}  // namespace momentree
