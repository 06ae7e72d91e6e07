// A fuzzer's bytes choose a scenario and the instants at which its runs are stopped; all laws must hold for it.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include <tests/fuzz/random_scenario.hpp>
#include <tests/fuzz/scenario_laws.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace momentree::fuzz;
  Choices choose(std::span(data, size));
  const std::string text = random_scenario(choose, false);
  Findings found;
  check_scenario(text, choose, found);
  if (found.broken.empty()) return 0;
  std::fprintf(stderr, "%s\n", text.c_str());
  for (const std::string& law : found.broken) std::fprintf(stderr, "BROKEN: %s\n", law.c_str());
  std::abort();
}
