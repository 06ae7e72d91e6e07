#pragma once
// What all passes by a table of steps share. Included by forward.ipp, velocity.ipp and acceleration.ipp.
#include <momentree/dynamics/steps/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/tree/unchecked_tree.hpp>

namespace momentree {

/// Sets workspace.steps to the workspace's own table for a stage, if it has one; otherwise the caller has set it. False if there
/// is no memory for the table: a stage in double then takes the passes that keep results.
template <class T>
MOMENTREE_INLINE bool takes_steps(const Tree& tree, Passes passes, Workspace<T>& workspace) {
  if (StepTable* const own = workspace.table(passes).get(); own != nullptr) {
    if (!own->follow(tree)) {
      MT_REQUIRE((std::is_same_v<T, double>), "there is memory for the steps of other scalars");
      return false;
    }
    workspace.steps = own;
  }
  workspace.steps->prepare(workspace.step_records.get(), workspace.step_records_of);
  return true;
}
/// The table of passes that keep results: the workspace's own one, or the one that the caller has set.
template <class T>
MOMENTREE_INLINE const StepTable& keeping_steps(const Tree& tree, Passes passes, Workspace<T>& workspace) {
  StepTable* const own = workspace.table(passes).get();
  if (own == nullptr) return *workspace.kept_steps;
  const bool follows = own->follow(tree);
  MT_REQUIRE(follows, "the table was made for so many bodies");
  return *own;
}

/// The arrays of all passes.
template <class T>
MOMENTREE_INLINE StepArrays step_arrays(const Tree& tree, Passes passes, const T* q, Workspace<T>& workspace) {
  StepArrays arrays;
  arrays.q = q, arrays.cos = workspace.cos.get(), arrays.sin = workspace.sin.get();
  arrays.u = workspace.v.get(), arrays.qdot = workspace.qdot.get(), arrays.pdot = workspace.pdot.get();
  arrays.a = workspace.a.get(), arrays.biases = workspace.biases.get();
  arrays.records = keeps_results(passes) ? workspace.records.get() : workspace.step_records.get();
  arrays.sums = workspace.child_sums.get();
  if (passes >= Passes::rates) arrays.sums = workspace.child_wrenches.get();
  arrays.motions = workspace.parent_accelerations.get();
  if (in_momenta(passes)) arrays.motions = workspace.parent_states.get();
  arrays.body_sweeps = workspace.motions.get(), arrays.inboard_accelerations = workspace.inboard_accelerations.get();
  arrays.reduced_bias_wrenches = workspace.reduced_bias_wrenches.get();
  arrays.loads = workspace.loads.get();
  arrays.masses = UncheckedTree(tree).subtree_masses();
  arrays.armature = arrays.model_armature = tree.tables().armature.data();
  if constexpr (!std::is_same_v<T, double>) {
    for (int i = 0; i < tree.nv(); ++i) workspace.impulse[static_cast<std::size_t>(i)] = T(tree.tables().armature[i]);
    arrays.armature = workspace.impulse.get();
  }
  return arrays;
}

}  // namespace momentree
