// Writes to its output machine code of AArch64 with what it is called with and what it has to find, by the evaluation of its
// functions: steps of all kinds, of one world and in lanes of both precisions. `run_cases` executes it.
#include <cstdio>
#include <cstdlib>

#include <momentree/derive/step.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/test_support.hpp>
#include <momentree/machine/arm64.hpp>
#include <momentree/machine/test_support.hpp>
#include <tests/arm64/cases.hpp>

namespace momentree {
namespace {

using namespace arm64_cases;

/// The arrays of a step in one block of memory: each has as many numbers.
constexpr std::size_t arrays = sizeof(StepArrays) / sizeof(void*), numbers = 128;

template <class S, int N>
void write_case(const derive::StepKey& key, const derive::Step& step, std::size_t pass, bool adds, Draw& draw, std::FILE* to) {
  using T = machine::Worlds<S, N>;
  const machine::Target target{.lanes = N, .number = sizeof(S), .registers = machine::arm64_registers};
  const machine::Function f = step.function(pass, {.adds = adds}, target);
  const machine::Bytes bytes = machine::encode_arm64(f, machine::allocate(f, target), target);
  std::vector<T> block((arrays + 1) * numbers);  // the last one: constants
  for (T& number : block)
    for (S& x : number.x) x = static_cast<S>(draw());
  const std::vector<T> before = block;
  StepArrays with;
  void* pointers[arrays];
  for (std::size_t i = 0; i < arrays; ++i) pointers[i] = block.data() + i * numbers;
  std::memcpy(static_cast<void*>(&with), pointers, sizeof with);
  const auto size = static_cast<std::int32_t>(sizeof(T));
  StepEntry entry{nullptr, block.data() + arrays * numbers, 3 * size, 5 * size, 7 * size, 9 * size, 11 * size, 60 * size};
  if (keeps_results(key.passes)) entry.in = 1, entry.to = 2, entry.record = 9;  // bodies, and numbers
  std::vector<T> values(f.values.size());
  machine::evaluate<T, S>(f, target, &entry, &with, std::span(values));
  entry.constants = nullptr;
  const Case header{bytes.all.size(), bytes.entry, block.size() * sizeof(T), numbers * sizeof(T), arrays};
  const auto put = [&](const void* from, std::size_t n) {
    if (std::fwrite(from, 1, n, to) != n) std::perror("write_cases"), std::exit(1);
  };
  put(&header, sizeof header), put(bytes.all.data(), bytes.all.size()), put(&entry, sizeof entry);
  put(before.data(), header.block), put(block.data(), header.block);
}

void write_steps(const derive::StepKey& key, Draw& draw, std::FILE* to) {
  const derive::Step step(key);
  for (std::size_t pass = 0; pass < step.passes(); ++pass) {
    const bool adds = pass == step.inward() && draw() < 0;
    write_case<double, 1>(key, step, pass, adds, draw, to), write_case<double, 2>(key, step, pass, adds, draw, to);
    write_case<float, 1>(key, step, pass, adds, draw, to), write_case<float, 4>(key, step, pass, adds, draw, to);
  }
}

}  // namespace
}  // namespace momentree

int main() {
  using namespace momentree;
  std::FILE* const to = stdout;
  Draw draw;
  for (const KindInfo& kind : all_kinds())
    for (const bool armature : {false, true})
      for (const derive::BodyPlace place :
           {derive::BodyPlace::inner, derive::BodyPlace::leaf, derive::BodyPlace::root, derive::BodyPlace::single})
        for (std::size_t passes = 0; passes < kinds_of_passes; ++passes) {
          if (!derive::has_steps(kind.kind, armature ? Variant::armature : Variant::plain)) continue;
          for (unsigned s = 0; s <= static_cast<unsigned>(PlacementShape::parallel_a); s += 5) {
            const LinkConstants link = random_link(draw, static_cast<PlacementShape>(s));
            derive::StepKey key = derive::key_of(kind.kind, armature, place, link);
            key.passes = static_cast<Passes>(passes);
            derive::add_general_pattern(key);
            write_steps(key, draw, to);
          }
        }
  return std::fflush(to) == 0 ? 0 : 1;
}
