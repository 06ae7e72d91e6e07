#pragma once
// The tree as the recursions traverse it: runs of bodies with the same kernels.
#include <span>

#include <momentree/joint/body_pair.hpp>
#include <momentree/joint/link_constants.hpp>
#include <momentree/tree/kernel_frame.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// A run of bodies in the order whose joints use the same kernels: order[begin] … order[end − 1], including branching bodies and
/// leaves.
struct KernelRun {
  int begin = 0, end = 0;
  Kind kind = Kind::weld;
  Variant variant = Variant::plain;
  bool planar = false;  ///< the run is one complete plane mechanism: a grounded tree of plain revolute joints with parallel axes
  int pair = -1;        ///< start of the corresponding run in the isomorphic branch paired with this one; −1: none
  bool branch = false;  ///< the run starts such a branch
  int links = 0;        ///< index in Tree::paired_links of the constants of its first body and that body's partner
  int plane = -1;       ///< place of the root of the floating plane mechanism to which the run belongs; −1: none
  int plane_end = 0;    ///< end of that mechanism in the order
};
/// The run that is processed together with this one.
inline KernelRun pair_of(const KernelRun& s) {
  return {s.pair, s.pair + s.end - s.begin, s.kind, s.variant, s.planar, s.begin, s.branch, s.links, s.plane, s.plane_end};
}

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

inline std::span<const KernelRun> Tree::kernel_runs() const { return runs_; }
inline std::span<const KernelRun> Tree::paired_runs() const { return has_pairs_ ? paired_runs_ : runs_; }
inline std::span<const PairedLinks> Tree::paired_links() const { return paired_links_; }

}  // namespace momentree
