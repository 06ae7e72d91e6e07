// Machine code against the evaluation of the same function, bit for bit.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include <momentree/machine/evaluate.hpp>
#include <momentree/machine/memory.hpp>
#include <momentree/machine/test_support.hpp>
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
  void *inputs = nullptr, *changed = nullptr;
};
struct Entry {
  const void* shared = nullptr;
  void* results = nullptr;
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
  const int size = target.vector();
  for (int i = 0; i < numbers; ++i) {
    f.values.push_back({Operation::load, -1, -1, -1, {inputs, false, size * i}});
    f.values.push_back({Operation::load, -1, -1, -1, {changed, false, size * i}});
    f.values.push_back({Operation::load, -1, -1, -1, {shared, true, target.number * i}});
  }
  for (int i = 0; i < 5; ++i) {
    f.values.push_back({Operation::load, -1, -1, -1, {Place::pool, target.lanes == 1 || target.avx512, i * pool_stride(target)}});
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
    f.stores.push_back({v, {results, false, size * i}, f.values[at(v)].operation == Operation::load ? end : known[at(v)]});
    const Place& home = f.values[at(w)].home;
    const bool copy = f.values[at(w)].operation == Operation::load && home.base == changed;
    f.stores.push_back({w, {changed, false, size * i}, end, copy});
  }
  for (Store& one : f.stores)  // a copy to elsewhere, too, comes before the number is changed
    if (f.values[at(one.value)].operation == Operation::load && f.values[at(one.value)].home.base == changed)
      one.due = end, one.read_early = true;
  std::stable_sort(f.stores.begin(), f.stores.end(), [](const Store& a, const Store& b) { return a.due < b.due; });
  return f;
}

template <class S, int N>
struct Memory {
  alignas(64) std::array<Worlds<S, N>, numbers> inputs, changed, results;
  std::array<S, numbers> shared;

  template <class F>
  void run(F&& code) {
    const Arrays arrays{reinterpret_cast<char*>(inputs.data()) - 24, changed.data()};
    const Entry entry{shared.data(), results.data(), 24, 0};
    code(&entry, &arrays);
  }
  bool equals(const Memory& other) const { return changed == other.changed && results == other.results; }
};

template <class S, int N>
void check_bits(std::mt19937& random, Target target) {
  target.lanes = N, target.number = sizeof(S);
  if (!processor_runs(target)) return;
  CodeMemory memory;
  for (int round = 0; round < 300; ++round) {
    const Function f = random_function(random, target);
    const Bytes bytes = encode_x86(f, allocate(f, target), target);
    const std::uint8_t* const code = memory.put(bytes.all);
    REQUIRE(code != nullptr);
    Memory<S, N> found;
    std::uniform_real_distribution<S> any(-2, 2);
    for (auto* array : {&found.inputs, &found.changed, &found.results})
      for (auto& number : *array)
        for (S& x : number.x) x = any(random);
    for (S& x : found.shared) x = any(random);
    Memory<S, N> expected = found;
    found.run(reinterpret_cast<Code>(const_cast<std::uint8_t*>(code) + bytes.entry));
    expected.run([&](const Entry* entry, const Arrays* arrays) {
      std::vector<Worlds<S, N>> x(f.values.size());
      evaluate<Worlds<S, N>, S>(f, target, entry, arrays, std::span(x));
    });
    CHECK(found.equals(expected));
  }
}

TEST_CASE("machine code: random functions have the bits of their evaluation, whatever the registers, lanes and precision") {
  std::mt19937 random(7);
  for (const int registers : {5, 16}) {
    const Target narrow{.registers = registers};
    check_bits<double, 1>(random, narrow), check_bits<double, 4>(random, narrow);
    check_bits<float, 1>(random, narrow), check_bits<float, 8>(random, narrow);
  }
  for (const int registers : {7, 32}) {
    const Target wide{.registers = registers, .avx512 = true};
    check_bits<double, 1>(random, wide), check_bits<double, 4>(random, wide), check_bits<double, 8>(random, wide);
    check_bits<float, 8>(random, wide), check_bits<float, 16>(random, wide);
  }
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
