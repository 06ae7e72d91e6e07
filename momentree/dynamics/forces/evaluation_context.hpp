#pragma once
// The world at one instant, for user functions that drive joints or act on bodies.
#include <span>

#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

struct LoopValues;

/// The part of the world that a user function may read. The function is called at every stage of a step, with coordinates that
/// belong to no stored state: do not keep the context after the call, and read nothing else of the world during it. A call to the
/// world or its simulation from the function stops the program. Bodies are located at the first query; nothing allocates.
class EvaluationContext {
 public:
  EvaluationContext(const Tree& tree, double time, const double* q, Workspace<double>& workspace) noexcept
      : tree_(&tree), workspace_(&workspace), q_(q), time_(time), nested_(workspace.in_function) {
    workspace.in_function = true;
  }
  ~EvaluationContext() { workspace_->in_function = nested_; }
  EvaluationContext(const EvaluationContext&) = delete;
  EvaluationContext& operator=(const EvaluationContext&) = delete;

  double time() const { return time_; }
  /// Coordinates (rad, m) and velocities (rad/s, m/s) of a joint, in its declared direction, also of a joint that
  /// closes a loop; empty if it has left the world.
  Numbers q(JointId joint) const noexcept;
  Numbers v(JointId joint) const noexcept;
  /// True if a function drives the joint; false once it broke or was replaced.
  bool has_function(JointId joint) const noexcept;
  /// Motion of a body's user frame; for the ground and for a removed body the world's frame at rest.
  BodyMotion motion(BodyId body) const noexcept;

 private:
  const LoopValues* loop_values(JointId joint) const noexcept;

  const Tree* tree_;
  Workspace<double>* workspace_;
  const double* q_;
  double time_;
  bool nested_;
  mutable bool located_ = false;
};

}  // namespace momentree
