#pragma once
// Accelerations with closed loops and couplings as expressions, for one choice of independent rows.
#include <span>
#include <string>
#include <vector>

#include <momentree/generate/kernel.hpp>

namespace momentree {

/// What the expressions of closed loops are for.
enum class LoopCode : unsigned char {
  stages,  ///< steps of a simulation: forces in loop joints, and rows that are not expressions, come from LoopCalls
  file     ///< a function by itself, without joint forces of loops
};

/// Runs the passes in velocities and the kernels of loops on symbols, with these rows in ascending order (those that
/// chosen_loop_rows returns): from q, u and further joint forces tau (packed as u; behind them, the accelerations of
/// prescribed motions of loop joints) to the rates of q and u and the multipliers of the rows. u must be velocities that the
/// loops allow. `plain_forces`: as for velocity_expressions. Small systems of rows are solved in place, larger ones by a
/// call. Requires a tree with loops, and for a file that loop_obstacles is empty.
KernelExpressions loop_expressions(const Tree& tree, std::span<const int> rows, LoopCode code = LoopCode::stages,
                                   bool plain_forces = false);

/// The rows that were chosen at a state, and the least pivots there. Evaluates the state; allocates.
struct ChosenRows {
  std::vector<int> rows;
  std::vector<double> least_pivots;
};
ChosenRows chosen_loop_rows(const Tree& tree, const State& state);

/// What keeps a loop, by its place in Tree::loops(), from having code in a file: armatures and locks of single DoFs of universal
/// and planar joints, and, unless `without_joint_forces`, forces in its joint.
struct LoopObstacle {
  int loop = -1;
  std::string what;  ///< "a force along its DoFs", …
  bool forces = false;
};
std::vector<LoopObstacle> loop_obstacles(const Tree& tree, bool without_joint_forces);

}  // namespace momentree
