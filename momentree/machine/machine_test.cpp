// Machine code against the evaluation of the same function, bit for bit.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

#include <momentree/machine/memory.hpp>
#include <momentree/machine/x86.hpp>

#ifdef __linux__
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace momentree::machine {
namespace {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

// What the functions below are called with.
struct Arrays {
  double *inputs = nullptr, *changed = nullptr;
};
struct Entry {
  const double* shared = nullptr;
  double* results = nullptr;
  std::int32_t inputs = 0, changed = 0;
};
enum : std::int8_t { inputs, changed, shared, results };
const std::vector<Base> bases{{offsetof(Entry, inputs), offsetof(Arrays, inputs)},
                              {offsetof(Entry, changed), offsetof(Arrays, changed)},
                              {offsetof(Entry, shared), -1},
                              {offsetof(Entry, results), -1}};
constexpr int numbers = 12;  // in each array
using Code = void (*)(const Entry*, const Arrays*);

/// Operations on numbers of all arrays and constants. It writes results, and over numbers that it has read.
Function random_function(std::mt19937& random, const Target& target) {
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  Function f;
  f.bases = bases;
  const int lanes = target.lanes;
  for (int i = 0; i < numbers; ++i) {
    f.values.push_back({Operation::load, -1, -1, -1, {inputs, false, 8 * lanes * i}});
    f.values.push_back({Operation::load, -1, -1, -1, {changed, false, 8 * lanes * i}});
    f.values.push_back({Operation::load, -1, -1, -1, {shared, true, 8 * i}});
  }
  for (int i = 0; i < 5; ++i) {
    f.values.push_back({Operation::load, -1, -1, -1, {Place::pool, lanes == 1 || target.avx512, i * pool_stride(target)}});
    f.pool.push_back(0.25 * i - 0.5);
  }
  for (int k = below(120); k > 0; --k) {
    const int n = static_cast<int>(f.values.size());
    Value x{static_cast<Operation>(1 + below(8)), below(n)};
    if (x.operation != Operation::negate) x.b = below(n);
    if (x.operation >= Operation::multiply_add && x.operation != Operation::negate) x.c = below(n);
    f.order.push_back(n);
    f.values.push_back(x);
  }
  const int n = static_cast<int>(f.values.size()), end = static_cast<int>(f.order.size());
  std::vector<int> known(at(n), 0);
  for (int t = 0; t < end; ++t) known[at(f.order[at(t)])] = t + 1;
  for (int i = 0; i < numbers; ++i) {
    const int v = below(n), w = below(n);
    f.stores.push_back({v, {results, false, 8 * lanes * i}, f.values[at(v)].operation == Operation::load ? end : known[at(v)]});
    const Place& home = f.values[at(w)].home;
    const bool copy = f.values[at(w)].operation == Operation::load && home.base == changed;
    f.stores.push_back({w, {changed, false, 8 * lanes * i}, end, copy});
  }
  for (Store& one : f.stores)  // a copy to elsewhere, too, comes before the number is changed
    if (f.values[at(one.value)].operation == Operation::load && f.values[at(one.value)].home.base == changed)
      one.due = end, one.read_early = true;
  std::stable_sort(f.stores.begin(), f.stores.end(), [](const Store& a, const Store& b) { return a.due < b.due; });
  return f;
}

double value_of(const std::vector<double>& x, const Value& v) {
  const auto of = [&](int i) { return x[at(i)]; };
  switch (v.operation) {
    case Operation::add: return of(v.a) + of(v.b);
    case Operation::subtract: return of(v.a) - of(v.b);
    case Operation::multiply: return of(v.a) * of(v.b);
    case Operation::divide: return of(v.a) / of(v.b);
    case Operation::multiply_add: return std::fma(of(v.a), of(v.b), of(v.c));
    case Operation::multiply_subtract: return std::fma(of(v.a), of(v.b), -of(v.c));
    case Operation::subtract_product: return std::fma(-of(v.a), of(v.b), of(v.c));
    default: return -of(v.a);
  }
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

struct Memory {
  alignas(64) std::array<double, numbers * 8> inputs, changed, results;
  std::array<double, numbers> shared;
};

void check_bits(const Function& f, const Target& target, Code code, Memory before) {
  Memory after = before;
  const Arrays arrays{after.inputs.data() - 3, after.changed.data()};
  const Entry entry{after.shared.data(), after.results.data(), 3 * 8, 0};
  code(&entry, &arrays);
  for (int lane = 0; lane < target.lanes; ++lane) {
    const auto memory_of = [&](Memory& m, const Place& place) -> double& {
      const int offset = place.offset / 8 + (place.shared ? 0 : lane);
      return place.base == inputs    ? m.inputs[at(offset)]
             : place.base == changed ? m.changed[at(offset)]
             : place.base == shared  ? m.shared[at(offset)]
                                     : m.results[at(offset)];
    };
    std::vector<double> x(f.values.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Value& v = f.values[i];
      if (v.operation != Operation::load)
        x[i] = value_of(x, v);
      else
        x[i] = v.home.base == Place::pool ? f.pool[at(v.home.offset / pool_stride(target))] : memory_of(before, v.home);
    }
    for (const Store& one : f.stores) CHECK(same_bits(memory_of(after, one.to), x[at(one.value)]));
  }
}

TEST_CASE("machine code: random functions have the bits of their evaluation, whatever the registers and lanes") {
  std::mt19937 random(7);
  CodeMemory memory;
  int run = 0;
  for (const Target& target : {Target{1, 16}, Target{1, 5}, Target{1, 32, true}, Target{4, 16}, Target{4, 6}, Target{4, 32, true},
                               Target{8, 32, true}, Target{8, 7, true}}) {
    if (!processor_runs(target)) continue;
    for (int round = 0; round < 300; ++round) {
      const Function f = random_function(random, target);
      const Bytes bytes = encode_x86(f, allocate(f, target), target);
      const std::uint8_t* const code = memory.put(bytes.all);
      REQUIRE(code != nullptr);
      Memory numbers_in;
      std::uniform_real_distribution<double> any(-2, 2);
      for (auto* array : {&numbers_in.inputs, &numbers_in.changed, &numbers_in.results})
        for (double& x : *array) x = any(random);
      for (double& x : numbers_in.shared) x = any(random);
      check_bits(f, target, reinterpret_cast<Code>(const_cast<std::uint8_t*>(code) + bytes.entry), numbers_in);
      ++run;
    }
  }
  MESSAGE(run << " functions");
}

#if defined(__linux__) && defined(__x86_64__)
TEST_CASE("code memory: a forked process executes what there was, and adds code without changing that of its parent") {
  const auto constant = [](double x) {  // a function that stores a constant
    Function f;
    f.bases = bases;
    f.pool = {x};
    f.values.push_back({Operation::load, -1, -1, -1, {Place::pool, true, 0}});
    f.stores.push_back({0, {results, false, 0}, 0});
    return encode_x86(f, allocate(f, {}), {});
  };
  if (!processor_runs({})) return;
  CodeMemory memory;
  const auto call = [](const std::uint8_t* code, const Bytes& bytes) {
    double result = 0;
    const Arrays arrays{};
    const Entry entry{nullptr, &result};
    reinterpret_cast<Code>(const_cast<std::uint8_t*>(code) + bytes.entry)(&entry, &arrays);
    return result;
  };
  const Bytes one = constant(1), two = constant(2), three = constant(3);
  const std::uint8_t* const first = memory.put(one.all);
  REQUIRE(first != nullptr);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const std::uint8_t* const own = memory.put(two.all);
    ::_exit(own != nullptr && call(first, one) == 1 && call(own, two) == 2 ? 0 : 1);
  }
  int status = -1;
  CHECK(::waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  const std::uint8_t* const later = memory.put(three.all);
  REQUIRE(later != nullptr);
  CHECK(call(later, three) == 3);
  CHECK(call(first, one) == 1);
}
#endif

}  // namespace
}  // namespace momentree::machine
