#pragma once
// Loop joints: joints in addition to those of the tree, which close kinematic loops. They are equations between the bodies that
// they join, not coordinates.
#include <momentree/joint/motion.hpp>
#include <momentree/model/coupling.hpp>
#include <momentree/model/ids.hpp>
#include <momentree/tree/declared.hpp>
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
  /// A motion is prescribed for it and not suspended by a lock.
  bool driven() const { return parameters.drive != nullptr && parameters.drive->moves() && joint.locked == 0; }
  /// Forces act along its DoFs: of its parameters, or of a function.
  bool forced() const { return parameters.any() || joint.function >= 0; }
  const Curve& motion() const { return parameters.drive->motion.front(); }
};

inline std::optional<LockedForm> locked_form(const Joint& joint, const Values& held) {
  return locked_form(spec_of(joint), joint.locked, held);
}

/// An equation of one DoF of a loop joint, in addition to those that keep the joint closed.
struct DofRow {
  enum class Use : unsigned char {
    motion,   ///< the DoF follows a prescribed motion
    lock,     ///< it is held, in a kind that has no other form for this
    armature  ///< soft: the multiplier is the inertial torque of the armature
  };
  int dof = 0;
  Use use = Use::motion;
  double armature = 0;  ///< kg m², kg
};

/// A loop as the recursions use it, or a coupling. Their equations are rows of one system, numbered consecutively: those of the
/// loops in their order (of each first the closure's, then those of single DoFs), then one of each coupling that acts.
struct LoopLink {
  Closure closure;
  std::array<DofRow, 6> dof_rows{};
  int dof_row_count = 0;
  KernelFrame child, parent;  ///< the joint's frames in the kernel frames of its bodies; for the ground in the world
  int first_row = 0, rows = 0;
  int coupled = 0;                       ///< the first loop that has a stop in common with this one; itself if no earlier one has
  CouplingEnds ends;                     ///< of a coupling, which uses nothing else but its row
  Pose child_offset{}, parent_offset{};  ///< of these frames from the joint's own, where locks displace them
};

/// A body between an end of a loop or coupling and the ground, with memory for its rows there.
struct LoopStop {
  int body = -1, loop = -1;  ///< by its place among the links
  int first_column = 0;      ///< of the loop's rows, consecutive
  int inboard = -1;          ///< the stop of the same loop at the parent; −1 at a root
};

}  // namespace momentree
