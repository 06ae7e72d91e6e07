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
/// room for a number for each value, and then for the function's own memory. Functions are called in doubles.
template <class T, class Shared>
void evaluate(const Function& function, const Target& target, const void* entry, const void* arrays, std::span<T> x) {
  const auto read = []<class X>(X& to, const void* from, int offset) {
    std::memcpy(&to, static_cast<const char*>(from) + offset, sizeof to);
  };
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  std::array<char*, 16> bases{};
  MT_REQUIRE(function.bases.size() <= bases.size() && function.values.size() + at(function.memory) <= x.size(),
             "there is room for the function");
  char* const memory = reinterpret_cast<char*>(x.data() + function.values.size());
  for (std::size_t i = 0; i < function.bases.size(); ++i) {
    const Base& base = function.bases[i];
    char*& start = bases[i];
    std::int32_t offset = 0;
    if (base.memory < 0)
      read(start, entry, base.entry);
    else
      read(start, arrays, base.memory), read(offset, entry, base.entry);
    start += std::ptrdiff_t{offset} * base.times;
  }
  const auto load = [&](const Place& home) {
    if (home.base == Place::pool) return T(function.pool[at(home.offset / pool_stride(target))]);
    T number(0);
    if (home.base == Place::frame) {
      read(number, memory, home.offset);
      return number;
    }
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
  const auto load_all = [&](bool from_memory) {
    for (std::size_t i = 0; i < function.values.size(); ++i)
      if (const Value& v = function.values[i]; v.operation == Operation::load && (v.home.base == Place::frame) == from_memory)
        x[i] = load(v.home);
  };
  const auto store = [&](bool to_memory) {
    for (const Store& one : function.stores)
      if ((one.to.base == Place::frame) == to_memory)
        std::memcpy((to_memory ? memory : bases[at(one.to.base)]) + one.to.offset, &x[at(one.value)], sizeof(T));
  };
  const auto call = [&](const Call& to) {
    if constexpr (sizeof(T) == sizeof(double)) {
      const char* functions = nullptr;
      void (*f)(const void*, double*, int) = nullptr;
      read(functions, entry, to.context), read(f, functions, to.function);
      store(true);
      f(entry, reinterpret_cast<double*>(memory + to.memory), to.index);
      load_all(true);
    }
  };
  load_all(false);
  std::size_t called = 0;
  for (std::size_t t = 0; t < function.order.size(); ++t) {
    for (; called < function.calls.size() && at(function.calls[called].time) <= t; ++called) call(function.calls[called]);
    const int i = function.order[t];
    const Value& v = function.values[at(i)];
    const auto of = [&](int operand) { return x[at(operand)]; };
    T& to = x[at(i)];
    switch (v.operation) {
      case Operation::load: break;
      case Operation::add: to = of(v.a) + of(v.b); break;
      case Operation::subtract: to = of(v.a) - of(v.b); break;
      case Operation::multiply: to = of(v.a) * of(v.b); break;
      case Operation::divide: to = of(v.a) / of(v.b); break;
      case Operation::maximum:
        if constexpr (requires { of(v.a) > of(v.b) ? of(v.a) : of(v.b); }) to = of(v.a) > of(v.b) ? of(v.a) : of(v.b);
        if constexpr (requires { maximum(of(v.a), of(v.b)); }) to = maximum(of(v.a), of(v.b));
        break;
      case Operation::multiply_add: to = product_and(of(v.a), of(v.b), of(v.c)); break;
      case Operation::multiply_subtract: to = product_and(of(v.a), of(v.b), -of(v.c)); break;
      case Operation::subtract_product: to = product_and(-of(v.a), of(v.b), of(v.c)); break;
      case Operation::negate: to = -of(v.a); break;
    }
  }
  store(false);
}

}  // namespace momentree::machine
