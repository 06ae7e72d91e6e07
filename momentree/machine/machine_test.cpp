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
#include <momentree/machine/native.hpp>
#include <momentree/machine/test_support.hpp>

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
  const void* context = nullptr;
};
enum : std::int8_t { inputs, changed, shared, results };
const std::vector<Base> bases{{offsetof(Entry, inputs), offsetof(Arrays, inputs)},
                              {offsetof(Entry, changed), offsetof(Arrays, changed), 24},
                              {offsetof(Entry, shared), -1},
                              {offsetof(Entry, results), -1}};
constexpr int numbers = 12;  // in each array
using Code = void (*)(const Entry*, const Arrays*);

// A function of C++ that changes what it is given, and its context.
void twice(const void* entry, double* memory, int index) {
  memory[1] = 2 * memory[0] + static_cast<const Entry*>(entry)->inputs + index;
  memory[0] = 1e9;
  volatile double clobbered = std::sqrt(memory[1] * memory[1] + 1);
  static_cast<void>(clobbered);
}
struct Context {
  void (*none)() = nullptr;
  void (*f)(const void*, double*, int) = twice;
};

/// Operations on numbers of all arrays and constants, and calls. It writes results, and over numbers that it has read.
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
    if (target.lanes == 1 && target.number == 8 && below(20) == 0) {
      const int given = below(static_cast<int>(f.values.size())), memory = 8 * f.memory;
      const int time = static_cast<int>(f.order.size());
      f.memory += 2;
      f.stores.push_back({given, {Place::frame, false, memory}, time});
      f.calls.push_back({time, offsetof(Entry, context), offsetof(Context, f), memory, below(9)});
      f.values.push_back({Operation::load, -1, -1, -1, {Place::frame, false, memory + 8}});
    }
    const int n = static_cast<int>(f.values.size());
    Value x{static_cast<Operation>(1 + below(9)), below(n)};
    if (x.operation != Operation::negate) x.b = below(n);
    if (x.operation >= Operation::multiply_add && x.operation != Operation::negate) x.c = below(n);
    f.order.push_back(n);
    f.values.push_back(x);
  }
  const int n = static_cast<int>(f.values.size()), end = static_cast<int>(f.order.size());
  std::vector<int> known(at(n), 0);
  for (int t = 0; t < end; ++t) known[at(f.order[at(t)])] = t + 1;
  const auto any = [&] {  // not what a call leaves in the function's memory
    int v = below(n);
    while (f.values[at(v)].home.base == Place::frame) v = below(n);
    return v;
  };
  for (int i = 0; i < numbers; ++i) {
    const int v = any(), w = any();
    f.stores.push_back({v, {results, false, size * i}, f.values[at(v)].operation == Operation::load ? end : known[at(v)]});
    const Place& home = f.values[at(w)].home;
    const bool copy = f.values[at(w)].operation == Operation::load && home.base == changed;
    f.stores.push_back({w, {changed, false, size * i}, end, copy});
  }
  for (Store& one : f.stores)  // of a call: as soon as it is known
    if (one.to.base == Place::frame && f.values[at(one.value)].operation != Operation::load) one.due = known[at(one.value)];
  for (Store& one : f.stores)  // a copy to elsewhere, too, comes before the number is changed
    if (f.values[at(one.value)].operation == Operation::load && f.values[at(one.value)].home.base == changed &&
        one.to.base != Place::frame)
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
    const Context context;
    const Entry entry{shared.data(), results.data(), 24, 0, &context};
    code(&entry, &arrays);
  }
  bool equals(const Memory& other) const { return changed == other.changed && results == other.results; }
};

bool runs(const Target& target) {
#ifdef __aarch64__
  return !target.avx512 && (target.lanes == 1 || target.vector() == 16);
#else
  return target.vector() != 16 && processor_runs(target);
#endif
}

template <class S, int N>
void check_bits(std::mt19937& random, Target target) {
  target.lanes = N, target.number = sizeof(S);
  if (!runs(target)) return;
  CodeMemory memory;
  for (int round = 0; round < 300; ++round) {
    const Function f = random_function(random, target);
    const Bytes bytes = encode(f, allocate(f, target), target);
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
      std::vector<Worlds<S, N>> x(f.values.size() + at(f.memory));
      evaluate<Worlds<S, N>, S>(f, target, entry, arrays, std::span(x));
    });
    CHECK(found.equals(expected));
  }
}

