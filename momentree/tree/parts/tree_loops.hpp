#pragma once
// The loop joints of a tree and the couplings that act, with their form for the recursions.
#include <cstdint>
#include <vector>

#include <momentree/base/unique_number.hpp>
#include <momentree/tree/loop.hpp>

namespace momentree {

/// The loop joints, as a range in the order in which they were made, and what follows from them and the topology.
struct TreeLoops {
  std::vector<Loop> joints;
  std::vector<LoopLink> links;  ///< in the same order, followed by the couplings that act
  /// Bodies between the ends of loops and the ground, one entry per body and loop, inboard before outboard.
  std::vector<LoopStop> stops;
  int rows = 0, columns = 0;           ///< of all loops, and at all stops
  int motions = 0, armatures = 0;      ///< of the rows: of prescribed motions and of armatures of loop joints
  int functions = 0, next_number = 0;  ///< joints driven by a function; the number of the next joint
  detail::Version version;

  std::size_t size() const { return joints.size(); }
  bool empty() const { return joints.empty(); }
  auto begin() const { return joints.begin(); }
  auto end() const { return joints.end(); }
  const Loop& operator[](std::size_t place) const { return joints[place]; }
  const Loop& back() const { return joints.back(); }
  /// The place of a loop joint, or −1; the loop joint, or null.
  int place(JointId joint) const;
  const Loop* find(JointId joint) const;
  /// Identifies the equations of loops and couplings, and the bodies between their ends and the ground, as Tree::revision() does
  /// a tree. It may change more often than these do.
  std::uint64_t revision() const { return version.number(); }
};

}  // namespace momentree
