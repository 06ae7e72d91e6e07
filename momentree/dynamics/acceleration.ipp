#pragma once
// Definitions of the second recursion; included only by instantiate/*.cpp, each for one scalar.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/sweep.hpp>

namespace momentree {

template <class T>
void evaluate_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept {
  const Sweep<T> sweep{tree, q, workspace, workspace.a.get()};
  const SweepBuffers<Force<T>, Motion<T>> buffers{tree, workspace.child_wrenches.get(), workspace.parent_accelerations.get()};
  sweep.inward(tree.kernel_runs(), buffers,
               [](const auto& body, int, Force<T>& W) MOMENTREE_INLINE_LAMBDA { rate_inboard(body, W); });
  // The ground accelerates against gravity; this gives every body its weight, so that gravity is not needed in body axes.
  const Vec3& g = tree.gravity();
  const Motion<T> base{{T(-g.x), T(-g.y), T(-g.z)}, {}};
  sweep.outward(tree.kernel_runs(), buffers, base,
                [](const auto& body, int, Motion<T>& a) MOMENTREE_INLINE_LAMBDA { rate_outboard(body, a); });
}

}  // namespace momentree
