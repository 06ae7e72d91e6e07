#pragma once
// The tree as the recursions traverse it: runs of bodies with the same kernels.
#include <momentree/joint/link_constants.hpp>
#include <momentree/tree/kernel_frame.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Flags of a body in the order. The order is depth-first, so the first child follows its parent directly: its contribution is
/// still in local variables in the inward pass, as is its parent's output in the outward pass. Only other children use memory.
namespace node {
enum : unsigned char {
  leaf = 1,         ///< it has no child
  branching = 2,    ///< it has several
  first_child = 4,  ///< the parent's first child, directly after it in the order
  root = 8,         ///< attached to the ground
  last_child = 16,  ///< the parent's last of several children: the first to be processed in the inward pass
  aligned = 32,     ///< its link needs no rotation about the parent's z
  grounded = 64,  ///< attached to the ground, directly or by welds alone: in a stage, in which nothing inboard of it is computed,
                  ///< it is a root
};
}  // namespace node

}  // namespace momentree
