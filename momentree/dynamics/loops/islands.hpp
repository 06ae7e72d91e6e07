#pragma once
// Which mechanisms move together: those that loops, couplings or contacts connect.
#include <vector>

#include <momentree/tree/tree.hpp>

namespace momentree {

class Islands {
 public:
  /// Mechanisms, with the loops and couplings between them. Every mechanism is at first an island of its own.
  explicit Islands(const Tree& tree);
  /// Joins the islands of two bodies; −1, the ground, joins nothing.
  void join(int a, int b);
  /// The number of a body's island: that of one of its bodies.
  int of(int body) const;

 private:
  mutable std::vector<int> next_;  // by body: another one of its island; itself: its number
};

}  // namespace momentree
