#pragma once
// What an evaluation of rates computes for one topology, as expressions.
#include <string>
#include <vector>

#include <momentree/generate/expressions.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Nodes of the results, packed as in Work: v as p, qdot as q, pdot as p.
struct KernelExpressions {
  Expressions expressions;
  std::vector<int> v, qdot, pdot;

  /// All results, in that order.
  std::vector<int> results() const;
  Operations operations() const { return expressions.operations(results()); }
};

/// Which of the two orders of reducing a pin (25) and turning about it (16) the kernels take; see RevoluteSteps::late. `fewest`:
/// the one that leaves fewer operations when all is folded, which differs from model to model.
enum class RevoluteOrder { fewest, reduce_first, turn_first };

/// Runs evaluate_rates on symbols: the recursions with gravity, rotors and freedoms that are locked or driven, without joint
/// forces. Allocates; takes time and memory in proportion to the bodies.
KernelExpressions kernel_expressions(const Tree& tree, RevoluteOrder order = RevoluteOrder::fewest);

/// Adds the forces in joints that are plain expressions to pdot: dampers, springs, constant efforts. What else acts is what
/// `other_forces` lists.
void add_plain_forces(const Tree& tree, KernelExpressions& kernel);

/// Something that moves the mechanism and is no plain expression of q and v.
struct OtherForce {
  int body = -1;     ///< the body whose inboard joint has it, or on which it acts
  std::string what;  ///< "dry friction", "a drive that changes with time", …
  bool on_body = false;
};
/// All that `add_plain_forces` leaves out, bodies in the tree's order; empty: nothing.
std::vector<OtherForce> other_forces(const Tree& tree);

}  // namespace momentree
