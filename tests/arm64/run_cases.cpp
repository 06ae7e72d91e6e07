// Executes the cases of write_cases by the loop that calls steps. Built for AArch64, without the library.
#include <sys/mman.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <momentree/derive/step_arguments.hpp>
#include <momentree/machine/arm64.hpp>
#include <tests/arm64/cases.hpp>

using namespace momentree;

namespace {

unsigned char* executable(const std::vector<unsigned char>& code) {
  void* const memory = ::mmap(nullptr, code.size(), PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) std::perror("mmap"), std::exit(1);
  std::memcpy(memory, code.data(), code.size());
  auto* const begin = static_cast<unsigned char*>(memory);
  __builtin___clear_cache(reinterpret_cast<char*>(begin), reinterpret_cast<char*>(begin + code.size()));
  return begin;
}

/// What entries of generic steps point to.
struct Own {
  StepFunction passes[3];
  int calls = 0;
};
void count(const StepEntry& entry, const StepArrays&) { ++const_cast<Own*>(static_cast<const Own*>(entry.constants))->calls; }

}  // namespace

int main() {
  std::FILE* const from = stdin;
  using Run = void (*)(const StepEntry*, const StepEntry*, const StepArrays*);
  const auto run = reinterpret_cast<Run>(executable(machine::encode_arm64_run(sizeof(StepEntry)).all));
  const auto call = reinterpret_cast<StepFunction>(executable(machine::encode_arm64_call(8).all));
  Own own{{nullptr, count, nullptr}};
  long cases = 0, wrong = 0;
  arm64_cases::Case c;
  while (std::fread(&c, sizeof c, 1, from) == 1) {
    std::vector<unsigned char> code(c.code), before(c.block + 16), after(c.block);
    StepEntry entry;
    unsigned char* block = before.data();
    while (reinterpret_cast<std::uintptr_t>(block) % 16 != 0) ++block;
    if (std::fread(code.data(), c.code, 1, from) != 1 || std::fread(&entry, sizeof entry, 1, from) != 1 ||
        std::fread(block, c.block, 1, from) != 1 || std::fread(after.data(), c.block, 1, from) != 1)
      return std::fprintf(stderr, "run_cases: the file ends early\n"), 1;
    unsigned char* const memory = executable(code);
    entry.step = reinterpret_cast<StepFunction>(memory + c.begin);
    entry.constants = block + c.arrays * c.array;
    StepArrays arrays;
    for (std::uint64_t i = 0; i < c.arrays; ++i) {
      void* const array = block + i * c.array;
      std::memcpy(reinterpret_cast<char*>(&arrays) + i * sizeof array, &array, sizeof array);
    }
    StepEntry generic = entry;
    generic.step = call, generic.constants = &own;
    const StepEntry entries[] = {generic, entry, generic};
    run(entries, entries + 3, &arrays);
    ++cases, wrong += std::memcmp(block, after.data(), c.block) != 0;
    ::munmap(memory, code.size());
  }
  std::printf("%ld cases, %ld wrong, %d calls of generic steps\n", cases, wrong, own.calls);
  return cases > 500 && wrong == 0 && own.calls == 2 * cases ? 0 : 1;
}
