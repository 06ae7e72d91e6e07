// Usage: random_accelerations FIRST COUNT. Checks accelerations and joint wrenches of random trees FIRST … FIRST + COUNT − 1 of 1
// … 200 bodies against the oracle; every other tree has only single-DoF joints (and welds). The tolerance is 1e-12 for these and
// 1e-10 for all others, or ε times the condition of the mass matrix if that is larger, plus for joint accelerations 8 ε times the
// accelerations that the forces would cause if they did not cancel. Prints the worst figures; exits with 1 if a law is violated.
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include <momentree/dynamics/momentum.hpp>
#include <tests/oracle/laws.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

struct Worst {
  double error = 0, ratio = 0;  ///< ratio: to the bound
  int count = 0, beyond = 0;
};

// A third of the seeds make trees with free roots.
std::uint64_t seed_of(unsigned long tree, bool single_dof) {
  if (!single_dof) return 50000 + tree;
  constexpr std::uint64_t not_free[6] = {0, 1, 2, 6, 7, 8};
  return 90000 + tree / 2 / 6 * 9 + not_free[tree / 2 % 6];
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: random_accelerations FIRST COUNT\n");
    return 2;
  }
  const unsigned long first = std::strtoul(argv[1], nullptr, 10), count = std::strtoul(argv[2], nullptr, 10);
  std::map<std::string, Worst> worst;
  int broken = 0;
  for (unsigned long i = first; i < first + count; ++i) {
    RandomTreeOptions options;
    const bool single_dof = i % 2 == 0;
    if (single_dof) options.kinds = {Kind::revolute, Kind::prismatic, Kind::helical, Kind::weld};
    options.several_mechanisms = !single_dof;  // further mechanisms may have free roots
    options.max_bodies = i % 40 < 2 ? 200 : 25;
    const std::uint64_t seed = seed_of(i, single_dof);
    const RandomTree random = random_tree(seed, options);
    const System system = system_of(random.model);
    const Tree tree(random.model);
    Workspace<double> workspace(tree);
    State state = start_state(random.model, tree);
    if (i % 4 >= 2) {  // a state drawn by momenta
      Prng draw(seed + 1000000);
      for (double& p : state.edit().p) p = draw.uniform(-1, 1);
    }
    const Spectrum range = spectrum(mass_matrix(system, start_q(random.model)));
    for (const Measure& m : measure_accelerations(system, tree, state, workspace, range)) {
      Worst& w = worst[std::string(single_dof ? "one freedom: " : "all kinds: ") + m.law];
      const bool beyond = m.error > (single_dof ? 1e-12 : 1e-10);
      w.error = std::max(w.error, m.error);
      w.ratio = std::max(w.ratio, m.ratio());
      w.beyond += beyond;
      ++w.count;
      if (m.holds()) continue;
      if (++broken <= 40)
        std::printf("BROKEN %s: seed %lu (%d bodies, cond %.1e): %.3e > %.3e\n", m.law, static_cast<unsigned long>(seed),
                    random.model.size(), range.condition(), m.error, m.bound);
    }
  }
  for (const auto& [law, w] : worst)
    std::printf("%-42s worst %.2e, %.2g of its bound; of %d trees %d beyond the fixed bound\n", law.c_str(), w.error, w.ratio,
                w.count, w.beyond);
  std::printf("%lu trees, %d laws broken\n", count, broken);
  return broken > 0 ? 1 : 0;
}
