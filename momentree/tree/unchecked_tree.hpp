#pragma once
// A tree as the recursions read it: by numbers from its own order, without checking that such bodies exist; the checks would take
// a tenth of an evaluation.
#include <momentree/tree/kernel_run.hpp>

namespace momentree {

class UncheckedTree {
 public:
  UncheckedTree(const Tree& tree) : tree_(tree) {}  // NOLINT(google-explicit-constructor): the same tree
  operator const Tree&() const { return tree_; }    // NOLINT(google-explicit-constructor)

  int parent(int b) const { return tree_.tables().parent[at(b)]; }
  int first_q(int b) const { return tree_.tables().offsets[at(b)].q; }
  int first_p(int b) const { return tree_.tables().offsets[at(b)].p; }
  int first_angle(int b) const { return tree_.tables().offsets[at(b)].angle; }
  std::size_t record(int b) const { return tree_.tables().offsets[at(b)].record; }
  const LinkConstants& link(int b) const { return tree_.tables().links[at(b)]; }
  double subtree_mass(int b) const { return tree_.tables().subtree_mass[at(b)]; }
  const double* subtree_masses() const { return tree_.tables().subtree_mass.data(); }
  Kind kind(int b) const { return tree_.tables().classes[at(b)].kind; }
  Variant variant(int b) const { return tree_.tables().classes[at(b)].variant; }

  std::span<const int> order() const { return tree_.order(); }
  const TreeTables& tables() const { return tree_.tables(); }
  const TreeLoads& loads() const { return tree_.loads(); }
  const Vec3& gravity() const { return tree_.gravity(); }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  const Tree& tree_;
};

}  // namespace momentree
