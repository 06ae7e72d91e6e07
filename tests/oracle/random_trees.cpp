// Usage: random_trees FIRST COUNT. Measures the laws on random trees FIRST … FIRST + COUNT − 1, each at a state drawn by
// velocities and at one drawn by momenta. Prints the worst measure of every law; exits with 1 if one is violated.
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
  double ratio = -1, error = 0, bound = 0;
  unsigned long seed = 0;
};

struct Record {
  std::map<std::string, Worst> worst;
  int broken = 0;

  void enter(const std::vector<Measure>& laws, const RandomTree& tree, unsigned long seed, const char* drawn, double condition) {
    for (const Measure& m : laws) {
      Worst& w = worst[std::string(m.law) + ", " + drawn];
      if (m.ratio() > w.ratio || !m.holds()) w = {m.ratio(), m.error, m.bound, seed};
      if (m.holds()) continue;
      if (++broken <= 40)
        std::printf("BROKEN %s: seed %lu (%s, %s root, %d bodies, cond %.1e, drawn by %s): %.3e > %.3e\n", m.law, seed,
                    tree.shape == Shape::chain   ? "chain"
                    : tree.shape == Shape::bushy ? "bushy"
                                                 : "mixed",
                    tree.root == Root::welded ? "welded"
                    : tree.root == Root::free ? "free"
                                              : "jointed",
                    tree.model.size(), condition, drawn, m.error, m.bound);
    }
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: random_trees FIRST COUNT\n");
    return 2;
  }
  const unsigned long first = std::strtoul(argv[1], nullptr, 10), count = std::strtoul(argv[2], nullptr, 10);
  Record record;
  for (unsigned long seed = first; seed < first + count; ++seed) {
    const RandomTree random = random_tree(seed);
    const System system = system_of(random.model);
    const Tree tree(random.model);
    Workspace<double> workspace(tree);
    State state = start_state(random.model, tree);
    const StateMeasures by_v = measure_state(system, tree, state, workspace);
    record.enter(by_v.laws, random, seed, "v", by_v.range.condition());
    record.enter(measure_accelerations(system, tree, state, workspace, by_v.range), random, seed, "v", by_v.range.condition());
    record.enter(measure_round_trip(system, start_v(random.model), tree, state, workspace), random, seed, "v",
                 by_v.range.condition());

    Prng draw(seed + 1000000);
    for (double& p : state.edit().p) p = draw.uniform(-1, 1);
    const StateMeasures by_p = measure_state(system, tree, state, workspace);
    record.enter(by_p.laws, random, seed, "p", by_p.range.condition());
    record.enter(measure_accelerations(system, tree, state, workspace, by_p.range), random, seed, "p", by_p.range.condition());
  }
  for (const auto& [law, w] : record.worst)
    std::printf("%-36s worst %.2e of bound %.2e (ratio %.2g, seed %lu)\n", law.c_str(), w.error, w.bound, w.ratio, w.seed);
  std::printf("%lu trees, %d laws broken\n", count, record.broken);
  return record.broken ? 1 : 0;
}
