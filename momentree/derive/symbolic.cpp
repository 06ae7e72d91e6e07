#include <momentree/derive/symbolic.hpp>

#include <momentree/base/check.hpp>

namespace momentree {

Expressions*& Symbolic::graph() {
  thread_local Expressions* current = nullptr;
  return current;
}

Symbolic::Symbolic(double value) : node_(graph()->constant(value)) {}

int Symbolic::node() const {
  MT_REQUIRE(graph() != nullptr && graph()->has(node_), "a number is written before it is read");
  return node_;
}

Symbolic operator+(Symbolic a, Symbolic b) { return Symbolic::of_node(Symbolic::graph()->sum(a.node(), b.node())); }
Symbolic operator-(Symbolic a, Symbolic b) { return Symbolic::of_node(Symbolic::graph()->difference(a.node(), b.node())); }
Symbolic operator*(Symbolic a, Symbolic b) { return Symbolic::of_node(Symbolic::graph()->product(a.node(), b.node())); }
Symbolic operator/(Symbolic a, Symbolic b) { return Symbolic::of_node(Symbolic::graph()->quotient(a.node(), b.node())); }
Symbolic operator-(Symbolic a) { return Symbolic::of_node(Symbolic::graph()->negative(a.node())); }
Symbolic& operator+=(Symbolic& a, Symbolic b) { return a = a + b; }
Symbolic& operator-=(Symbolic& a, Symbolic b) { return a = a - b; }

void sincos(const Symbolic& x, Symbolic& s, Symbolic& c) {
  s = Symbolic::of_node(Symbolic::graph()->sine(x.node())), c = Symbolic::of_node(Symbolic::graph()->cosine(x.node()));
}

}  // namespace momentree
