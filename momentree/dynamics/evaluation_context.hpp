#pragma once
// The world at an instant, for functions of the user's that drive joints or act on bodies.
#include <span>

#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

/// What such a function may ask for. It is called at every stage of a step, whose coordinates are not those of any state that is
/// kept: use none of it after the call, and in the call nothing else that the world has. What asks the world or its simulation
/// there stops the program. Bodies are located the first time that one is asked for; nothing allocates.
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
  /// Coordinates and velocities of the joint of that number, in its declared direction; empty where it left the world.
  Numbers q(JointId joint) const noexcept;
  Numbers v(JointId joint) const noexcept;
  /// True where a function drives the joint of that number: false once it broke or became another.
  bool has_function(JointId joint) const noexcept;
  /// Frame of a body; the world's origin at rest for the ground and for a body that left the world.
  BodyMotion motion(BodyId body) const noexcept;

 private:
  const Tree* tree_;
  Workspace<double>* workspace_;
  const double* q_;
  double time_;
  bool nested_;
  mutable bool located_ = false;
};

}  // namespace momentree
