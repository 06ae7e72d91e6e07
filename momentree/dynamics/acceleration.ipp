#pragma once
// Definitions of the second recursion and of the solution for further right-hand sides; included only by instantiate/*.cpp.
#include <algorithm>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/steps/step_stage.ipp>

namespace momentree {

template <class T>
void evaluate_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept {
  if (tree.loads().bodies.empty()) std::fill_n(workspace.loads.get(), tree.bodies(), Force<T>{});
  const StepArrays arrays = step_arrays(tree, Passes::rates, q, workspace);
  const StepTable& steps = keeping_steps(tree, Passes::rates, workspace);
  steps.inboard(arrays);
  const Vec3& g = tree.gravity();
  const Vector3<T> base{T(-g.x), T(-g.y), T(-g.z)};  // gives every body its weight, so that gravity is not needed in body axes
  steps.outboard(arrays, &base);
}

// M u = r, by one inward and one outward pass in O(n).
template <class T>
void solve_with_factors(const Tree& tree, const T* q, Workspace<T>& workspace, T* u, int begin, int end) noexcept {
  StepArrays arrays = step_arrays(tree, Passes::solutions, q, workspace);
  arrays.a = u;
  const StepTable& steps = keeping_steps(tree, Passes::solutions, workspace);
  steps.inboard(arrays, begin, end);
  const Vector3<T> base{};
  steps.outboard(arrays, &base, begin, end);
}

}  // namespace momentree