TEST_CASE("machine code: random functions have the bits of their evaluation, whatever the registers, lanes and precision") {
  std::mt19937 random(7);
  for (const int registers : {5, 16}) {
    const Target narrow{.registers = registers};
    check_bits<double, 1>(random, narrow), check_bits<double, 2>(random, narrow), check_bits<double, 4>(random, narrow);
    check_bits<float, 1>(random, narrow), check_bits<float, 4>(random, narrow), check_bits<float, 8>(random, narrow);
  }
  for (const int registers : {7, 32}) {
    const Target wide{.registers = registers, .avx512 = true};
    check_bits<double, 1>(random, wide), check_bits<double, 4>(random, wide), check_bits<double, 8>(random, wide);
    check_bits<float, 8>(random, wide), check_bits<float, 16>(random, wide);
  }
}

TEST_CASE("a function of C: up to six arguments, and a context for what it calls") {
  const std::optional<Target> target = native_target(1, 8);
  if (!target) return;
  struct Scaled {
    void (*f)(const void*, double*, int) = [](const void* entry, double* memory, int index) {
      const auto& with = *static_cast<const CalledWith*>(entry);
      memory[1] = index * memory[0] * static_cast<const Scaled*>(with.context)->by;
    };
    double by = 0.5;
  } scaled;
  Function f;  // arguments[5] = 7 · 0.5 · (the sum of the first four) + what is behind the pointer that the fourth points to
  for (int i = 0; i < 6; ++i) f.bases.push_back({8 * i});
  f.bases.push_back({offsetof(CalledWith, zero), 0});
  const auto load = [&](std::int8_t base) {
    f.values.push_back({Operation::load, -1, -1, -1, {base, false, 8}});
    return static_cast<int>(f.values.size()) - 1;
  };
  const auto sum = [&](int a, int b) {
    f.values.push_back({Operation::add, a, b});
    f.order.push_back(static_cast<int>(f.values.size()) - 1);
    return f.order.back();
  };
  const int given = sum(sum(load(0), load(1)), sum(load(2), load(4)));
  f.memory = 2;
  f.stores.push_back({given, {Place::frame, false, 0}, 3});
  f.calls.push_back({3, offsetof(CalledWith, context), offsetof(Scaled, f), 0, 7});
  f.values.push_back({Operation::load, -1, -1, -1, {Place::frame, false, 8}});
  const int answer = static_cast<int>(f.values.size()) - 1;
  f.stores.push_back({sum(answer, load(6)), {5, false, 8}, 4});
  const Bytes bytes = with_arguments(encode(f, allocate(f, *target), *target), &scaled);
  CodeMemory memory(4096);
  const std::uint8_t* const code = memory.put(bytes.all);
  REQUIRE(code != nullptr);
  const double a[2]{0, 1}, b[2]{0, 2}, c[2]{0, 4}, behind[2]{0, 0.25}, e[2]{0, 8};
  const double* const d[1]{behind};
  double result[2]{};
  using Six = void (*)(const double*, const double*, const double*, const double* const*, const double*, double*);
  reinterpret_cast<Six>(const_cast<std::uint8_t*>(code) + bytes.entry)(a, b, c, d, e, result);
  CHECK(result[1] == 7 * 0.5 * 15 + 0.25);
  CHECK(result[0] == 0);
}

#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
TEST_CASE("code memory: a forked process executes what there was, and adds code without changing that of its parent") {
  const auto constant = [](double x) {  // a function that stores a constant
    Function f;
    f.bases = bases;
    f.pool = {x};
    f.values.push_back({Operation::load, -1, -1, -1, {Place::pool, true, 0}});
    f.stores.push_back({0, {results, false, 0}, 0});
    return encode(f, allocate(f, {}), {});
  };
  if (!runs({})) return;
  CodeMemory memory;
  const auto call = [](const std::uint8_t* code, const Bytes& bytes) {
    double result = 0;
    const Arrays arrays{};
    const Entry entry{nullptr, &result, 0, 0, nullptr};
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
