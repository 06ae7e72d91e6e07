#pragma once
// Expressions as a graph without duplicates: the computation of a kernel that runs on symbols instead of numbers.
#include <span>
#include <unordered_map>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/math/counted.hpp>

namespace momentree {

/// Kind of a graph node. `q`, `p` (or velocities u), `tau`: number `a` of that array; `answer`: number `a` among the answers of
/// calls; `sine`, `cosine`: of the angle `a`; `inverse_pivot`: 1/a, or 0 if a does not exceed number `b` of the least pivots; the
/// others are operations on nodes a and b.
enum class Operation : unsigned char {
  constant,
  q,
  p,
  tau,
  answer,
  sine,
  cosine,
  negative,
  inverse_pivot,
  sum,
  difference,
  product,
  quotient
};

/// Nodes in the order in which they were first created: every operand comes before the nodes that use it. Constants are folded,
/// zeros and ones omitted, signs moved outward, terms that cancel left out, and equal expressions are one node. Every rule is
/// exact in real numbers and none adds a rounding: results equal those of the kernels up to the rounding of products and sums of
/// constants, and of multiply-adds.
class Expressions {
 public:
  struct Node {
    Operation operation = Operation::constant;
    int a = 0, b = 0;
    double value = 0;  ///< of a constant
    friend bool operator==(const Node&, const Node&) = default;
  };
  /// A function whose result is not an expression: of the joint of a closed loop, or the solution of a system of equations.
  struct Call {
    int loop = -1;               ///< the place of the loop; −1: the system of the rows
    std::vector<int> arguments;  ///< nodes
    int first_answer = 0, answers = 0;
  };
  static constexpr int zero = 0;  ///< the node of the constant 0

  Expressions();

  /// From now on, terms that cancel leave no operations, and sin² + cos² is 1. The derived steps of joint kinds are made without.
  void cancel_terms() { cancels_ = true; }

  /// Frees what new nodes need: there will be no more.
  void end() { numbers_ = {}; }

  int constant(double value);
  /// The number at `index` of q, p (or u) or tau.
  int input(Operation array, int index);
  int sine(int angle);
  int cosine(int angle);
  int negative(int a);
  int inverse_pivot(int a, int index);
  int sum(int a, int b);
  int difference(int a, int b);
  int product(int a, int b);
  int quotient(int a, int b);

  /// Adds a call; returns the node of its first answer, behind which the others follow.
  int call(int loop, std::vector<int> arguments, int answers);
  const std::vector<Call>& calls() const { return calls_; }
  /// The call that an answer belongs to, by its number.
  int call_of(int answer) const;

  const std::vector<Node>& nodes() const { return nodes_; }
  /// For each node, whether one of the results depends on it.
  std::vector<bool> needed(std::span<const int> results) const;
  /// True if memory for a node ran out: all later nodes are the constant 0. Kernels do not throw and so cannot report it.
  bool exhausted() const { return exhausted_; }
  bool has(int node) const { return node >= 0 && static_cast<std::size_t>(node) < nodes_.size(); }
  /// Number of operations for the results, counted as in `count_operations`: changes of sign are free. Those of calls are not
  /// counted.
  Operations operations(std::span<const int> results) const;

 private:
  struct Hash {
    std::size_t operator()(const Node& node) const;
  };
  const Node& at(int i) const {
    MT_REQUIRE(static_cast<std::size_t>(i) < nodes_.size(), "a node of these expressions");
    return nodes_[static_cast<std::size_t>(i)];
  }
  bool is(int i, Operation operation) const { return at(i).operation == operation; }
  bool is_square_of(int i, Operation operation) const;
  static constexpr int none = -1;
  int sum_that_cancels(int a, int b);
  int difference_that_cancels(int a, int b);
  int make(Operation operation, int a, int b, double value = 0);

  std::vector<Node> nodes_;
  std::vector<Call> calls_;
  std::unordered_map<Node, int, Hash> numbers_;
  bool exhausted_ = false, cancels_ = false;
};

/// True if an operation has two operands.
inline bool binary(Operation operation) { return operation >= Operation::sum; }
/// True if an operation has exactly one operand.
inline bool unary(Operation operation) { return operation >= Operation::sine && operation <= Operation::inverse_pivot; }

}  // namespace momentree
