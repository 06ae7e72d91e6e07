#include <momentree/derive/graph_lowering.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

namespace momentree::derive {

GraphLowering::GraphLowering(const std::vector<Expressions::Node>& nodes, const machine::Target& target)
    : nodes_(nodes),
      target_(target),
      needed_(nodes.size(), 0),
      fused_(nodes.size(), 0),
      factor_(nodes.size(), 0),
      uses_(nodes.size(), 0),
      value_(nodes.size(), -1) {}

machine::Place GraphLowering::least_pivot(int) {
  MT_REQUIRE(false, "steps have no rows of loops");
  return {};
}

template <class F>
void GraphLowering::each_operand(std::size_t i, F&& f) const {
  const auto& n = nodes_[i];
  if (unary(n.operation) || binary(n.operation)) f(at(n.a));
  if (binary(n.operation)) f(at(n.b));
}

/// A number for each expression that depends on what it computes alone, up to its sign: not on the order in which the compiler
/// evaluated the arguments of functions while it was recorded, nor on whether a − b or b − a was recorded first.
std::vector<std::uint64_t> GraphLowering::digests() const {
  std::vector<std::uint64_t> all(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const auto& n = nodes_[i];
    const auto of = [&](int k) { return all[at(k)]; };
    const Operation kind = n.operation == Operation::difference ? Operation::sum : n.operation;
    std::uint64_t h = mix(14695981039346656037u, static_cast<std::uint64_t>(kind));
    if (kind == Operation::constant)
      h = mix(h, std::bit_cast<std::uint64_t>(std::abs(n.value)));
    else if (kind == Operation::quotient)
      h = mix(mix(h, of(n.a)), of(n.b));
    else if (kind == Operation::sum || kind == Operation::product)
      h = mix(mix(h, std::min(of(n.a), of(n.b))), std::max(of(n.a), of(n.b)));
    else if (unary(kind))
      h = mix(h, of(n.a));
    else
      h = digest_of(i, h);
    all[i] = kind == Operation::negative ? of(n.a) : h;
  }
  return all;
}

/// Products that are used once become part of a multiply-add; of two, the one that is known later.
void GraphLowering::choose() {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    if (!needed_[i]) continue;
    if (is_input(i))
      need_for(i);
    else
      each_operand(i, [&](std::size_t operand) { needed_[operand] = 1, ++uses_[operand]; });
  }
  const std::vector<std::uint64_t> digest = target_.fused ? digests() : std::vector<std::uint64_t>();
  std::vector<int> delay(nodes_.size(), 0);  // in cycles
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (!needed_[i] || is_input(i)) continue;
    const Operation operation = nodes_[i].operation;
    each_operand(i, [&](std::size_t operand) { delay[i] = std::max(delay[i], delay[operand]); });
    delay[i] += operation == Operation::quotient || operation == Operation::inverse_pivot ? 13 : binary(operation) ? 4 : 0;
    if (!target_.fused || (operation != Operation::sum && operation != Operation::difference)) continue;
    const std::size_t left = at(nodes_[i].a), right = at(nodes_[i].b);
    const auto product = [&](std::size_t k) {
      return nodes_[k].operation == Operation::product && uses_[k] == 1 && !is_input(k);
    };
    const bool first = product(left), second = product(right) && left != right;
    if (!first && !second) continue;
    const bool left_last = delay[left] != delay[right] ? delay[left] > delay[right] : digest[left] > digest[right];
    factor_[i] = first && (!second || left_last) ? 1 : 2;
    fused_[factor_[i] == 1 ? left : right] = 1;
  }
}

machine::Place GraphLowering::pool(double value) {
  out_.pool.push_back(value);
  const int place = static_cast<int>(out_.pool.size()) - 1;
  return {machine::Place::pool, target_.lanes == 1 || target_.avx512, place * machine::pool_stride(target_)};
}

int GraphLowering::append(const machine::Value& value) {
  out_.values.push_back(value);
  return static_cast<int>(out_.values.size()) - 1;
}

int GraphLowering::operation(const machine::Value& value) {
  const int number = append(value);
  out_.order.push_back(number);
  return number;
}

int GraphLowering::visit(std::size_t i) {
  if (value_[i] >= 0) return value_[i];
  using enum machine::Operation;
  if (is_input(i)) return value_[i] = append({load, -1, -1, -1, place_of(i)});
  const auto& n = nodes_[i];
  if (n.operation == Operation::negative) return value_[i] = operation({negate, visit(at(n.a))});
  if (n.operation == Operation::inverse_pivot) return value_[i] = inverse_pivot(visit(at(n.a)), n.b);
  if (factor_[i] != 0) {
    const auto& product = nodes_[at(factor_[i] == 1 ? n.a : n.b)];
    const int left = visit(at(product.a)), right = visit(at(product.b)), rest = visit(at(factor_[i] == 1 ? n.b : n.a));
    const auto kind = n.operation == Operation::sum ? multiply_add : factor_[i] == 1 ? multiply_subtract : subtract_product;
    return value_[i] = operation({kind, left, right, rest});
  }
  const int left = visit(at(n.a)), right = visit(at(n.b));
  const auto kind = n.operation == Operation::sum          ? machine::Operation::add
                    : n.operation == Operation::difference ? subtract
                    : n.operation == Operation::product    ? multiply
                                                           : divide;
  return value_[i] = operation({kind, left, right});
}

/// 1/pivot if the pivot exceeds the least one, else 0, without a branch: g/g is 1 for their difference g > 0.
int GraphLowering::inverse_pivot(int pivot, int index) {
  using enum machine::Operation;
  const int least = append({load, -1, -1, -1, least_pivot(index)});
  const int tiny = append({load, -1, -1, -1, pool(1e-300)});
  const int larger = operation({maximum, pivot, least});
  const int excess = operation({subtract, larger, least});
  const int one_or_zero = operation({divide, excess, operation({maximum, excess, tiny})});
  return operation({divide, one_or_zero, operation({maximum, larger, tiny})});
}

}  // namespace momentree::derive
