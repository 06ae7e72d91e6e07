#pragma once
// What the steps of all joints are called with.
#include <cstdint>

namespace momentree {

/// The arrays of a pass, shared by its steps. Of several worlds at once, every number is one per world.
struct StepArrays {
  const double *q = nullptr, *cos = nullptr, *sin = nullptr;
  double *u = nullptr, *qdot = nullptr;  ///< velocities, and the rates of coordinates
  double* a = nullptr;                   ///< joint forces τ, then accelerations u̇
  double* records = nullptr;             ///< what a step stores for later passes
  double* sums = nullptr;                ///< contributions of children, an Inboard per body
  double* motions = nullptr;             ///< what bodies hand to their children, a Motion per body
  double* biases = nullptr;              ///< a BodyBias per body, for steps that are not machine code
  const double* armature = nullptr;      ///< of DoFs; the same for all worlds
};

struct StepEntry;
using StepFunction = void (*)(const StepEntry&, const StepArrays&);

/// A body in a pass: its step, and where its numbers are in the arrays (bytes).
struct StepEntry {
  StepFunction step = nullptr;
  const void* constants = nullptr;
  std::int32_t q = 0, angle = 0, dof = 0, record = 0;
  std::int32_t in = 0, to = 0;  ///< in `sums` or `motions`
};
static_assert(sizeof(StepEntry) <= 40);

}  // namespace momentree
