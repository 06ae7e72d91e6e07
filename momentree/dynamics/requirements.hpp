#pragma once
// Whether a workspace holds the evaluation that a function needs, and the requirements that are reported if not.
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

/// True if the workspace holds the evaluation (or the accelerations) of this state on this tree, both in their present form.
inline bool evaluated_on(const Tree& tree, const State& state, const Workspace<double>& workspace) noexcept {
  return workspace.evaluated == state.stamp() && state.topology() == tree.revision();
}
inline bool accelerated_on(const Tree& tree, const State& state, const Workspace<double>& workspace) noexcept {
  return workspace.accelerated == state.stamp() && state.topology() == tree.revision();
}
/// The requirements that are reported if these are false.
inline constexpr const char* edited_state = "the state's Edit has ended: close its scope first";
inline constexpr const char* foreign_state = "the state belongs to this tree as it is now";
inline const char* stale_workspace(const State& state) {
  return state.being_edited()
             ? edited_state
             : "the workspace was evaluated with this state and this tree as they are now: call forward_dynamics first";
}
inline const char* stale_accelerations(const State& state) {
  return state.being_edited()
             ? edited_state
             : "the workspace holds the accelerations of this state and this tree as they are now: call accelerate first";
}
inline constexpr const char* inside_function =
    "a function called by an evaluation reads only the EvaluationContext that it is given";

}  // namespace momentree
