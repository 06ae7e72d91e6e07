#pragma once
// A scalar that is an expression: the kernels run on it as they run on double, and what they would compute is written down.
#include <type_traits>

#include <momentree/generate/expressions.hpp>
#include <momentree/joint/pin_steps.hpp>

namespace momentree {

/// `Late`: of the two orders in which pins are reduced and turned, that of one world at a time (PinSteps::late).
template <bool Late>
class Symbolic {
 public:
  Symbolic() = default;
  Symbolic(double value) : node_(graph()->constant(value)) {}  // NOLINT(google-explicit-constructor): constants of the model
  static Symbolic of_node(int node) {
    Symbolic s;
    s.node_ = node;
    return s;
  }
  int node() const { return node_; }
  /// Where this thread's expressions are written; null: nowhere, and no operation is allowed.
  static Expressions*& graph() {
    thread_local Expressions* current = nullptr;
    return current;
  }

  friend Symbolic operator+(Symbolic a, Symbolic b) { return of_node(graph()->sum(a.node_, b.node_)); }
  friend Symbolic operator-(Symbolic a, Symbolic b) { return of_node(graph()->difference(a.node_, b.node_)); }
  friend Symbolic operator*(Symbolic a, Symbolic b) { return of_node(graph()->product(a.node_, b.node_)); }
  friend Symbolic operator/(Symbolic a, Symbolic b) { return of_node(graph()->quotient(a.node_, b.node_)); }
  friend Symbolic operator-(Symbolic a) { return of_node(graph()->negative(a.node_)); }
  friend Symbolic& operator+=(Symbolic& a, Symbolic b) { return a = a + b; }
  friend Symbolic& operator-=(Symbolic& a, Symbolic b) { return a = a - b; }
  friend void sincos(const Symbolic& x, Symbolic& s, Symbolic& c) {
    s = of_node(graph()->sine(x.node_)), c = of_node(graph()->cosine(x.node_));
  }

 private:
  int node_;  // 0, the constant 0, where a kernel asks for T{}
};

template <>
inline constexpr bool one_world_at_a_time<Symbolic<true>> = true;

}  // namespace momentree
