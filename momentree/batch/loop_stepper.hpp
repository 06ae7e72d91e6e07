#pragma once
// Steps of worlds with closed loops in momenta: one world after the other, in double. In velocities: loop_lanes.ipp.
#include <memory>

#include <momentree/batch/stepper.hpp>
#include <momentree/integrate/integrator.hpp>

namespace momentree::batch {

/// The method rk4 of single simulations, with memory for one thread.
class LoopStepper {
 public:
  /// Prepares steps of worlds with this tree. Allocates.
  void fit(const Tree& tree);
  /// One step of the world in a block of one lane, as Stepper::step(); it runs away also if its loops cannot be closed. Requires
  /// fit(tree). Neither allocates nor throws.
  void step(const Tree& tree, const Block& block) noexcept;

 private:
  Workspace<double> workspace_;
  State state_;
  std::unique_ptr<Integrator> rk4_;
};

}  // namespace momentree::batch
