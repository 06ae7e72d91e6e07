// Accelerations and joint wrenches of trees whose joints were locked, re-rooted, broken and replaced. (For trees as declared:
// random_accelerations.)
#include <cmath>
#include <cstdio>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <tests/oracle/laws.hpp>
#include <tests/oracle/machine.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

void check(const std::vector<oracle::Measure>& laws) {
  for (const oracle::Measure& m : laws) {
    INFO(m.law, ": ", m.error, " of ", m.bound);
    CHECK(m.holds());
  }
}

}  // namespace

TEST_CASE("(47) locked DoFs: the others accelerate as in the oracle, and the lock transmits the rest") {
  int locks = 0, partial = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 31);
    const Model model = random_tree(seed, {.max_bodies = 25}).model;
    Machine m(model);
    const System system = system_of(model);
    for (int b = 0; b < m.size(); ++b) {
      const int nv = info(m.tree.joint(b).kind).nv;
      if (nv == 0 || random.chance(0.5)) continue;
      const unsigned dofs = some_dofs(random, nv);
      m.evaluate();
      apply(Lock{m.tree.inboard_joint({b}), dofs}, m.tree, m.state, m.workspace);
      ++locks;
      partial += dofs != (1u << nv) - 1;
    }
    check(measure_accelerations(system, m.tree, m.state, m.workspace, spectrum(mass_matrix(system, start_q(model)))));
  }
  CHECK(locks > 1000);
  CHECK(partial > 300);
}

TEST_CASE("after any changes every body's equations of motion hold, and a joint does the work of its drive only") {
  double residual = 0, work = 0;
  int reversed = 0, made = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    Prng random(seed * 13 + 7);
    RandomTreeOptions options;
    options.max_bodies = 15;
    options.all_free = seed % 2 == 0;
    Machine m(random_tree(seed, options).model);
    const System system = system_of(m.model);
    for (int action = 0; action < 8; ++action) {
      const int b = random.integer(0, m.size() - 1);
      const int what = random.integer(0, 5);
      CAPTURE(action);
      m.evaluate();
      switch (what) {
        case 0:
          if (can_break(m.tree, m.tree.inboard_joint({b}))) apply(Break{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace);
          break;
        case 1: {
          const int nv = info(m.tree.joint(b).kind).nv;
          if (nv > 0) apply(Lock{m.tree.inboard_joint({b}), some_dofs(random, nv)}, m.tree, m.state, m.workspace);
          break;
        }
        case 2: apply(random_change(random, m, b), m.tree, m.state, m.workspace); break;
        case 3: {
          const int to = random.integer(0, m.size() - 1);
          if (root_of(m.tree, {to}).index != root_of(m.tree, {b}).index && floats(m.tree, {b}))
            apply(Join{{b}, {to}}, m.tree, m.state, m.workspace);
          break;
        }
        default:
          if (floats(m.tree, {b})) apply(Reroot{{b}}, m.tree, m.state, m.workspace);
      }
      const double off = equations_of_motion(system, m.tree, m.state, m.workspace);
      const double loose = work_of_reactions(m.tree, m.state, m.workspace);
      CHECK(off < 1e-10);
      CHECK(loose < 1e-12);
      residual = std::max(residual, off), work = std::max(work, loose);
      for (int k = 0; k < m.size(); ++k) reversed += m.tree.reversed(k), made += is_detached(m.tree, k);
    }
  }
  MESSAGE("largest residual of Newton and Euler ", residual, ", of E^T Tr ", work, "; ", reversed, " reversed joints, ", made,
          " roots that changes made");
  CHECK(reversed > 500);
}
