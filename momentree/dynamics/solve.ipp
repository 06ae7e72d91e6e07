#pragma once
// Further right-hand sides for the factors of the first recursion: M u = r, by one inward and one outward pass in O(n). Included
// only by instantiate/*.cpp.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/sweep.hpp>

namespace momentree {

template <class T>
void solve_with_factors(const Tree& tree, const T* q, Workspace<T>& workspace, T* u, int begin, int end) noexcept {
  const auto all = tree.kernel_runs();
  const auto first = std::partition_point(all.begin(), all.end(), [&](const KernelRun& run) { return run.end <= begin; });
  const auto last = std::partition_point(first, all.end(), [&](const KernelRun& run) { return run.begin < end; });
  const std::span<const KernelRun> runs(first, last);
  const Sweep<T> sweep{.tree = tree, .q = q, .workspace = workspace, .a = u, .first = begin, .last = end};
  const SweepBuffers<Force<T>, Motion<T>> buffers{tree, workspace.child_wrenches.get(), workspace.parent_accelerations.get()};
  sweep.inward(runs, buffers,
               [](const auto& body, int, Force<T>& W) MOMENTREE_INLINE_LAMBDA { solution_inboard(body, W); });
  sweep.outward(runs, buffers, {},
                [](const auto& body, int, Motion<T>& a) MOMENTREE_INLINE_LAMBDA { solution_outboard(body, a); });
}

}  // namespace momentree
