// Runs scenario files and checks the laws: `check_scenarios STEPS FILE…` runs at most so many steps of each.
#include <cstdio>
#include <cstdlib>

#include <tests/fuzz/scenario_laws.hpp>

using namespace momentree::fuzz;

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: check_scenarios STEPS FILE...\n");
    return 2;
  }
  Findings all;
  int broken = 0;
  for (int i = 2; i < argc; ++i) {
    Choices choose(static_cast<std::uint64_t>(i));
    all.broken.clear();
    check_file(argv[i], std::strtol(argv[1], nullptr, 10), choose, all);
    broken += !all.broken.empty();
    for (const std::string& law : all.broken) std::printf("BROKEN %s: %s\n", argv[i], law.c_str());
    std::fflush(stdout);
  }
  for (const auto& [what, n] : all.counts) std::printf("%-50s %ld\n", what.c_str(), n);
  for (const auto& [law, share] : all.worst) std::printf("%-60s worst %.2g of its tolerance\n", law.c_str(), share);
  std::printf("%d files, %d with broken laws\n", argc - 2, broken);
  return broken ? 1 : 0;
}
