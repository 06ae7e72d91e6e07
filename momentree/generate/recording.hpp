#pragma once
// What the recordings of kernels on symbols have in common.
#include <vector>

#include <momentree/derive/symbolic.hpp>
#include <momentree/dynamics/workspace.hpp>
#include <momentree/generate/kernel.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::detail {

/// Appends the nodes of n results.
inline void take(const auto& results, int n, std::vector<int>& nodes) {
  for (int i = 0; i < n; ++i) nodes.push_back(results[static_cast<std::size_t>(i)].node());
}

/// By DoF, whether it is locked without a prescribed motion.
inline std::vector<bool> resting(const Tree& tree) {
  std::vector<bool> all(static_cast<std::size_t>(tree.nv()));
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      all[static_cast<std::size_t>(tree.first_p(b) + i)] = ((tree.link(b).locked & ~tree.link(b).driven) >> i & 1u) != 0;
  return all;
}

/// Gives a workspace the table of steps with which stages of a tree are recorded. Throws std::bad_alloc.
void record_steps(const Tree& tree, Variables variables, Workspace<Symbolic>& workspace);
/// The same for passes in velocities that keep results.
void record_kept_steps(const Tree& tree, Workspace<Symbolic>& workspace);

}  // namespace momentree::detail
