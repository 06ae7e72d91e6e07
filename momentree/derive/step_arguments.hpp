#pragma once
// What the steps of all joints are called with.
#include <cstdint>

#include <momentree/joint/passes.hpp>

namespace momentree {

/// The arrays of a pass, shared by its steps. Of several worlds at once, every number is one per world.
struct StepArrays {
  const void *q = nullptr, *cos = nullptr, *sin = nullptr;
  void *u = nullptr, *qdot = nullptr;  ///< velocities, and the rates of coordinates
  void* a = nullptr;                   ///< in velocities: joint forces τ, then accelerations u̇
  const void* p = nullptr;             ///< in momenta: these …
  void* pdot = nullptr;                ///< … and their rates
  void* records = nullptr;             ///< what a step stores for later passes
  void* sums = nullptr;                ///< contributions of children: an Inboard per body; a Force for rates and solutions
  void* motions = nullptr;             ///< what bodies hand to their children: a Motion per body; in momenta an Outboard
  void* biases = nullptr;              ///< a BodyBias per body: of passes that keep it, and of generic steps in velocities
  // What is kept, per body: BodySweep, a′ and Ŵ; and the external wrenches on bodies.
  const void* loads = nullptr;
  void *body_sweeps = nullptr, *inboard_accelerations = nullptr, *reduced_bias_wrenches = nullptr;
  const void* masses = nullptr;            ///< of the bodies with all bodies outboard, once for all worlds
  const void* armature = nullptr;          ///< of DoFs
  const double* model_armature = nullptr;  ///< the same, once for all worlds, for generic steps
};

struct StepEntry;
using StepFunction = void (*)(const StepEntry&, const StepArrays&);

/// A body in a pass: its step, and where its numbers are in the arrays (bytes).
struct StepEntry {
  StepFunction step = nullptr;
  const void* constants = nullptr;
  std::int32_t q = 0, angle = 0, dof = 0, record = 0;
  std::int32_t in = 0, to = 0;  ///< in `sums` or `motions`; of passes that keep results these are numbers of bodies,
                                ///< and `record` counts numbers
};
static_assert(sizeof(StepEntry) <= 40);

}  // namespace momentree
