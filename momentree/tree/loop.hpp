#pragma once
// Loop joints: joints in addition to those of the tree, which close kinematic loops. They are equations between the bodies that
// they join, not coordinates.
#include <momentree/joint/motion.hpp>
#include <momentree/tree/declared.hpp>
#include <momentree/tree/ids.hpp>
#include <momentree/tree/kernel_frame.hpp>

namespace momentree {

/// A loop joint between its declared child and parent (−1: the ground).
struct Loop {
  int number = -1;  ///< its handle is first_loop + number
  int body = -1, to = -1;
  Joint joint;  ///< its `parameters` are unused
  JointParameters parameters;
  Values held{};  ///< coordinates at which the locked DoFs of `joint` are held

  JointId id() const { return {first_loop + number}; }
};

inline std::optional<LockedForm> locked_form(const Joint& joint, const Values& held) {
  return locked_form(spec_of(joint), joint.locked, held);
}

/// A loop as the recursions use it. Its equations are rows of one system, numbered consecutively in the order of the loops.
struct LoopLink {
  Closure closure;
  KernelFrame child, parent;  ///< the joint's frames in the kernel frames of its bodies; for the ground in the world
  int first_row = 0, rows = 0;
  int coupled = 0;                       ///< the first loop that has a stop in common with this one; itself if no earlier one has
  Pose child_offset{}, parent_offset{};  ///< of these frames from the joint's own, where locks displace them
};

/// A body between an end of a loop and the ground, with memory for the loop's rows there.
struct LoopStop {
  int body = -1, loop = -1;  ///< the loop by its place in the list
  int first_column = 0;      ///< of the loop's rows, consecutive
  int inboard = -1;          ///< the stop of the same loop at the parent; −1 at a root
};

}  // namespace momentree
