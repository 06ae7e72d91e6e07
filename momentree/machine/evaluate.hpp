#pragma once
// A function carried out operation by operation, with any scalar: what its machine code does, for tests and for recordings.
#include <array>
#include <cstring>
#include <span>

#include <momentree/base/check.hpp>
#include <momentree/machine/function.hpp>

namespace momentree::machine {

/// `entry`, `arrays`: what the machine code would be called with. Numbers in memory are of type T, except those that all worlds
/// share, of type `Shared`. Nothing is handed on in registers. Multiply-adds are fused(a, b, c) if T has such a function. `x`:
/// room for a number for each value.
template <class T, class Shared>
void evaluate(const Function& function, const Target& target, const void* entry, const void* arrays, std::span<T> x) {
  const auto read = []<class X>(X& to, const void* from, int offset) {
    std::memcpy(&to, static_cast<const char*>(from) + offset, sizeof to);
  };
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  std::array<char*, 16> bases{};
  MT_REQUIRE(function.bases.size() <= bases.size() && function.values.size() <= x.size(), "there is room for the function");
  for (std::size_t i = 0; i < function.bases.size(); ++i) {
    const Base& base = function.bases[i];
    char*& start = bases[i];
    std::int32_t offset = 0;
    if (base.memory < 0)
      read(start, entry, base.entry);
    else
      read(start, arrays, base.memory), read(offset, entry, base.entry);
    start += offset;
  }
  const auto load = [&](const Place& home) {
    if (home.base == Place::pool) return T(function.pool[at(home.offset / pool_stride(target))]);
    T number(0);
    if (Shared shared{}; home.shared)
      read(shared, bases[at(home.base)], home.offset / target.number * static_cast<int>(sizeof shared)), number = T(shared);
    else
      read(number, bases[at(home.base)], home.offset);
    return number;
  };
  const auto product_and = [](const T& a, const T& b, const T& c) {
    if constexpr (requires { fused(a, b, c); })
      return fused(a, b, c);
    else
      return a * b + c;
  };
  for (std::size_t i = 0; i < function.values.size(); ++i)
    if (function.values[i].operation == Operation::load) x[i] = load(function.values[i].home);
  for (const int i : function.order) {
    const Value& v = function.values[at(i)];
    const auto of = [&](int operand) { return x[at(operand)]; };
    T& to = x[at(i)];
    switch (v.operation) {
      case Operation::load: break;
      case Operation::add: to = of(v.a) + of(v.b); break;
      case Operation::subtract: to = of(v.a) - of(v.b); break;
      case Operation::multiply: to = of(v.a) * of(v.b); break;
      case Operation::divide: to = of(v.a) / of(v.b); break;
      case Operation::multiply_add: to = product_and(of(v.a), of(v.b), of(v.c)); break;
      case Operation::multiply_subtract: to = product_and(of(v.a), of(v.b), -of(v.c)); break;
      case Operation::subtract_product: to = product_and(-of(v.a), of(v.b), of(v.c)); break;
      case Operation::negate: to = -of(v.a); break;
    }
  }
  for (const Store& one : function.stores) std::memcpy(bases[at(one.to.base)] + one.to.offset, &x[at(one.value)], sizeof(T));
}

}  // namespace momentree::machine
