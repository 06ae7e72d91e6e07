#pragma once
// Expressions as a graph in which nothing stands twice: what a kernel computes, when it runs on symbols instead of numbers.
#include <span>
#include <unordered_map>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/math/counted.hpp>

namespace momentree {

/// What a node of the graph is. `q`, `p`: the number `a` of that array; `sine`, `cosine`: of the angle `a`; the others are
/// operations on the nodes a and b.
enum class Operation : unsigned char { constant, q, p, sine, cosine, negative, sum, difference, product, quotient };

/// Nodes in the order in which they were first asked for: every operand stands before what is made of it. Constants are folded,
/// zeros and ones left out, signs moved outward, equal expressions one node. Every rule is exact in real numbers, and none adds a
/// rounding: results are those of the kernels up to how products and sums of constants, and multiply-adds, are rounded.
class Expressions {
 public:
  struct Node {
    Operation operation = Operation::constant;
    int a = 0, b = 0;
    double value = 0;  ///< of a constant
    friend bool operator==(const Node&, const Node&) = default;
  };
  static constexpr int zero = 0;  ///< the node that is the constant 0

  Expressions();

  int constant(double value);
  /// The number at `index` of q or p.
  int input(Operation array, int index);
  int sine(int angle);
  int cosine(int angle);
  int negative(int a);
  int sum(int a, int b);
  int difference(int a, int b);
  int product(int a, int b);
  int quotient(int a, int b);

  const std::vector<Node>& nodes() const { return nodes_; }
  /// There was no memory for a node: all from then on are the constant 0. Kernels, which don't throw, can't say so.
  bool exhausted() const { return exhausted_; }
  bool has(int node) const { return node >= 0 && static_cast<std::size_t>(node) < nodes_.size(); }
  /// Operations that the results take, in the accounting of `count_operations`: changes of sign are free.
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
  std::vector<bool> needed(std::span<const int> results) const;
  int make(Operation operation, int a, int b, double value = 0);

  std::vector<Node> nodes_;
  std::unordered_map<Node, int, Hash> numbers_;
  bool exhausted_ = false;
};

/// True where an operation has two operands.
inline bool binary(Operation operation) { return operation >= Operation::sum; }
/// True where it has an operand at all.
inline bool unary(Operation operation) { return operation >= Operation::sine && operation <= Operation::negative; }

}  // namespace momentree
