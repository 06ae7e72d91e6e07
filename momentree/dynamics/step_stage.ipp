#pragma once
// What stages by a table of steps share. Included by forward.ipp and velocity.ipp.
#include <momentree/dynamics/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>

namespace momentree {

/// Whether a stage calls the steps of a table, which it then finds in workspace.steps: `own`, or if that is null, those that are
/// there. In double it goes over kernel runs if there is no memory for a table.
template <class T>
MOMENTREE_INLINE bool takes_steps(const Tree& tree, StepTable* own, Workspace<T>& workspace) {
  if (own != nullptr) {
    if (!own->follow(tree)) {
      MT_REQUIRE((std::is_same_v<T, double>), "there is memory for the steps of other scalars");
      return false;
    }
    workspace.steps = own;
  }
  workspace.steps->prepare(workspace.step_records.get(), workspace.step_records_of);
  return true;
}

/// The arrays of both kinds of stages.
template <class T>
MOMENTREE_INLINE StepArrays step_arrays(const Tree& tree, const T* q, Workspace<T>& workspace) {
  StepArrays arrays;
  arrays.q = q, arrays.cos = workspace.cos.get(), arrays.sin = workspace.sin.get();
  arrays.u = workspace.v.get(), arrays.qdot = workspace.qdot.get();
  arrays.records = workspace.step_records.get(), arrays.sums = workspace.child_sums.get();
  arrays.armature = arrays.model_armature = tree.armature();
  if constexpr (!std::is_same_v<T, double>) {
    for (int i = 0; i < tree.nv(); ++i) workspace.impulse[static_cast<std::size_t>(i)] = T(tree.armature()[i]);
    arrays.armature = workspace.impulse.get();
  }
  return arrays;
}

}  // namespace momentree
