#pragma once
// Sparse linear equations whose unknowns come in blocks, such as the motions of mechanisms that touch each other.
#include <cstddef>
#include <vector>

namespace momentree::contact {

/// Gaussian elimination by blocks, in an order that keeps the matrix sparse. Within a block rows are exchanged; between blocks
/// they are not, as for matrices I + Y K J, whose blocks on the diagonal are regular.
class BlockElimination {
 public:
  /// Forgets all. The sizes of the blocks.
  void clear(const std::vector<int>& sizes);
  /// A block will not be zero, nor the transposed one.
  void connect(int one, int other);
  /// Finds the order, and the blocks that elimination fills.
  void analyse();
  /// The matrix becomes the identity.
  void reset();
  /// A block by rows: `one` == `other`, or connected.
  double* block(int one, int other) { return values_.data() + at_[index(one, other)]; }
  /// False if it is singular.
  [[nodiscard]] bool factorise();
  /// x: the right side, block by block; becomes the solution.
  void solve(double* x) const;
  std::size_t first(int block) const { return first_[static_cast<std::size_t>(block)]; }
  std::size_t unknowns() const { return first_.back(); }

 private:
  std::size_t index(int one, int other) const {
    return static_cast<std::size_t>(one) * sizes_.size() + static_cast<std::size_t>(other);
  }
  void solve_block(int block, double* x, std::size_t columns) const;

  std::vector<int> sizes_, order_, degree_;  // degree_: unknowns of the neighbours
  std::vector<bool> done_;
  std::vector<std::size_t> first_, at_;       // of unknowns; of blocks in values_, SIZE_MAX: zero
  std::vector<std::vector<int>> neighbours_;  // after analyse(): those that are eliminated later
  std::vector<double> values_;
  std::vector<int> pivots_;
};

}  // namespace momentree::contact
