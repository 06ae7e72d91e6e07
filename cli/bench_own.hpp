#pragma once
// What `momentree bench MODEL` measures.
#include <string>

#include <momentree/generate/kernel_cache.hpp>
#include <momentree/tree/model.hpp>

namespace momentree::cli {

/// Times of one model on one core, in seconds; 0 where it has none.
struct OwnRow {
  std::string model;
  int bodies = 0, dofs = 0;
  double evaluation = 0;              ///< of q̇ and ṗ with the forces in joints
  double accelerations = 0;           ///< of the same with accelerations and the wrenches in all joints
  double batch = 0;                   ///< of an evaluation in a world among 64, in lanes, by steps
  std::string batch_message;          ///< why batches do not have it
  double kernels = 0, generated = 0;  ///< of the rates alone: by the kernels, and by code generated for the model
  std::string broken, locked;         ///< joints that a break and a lock are measured on: two fifths of the way through
  double break_joint = 0, lock_joint = 0;
  double error = 0;  ///< of the momenta that the velocities found belong to, as a share of the largest
};

/// Moves the model's joints at speeds of its own, so that there are momenta to check. `kernels`: of generated code.
/// Throws Error where a result is wrong.
OwnRow own_times(const std::string& name, const Model& model, const KernelCache& kernels, double budget);

}  // namespace momentree::cli
