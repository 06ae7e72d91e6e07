#pragma once
// From expressions to the operations of a function for machine code: which are needed, which products become part of a
// multiply-add, and the values in the order in which they are computed.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <momentree/derive/expressions.hpp>
#include <momentree/machine/function.hpp>

namespace momentree::derive {

/// A class derived from this says what the inputs are, and adds the stores. First need() for all results, then choose().
class GraphLowering {
 public:
  GraphLowering(const GraphLowering&) = delete;
  GraphLowering& operator=(const GraphLowering&) = delete;

 protected:
  GraphLowering(const std::vector<Expressions::Node>& nodes, const machine::Target& target);
  virtual ~GraphLowering() = default;

  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

  /// Whether a node is loaded from a place, not computed.
  virtual bool is_input(std::size_t node) const = 0;
  virtual machine::Place place_of(std::size_t input) = 0;
  /// Mixes what an input is into a number, independently of the order of the recording.
  virtual std::uint64_t digest_of(std::size_t input, std::uint64_t h) const = 0;
  /// Called for inputs that are needed, in descending order: calls need() for those nodes on which they depend.
  virtual void need_for([[maybe_unused]] std::size_t input) {}
  /// The place of number `index` of the least pivots.
  virtual machine::Place least_pivot(int index);

  /// A result: it is computed by itself.
  void need(int node) { needed_[at(node)] = 1, uses_[at(node)] += 2; }
  void choose();
  bool is_computed(std::size_t node) const { return needed_[node] && !fused_[node] && !is_input(node); }
  bool is_needed(std::size_t node) const { return needed_[node] != 0; }
  bool is_fused(std::size_t node) const { return fused_[node] != 0; }

  /// The value of a node, after those that it needs.
  int visit(std::size_t node);
  int append(const machine::Value& value);
  /// An operation that comes next.
  int operation(const machine::Value& value);
  machine::Place pool(double value);

  static std::uint64_t mix(std::uint64_t h, std::uint64_t x) { return ((h ^ x) * 1099511628211u) ^ (h >> 29); }

  const std::vector<Expressions::Node>& nodes_;
  const machine::Target& target_;
  machine::Function out_;

 private:
  template <class F>
  void each_operand(std::size_t i, F&& f) const;
  std::vector<std::uint64_t> digests() const;
  int inverse_pivot(int pivot, int index);

  std::vector<char> needed_, fused_, factor_;
  std::vector<int> uses_, value_;
};

}  // namespace momentree::derive
