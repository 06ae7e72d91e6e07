#pragma once
// The measurements of `momentree bench MODEL`.
#include <string>

#include <momentree/generate/kernel_cache.hpp>
#include <momentree/model/model.hpp>

namespace momentree::cli {

/// Times of one model on one core, in seconds; 0 if not available.
struct OwnRow {
  std::string model;
  int bodies = 0, dofs = 0;
  double evaluation = 0;              ///< of q̇ and ṗ with joint forces
  double accelerations = 0;           ///< also with accelerations and all joint wrenches
  double batch = 0;                   ///< of an evaluation in one of 64 worlds of a batch, in lanes, during steps
  std::string batch_message;          ///< why batches do not support the model
  double kernels = 0, generated = 0;  ///< of the rates alone: by the kernels, and by code generated for the model
  std::string broken, locked;         ///< joints for the measured break and lock: at two fifths of the joints
  double break_joint = 0, lock_joint = 0;
  double error = 0;  ///< of the momenta recomputed from the velocities found, relative to the largest momentum
};

/// Sets the model's joints in motion, so that there are momenta to check. `kernels`: of generated code. Throws Error if a
/// result is wrong.
OwnRow own_times(const std::string& name, const Model& model, const KernelCache& kernels, double budget);

}  // namespace momentree::cli
