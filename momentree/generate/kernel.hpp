#pragma once
// One evaluation of the rates for one topology, as expressions.
#include <string>
#include <vector>

#include <momentree/derive/expressions.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

/// Nodes of the results, packed as in Workspace: v as p, qdot as q, pdot as p, udot as p. In momenta these are v, qdot and pdot,
/// in velocities qdot and udot.
struct KernelExpressions {
  Expressions expressions;
  Variables variables = Variables::momenta;
  std::vector<int> v, qdot, pdot, udot;
  /// With closed loops also the multipliers, by chosen row, and the efforts of prescribed motions, in the order of
  /// Tree::driven_joints().
  std::vector<int> lambda, effort;
  bool loops = false;                  ///< for steps, with LoopCalls
  int motions = 0;                     ///< prescribed motions of loop joints, whose accelerations are behind tau
  std::vector<double> least_pivots{};  ///< by chosen row, for code without LoopCalls
  std::vector<int> begin{};            ///< by chosen row: the first one with which it shares an element of A

  /// By chosen row: where its element of column 0 would be in A, which has the elements from column begin[row] to the diagonal.
  std::vector<int> rows() const;
  /// All results, in that order.
  std::vector<int> results() const;
  Operations operations() const { return expressions.operations(results()); }
};

/// Runs evaluate_rates on symbols: the recursions with gravity, armatures and locked or driven DoFs, without joint forces.
/// Allocates; time and memory are proportional to the number of bodies.
KernelExpressions kernel_expressions(const Tree& tree);

/// Runs the passes in velocities on symbols: from q, u and further joint forces tau (packed as u) to q̇ and u̇, with gravity. For
/// a prescribed motion tau has its acceleration; u and tau of locked DoFs are taken as zero. `plain_forces`: also with those
/// joint forces that add_plain_forces() adds.
KernelExpressions velocity_expressions(const Tree& tree, bool plain_forces = false);

/// Adds the joint forces that are plain expressions to pdot: dampers, springs, constant efforts. `other_forces` lists all
/// others.
void add_plain_forces(const Tree& tree, KernelExpressions& kernel);

/// A force that is not a plain expression of q and v.
struct OtherForce {
  int body = -1;     ///< the body whose inboard joint has it, or on which it acts
  std::string what;  ///< "dry friction", "a drive that changes with time", …
  bool on_body = false;
};
/// All forces that `add_plain_forces` omits, by body in the tree's order; empty if there are none.
std::vector<OtherForce> other_forces(const Tree& tree);

}  // namespace momentree
