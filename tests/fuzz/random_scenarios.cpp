// Random scenarios, run in many ways: `random_scenarios SEED` shows one and checks it, `random_scenarios SEED COUNT` checks many,
// `random_scenarios --show SEED` only shows one. With `--piles` before all else: of stacks that stand or fall.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <tests/fuzz/random_scenario.hpp>
#include <tests/fuzz/scenario_laws.hpp>

using namespace momentree::fuzz;

int main(int argc, char** argv) {
  const bool piles = argc > 1 && std::strcmp(argv[1], "--piles") == 0;
  if (piles) --argc, ++argv;
  const auto text_of = [piles](Choices& choose) { return piles ? random_pile(choose) : random_scenario(choose); };
  if (argc != 2 && argc != 3) {
    std::fprintf(stderr, "usage: random_scenarios [--piles] SEED [COUNT] | [--piles] --show SEED\n");
    return 2;
  }
  if (std::strcmp(argv[1], "--show") == 0) {
    Choices choose(argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 0);
    return std::printf("%s", text_of(choose).c_str()) > 0 ? 0 : 1;
  }
  const unsigned long first = std::strtoul(argv[1], nullptr, 10), count = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 1;
#ifdef __GLIBC__
  if (argc > 2) stderr = std::fopen("/dev/null", "w");  // warnings of runs; sanitizers write to the file descriptor
#endif
  Findings all;
  int broken = 0;
  for (unsigned long seed = first; seed < first + count; ++seed) {
    Choices choose(seed);
    const std::string text = text_of(choose);
    if (argc == 2) std::printf("%s", text.c_str()), std::fflush(stdout);
    all.broken.clear();
    // Edges that cross the rim of a cylinder do so at points that a document does not have.
    check_scenario(text, choose, all, !piles || text.find("cylinder") == std::string::npos);
    broken += !all.broken.empty();
    for (const std::string& law : all.broken) std::printf("BROKEN seed %lu: %s\n", seed, law.c_str());
    std::fflush(stdout);
  }
  for (const auto& [what, n] : all.counts) std::printf("%-50s %ld\n", what.c_str(), n);
  for (const auto& [law, share] : all.worst) std::printf("%-60s worst %.2g of its tolerance\n", law.c_str(), share);
  std::printf("%lu scenarios, %d with broken laws\n", count, broken);
  return broken ? 1 : 0;
}
