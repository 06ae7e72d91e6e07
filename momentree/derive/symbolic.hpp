#pragma once
// A scalar that is an expression: the kernels run on it as on double, and their computation is recorded.
#include <type_traits>

#include <momentree/derive/expressions.hpp>
#include <momentree/math/lanes.hpp>

namespace momentree {

class Symbolic {
 public:
  Symbolic() = default;
  Symbolic(double value);  // NOLINT(google-explicit-constructor): constants of the model
  static Symbolic of_node(int node) {
    Symbolic s;
    s.node_ = node;
    return s;
  }
  /// The node. The program stops for memory that was never written, if its value is not a node of the graph.
  int node() const;
  /// The graph in which this thread's expressions are recorded; null: none, and no operation is allowed.
  static Expressions*& graph();

  // Not inline: passes of closed loops on symbols compile in 23 s instead of 164.
  friend Symbolic operator+(Symbolic a, Symbolic b);
  friend Symbolic operator-(Symbolic a, Symbolic b);
  friend Symbolic operator*(Symbolic a, Symbolic b);
  friend Symbolic operator/(Symbolic a, Symbolic b);
  friend Symbolic operator-(Symbolic a);
  friend Symbolic& operator+=(Symbolic& a, Symbolic b);
  friend Symbolic& operator-=(Symbolic& a, Symbolic b);
  friend void sincos(const Symbolic& x, Symbolic& s, Symbolic& c);

 private:
  int node_;  // 0, the constant 0, for T{} in a kernel
};

/// It has no lanes: what the kernels of loops compute in double, lane by lane, is left out of the expressions.
template <>
inline constexpr int lanes_of<Symbolic> = 0;
inline double get_lane(const Symbolic&, int) { return 0; }
inline void set_lane(Symbolic&, int, double) {}

}  // namespace momentree
