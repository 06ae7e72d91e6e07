#pragma once
// Chooses the joints that form the tree of a model with closed loops.
#include <cstddef>
#include <vector>

namespace momentree::io {

/// A joint between two different links; a parent of −1: the ground.
struct SpanningEnds {
  int parent = -1, child = -1;
  int rows = 6;           ///< number of DoFs that it blocks
  std::size_t joint = 0;  ///< what spanning_joints() calls it
};

/// By link: the joint that joins it to its parent in the tree, −1 for a root. Joints keep their direction. A link with several
/// inboard joints keeps the one that blocks most DoFs, as a loop joint with few rows costs less; among equal ones that with the
/// parent nearest to the root, which makes paths short; then the first. Of a cycle that no other link leads to, the first link is
/// a root.
std::vector<int> spanning_joints(std::size_t links, const std::vector<SpanningEnds>& joints);

}  // namespace momentree::io
