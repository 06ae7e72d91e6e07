#include <momentree/derive/expressions.hpp>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <new>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/math/sincos.hpp>

namespace momentree {

std::size_t Expressions::Hash::operator()(const Node& node) const {
  std::uint64_t h = std::bit_cast<std::uint64_t>(node.value) + static_cast<std::uint64_t>(node.operation);
  for (const int part : {node.a, node.b}) {
    h = (h ^ static_cast<std::uint64_t>(part)) * 0x9e3779b97f4a7c15u;
    h ^= h >> 29;
  }
  return static_cast<std::size_t>(h);
}

Expressions::Expressions() {
  make(Operation::constant, 0, 0, 0.0);
  if (exhausted_) throw std::bad_alloc();
}

int Expressions::make(Operation operation, int a, int b, double value) {
  if (exhausted_) return zero;
  const Node node{operation, a, b, value};
  try {
    const auto [place, fresh] = numbers_.emplace(node, static_cast<int>(nodes_.size()));
    if (fresh) nodes_.push_back(node);
    return place->second;
  } catch (const std::bad_alloc&) {
    exhausted_ = true;
    return zero;
  }
}

int Expressions::constant(double value) {
  return make(Operation::constant, 0, 0, value == 0 ? 0.0 : value);  // −0 becomes 0
}

int Expressions::input(Operation array, int index) {
  MT_REQUIRE(array == Operation::q || array == Operation::p || array == Operation::tau, "q, p and tau are the inputs");
  MT_REQUIRE(index >= 0, "an index into q, p or tau");
  return make(array, index, 0);
}

int Expressions::sine(int angle) {
  if (!is(angle, Operation::constant)) return make(Operation::sine, angle, 0);
  double s = 0, c = 0;
  sincos(at(angle).value, s, c);
  return constant(s);
}
int Expressions::cosine(int angle) {
  if (!is(angle, Operation::constant)) return make(Operation::cosine, angle, 0);
  double s = 0, c = 0;
  sincos(at(angle).value, s, c);
  return constant(c);
}

int Expressions::negative(int a) {
  if (is(a, Operation::constant)) return constant(-at(a).value);
  if (is(a, Operation::negative)) return at(a).a;
  return make(Operation::negative, a, 0);
}

int Expressions::inverse_pivot(int a, int index) {
  MT_REQUIRE(index >= 0, "an index into the least pivots");
  return make(Operation::inverse_pivot, a, index);
}

int Expressions::call(int loop, std::vector<int> arguments, int answers) {
  MT_REQUIRE(answers > 0, "a call has an answer");
  const int first = calls_.empty() ? 0 : calls_.back().first_answer + calls_.back().answers;
  if (exhausted_) return zero;
  try {
    calls_.push_back({loop, std::move(arguments), first, answers});
  } catch (const std::bad_alloc&) {
    exhausted_ = true;
    return zero;
  }
  const int node = make(Operation::answer, first, 0);
  for (int i = 1; i < answers; ++i) make(Operation::answer, first + i, 0);
  return exhausted_ ? zero : node;
}

int Expressions::call_of(int answer) const {
  const auto next =
      std::upper_bound(calls_.begin(), calls_.end(), answer, [](int a, const Call& call) { return a < call.first_answer; });
  MT_REQUIRE(next != calls_.begin(), "an answer of these calls");
  return static_cast<int>(next - calls_.begin()) - 1;
}

bool Expressions::is_square_of(int i, Operation operation) const {
  return is(i, Operation::product) && at(i).a == at(i).b && is(at(i).a, operation);
}

int Expressions::sum_that_cancels(int a, int b) {
  if (is_square_of(a, Operation::sine) && is_square_of(b, Operation::cosine) && at(at(a).a).a == at(at(b).a).a)
    return constant(1);
  if (is_square_of(b, Operation::sine) && is_square_of(a, Operation::cosine) && at(at(a).a).a == at(at(b).a).a)
    return constant(1);
  if (is(a, Operation::difference) && at(a).b == b) return at(a).a;
  if (is(b, Operation::difference) && at(b).b == a) return at(b).a;
  return none;
}

int Expressions::difference_that_cancels(int a, int b) {
  if (is(b, Operation::sum) && at(b).a == a) return negative(at(b).b);
  if (is(b, Operation::sum) && at(b).b == a) return negative(at(b).a);
  if (is(a, Operation::sum) && at(a).a == b) return at(a).b;
  if (is(a, Operation::sum) && at(a).b == b) return at(a).a;
  if (is(b, Operation::difference) && at(b).a == a) return at(b).b;
  if (is(a, Operation::difference) && at(a).a == b) return negative(at(a).b);
  return none;
}

int Expressions::sum(int a, int b) {
  if (is(a, Operation::constant) && is(b, Operation::constant)) return constant(at(a).value + at(b).value);
  if (a == zero) return b;
  if (b == zero) return a;
  if (is(a, Operation::negative) && is(b, Operation::negative)) return negative(sum(at(a).a, at(b).a));
  if (is(b, Operation::negative)) return difference(a, at(b).a);
  if (is(a, Operation::negative)) return difference(b, at(a).a);
  if (const int less = cancels_ ? sum_that_cancels(a, b) : none; less != none) return less;
  if (is(a, Operation::constant)) std::swap(a, b);
  if (is(b, Operation::constant) && at(b).value < 0) return difference(a, constant(-at(b).value));
  if (a > b) std::swap(a, b);
  return make(Operation::sum, a, b);
}

int Expressions::difference(int a, int b) {
  if (a == b) return zero;
  if (is(a, Operation::constant) && is(b, Operation::constant)) return constant(at(a).value - at(b).value);
  if (a == zero) return negative(b);
  if (b == zero) return a;
  if (is(a, Operation::negative) && is(b, Operation::negative)) return difference(at(b).a, at(a).a);
  if (is(b, Operation::negative)) return sum(a, at(b).a);
  if (is(a, Operation::negative)) return negative(sum(at(a).a, b));
  if (const int less = cancels_ ? difference_that_cancels(a, b) : none; less != none) return less;
  if (is(b, Operation::constant) && at(b).value < 0) return sum(a, constant(-at(b).value));
  if (is(a, Operation::constant) && at(a).value < 0) return negative(sum(constant(-at(a).value), b));
  if (a > b) return negative(make(Operation::difference, b, a));  // a − b and b − a are one node
  return make(Operation::difference, a, b);
}

int Expressions::product(int a, int b) {
  if (is(a, Operation::constant) && is(b, Operation::constant)) return constant(at(a).value * at(b).value);
  if (is(b, Operation::constant)) std::swap(a, b);
  if (is(a, Operation::negative) && is(b, Operation::negative)) return product(at(a).a, at(b).a);
  if (is(a, Operation::constant)) {
    const double value = at(a).value;
    if (value == 0) return zero;
    if (value == 1) return b;
    if (value < 0) return negative(product(constant(-value), b));
    if (is(b, Operation::product) && is(at(b).a, Operation::constant))
      return product(constant(value * at(at(b).a).value), at(b).b);
  }
  if (is(a, Operation::negative)) return negative(product(at(a).a, b));
  if (is(b, Operation::negative)) return negative(product(a, at(b).a));
  if (!is(a, Operation::constant) && a > b) std::swap(a, b);
  return make(Operation::product, a, b);
}

int Expressions::quotient(int a, int b) {
  if (is(a, Operation::constant) && is(b, Operation::constant)) return constant(at(a).value / at(b).value);
  if (a == zero) return zero;
  if (is(b, Operation::constant) && at(b).value == 1) return a;
  if (is(a, Operation::negative)) return negative(quotient(at(a).a, b));
  if (is(b, Operation::negative)) return negative(quotient(a, at(b).a));
  return make(Operation::quotient, a, b);
}

// Operands come before the nodes that use them, and arguments before answers.
std::vector<bool> Expressions::needed(std::span<const int> results) const {
  std::vector<bool> needed(nodes_.size(), false);
  for (const int r : results) {
    MT_REQUIRE(static_cast<std::size_t>(r) < nodes_.size(), "a node of these expressions");
    needed[static_cast<std::size_t>(r)] = true;
  }
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    if (!needed[i]) continue;
    const Node& node = nodes_[i];
    if (unary(node.operation) || binary(node.operation)) needed[static_cast<std::size_t>(node.a)] = true;
    if (binary(node.operation)) needed[static_cast<std::size_t>(node.b)] = true;
    if (node.operation == Operation::answer)
      for (const int argument : calls_[static_cast<std::size_t>(call_of(node.a))].arguments)
        needed[static_cast<std::size_t>(argument)] = true;
  }
  return needed;
}

Operations Expressions::operations(std::span<const int> results) const {
  const std::vector<bool> asked = needed(results);
  std::vector<bool> angles(nodes_.size(), false);
  Operations all;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (!asked[i]) continue;
    switch (nodes_[i].operation) {
      case Operation::sum:
      case Operation::difference: ++all.additions; break;
      case Operation::product: ++all.multiplications; break;
      case Operation::quotient:
      case Operation::inverse_pivot: ++all.divisions; break;
      case Operation::sine:
      case Operation::cosine: {
        const auto angle = static_cast<std::size_t>(nodes_[i].a);
        if (!angles[angle]) ++all.sincos;
        angles[angle] = true;
        break;
      }
      default: break;
    }
  }
  return all;
}

}  // namespace momentree
