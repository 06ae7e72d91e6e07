// Impacts with restitution on one DoF, against the projection in maximal coordinates.
#include <cmath>

#include <doctest/doctest.h>

#include <tests/oracle/machine.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

struct Stop {
  int body = -1, dof = 0;
};
Stop some_stop(Prng& random, const Machine& m) {
  Stop stop;
  for (int tries = 0; tries < 30; ++tries) {
    const int b = m.some_body(random);
    const int nv = info(m.tree.joint(b).kind).nv;
    if (nv > 0) return {b, random.integer(0, nv - 1)};
  }
  return stop;
}

double rate(const Machine& m, const Stop& stop) {
  return m.workspace.v[static_cast<std::size_t>(m.tree.first_p(stop.body) + stop.dof)];
}

Machine copy(const Machine& m) {
  Machine other(m.model);
  other.tree = m.tree, other.state = m.state;
  other.evaluate();
  return other;
}

double kinetic(Machine& m) { return totals(m.tree, m.state, m.workspace).kinetic; }

}  // namespace

TEST_CASE("an impact is the projection, overshot by the restitution; of all kinds, either way round") {
  int impacts = 0, kinds[16] = {};
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Prng random(seed + 7000);
    RandomTreeOptions options;
    options.max_bodies = 10, options.parameters = false, options.all_free = seed % 2 == 0;
    Machine m(random_tree(seed, options).model);
    const int root = m.some_body(random);
    if (floats(m.tree, {root})) apply(Reroot{{root}}, m.tree, m.state, m.workspace);
    m.evaluate();
    const Stop stop = some_stop(random, m);
    if (stop.body < 0) continue;
    ++impacts, ++kinds[static_cast<std::size_t>(m.tree.joint(stop.body).kind)];
    INFO("seed ", seed, " body ", stop.body, " freedom ", stop.dof);
    const double e = seed % 5 == 0 ? 0.0 : random.uniform(0, 1);
    Machine locked = copy(m);
    apply(Lock{locked.tree.inboard_joint({stop.body}), 1u << stop.dof}, locked.tree, locked.state, locked.workspace);
    locked.evaluate();

    const Column before = m.velocities();
    const Dense M = m.masses(), C = locked.constraints();
    const Column plastic = projected(M, C, before), expected = before + (1 + static_cast<long double>(e)) * (plastic - before);
    const double u = rate(m, stop);
    const std::uint64_t revision = m.tree.revision();
    const double p = m.state.p()[static_cast<std::size_t>(m.tree.first_p(stop.body) + stop.dof)];
    const double impulse = apply(Impact{m.tree.inboard_joint({stop.body}), stop.dof, e}, m.tree, m.state, m.workspace);
    CHECK(m.workspace.evaluated != m.state.stamp());
    CHECK(m.tree.revision() == revision);
    CHECK(impulse * u <= 0);
    CHECK(m.state.p()[static_cast<std::size_t>(m.tree.first_p(stop.body) + stop.dof)] == p + impulse);
    m.evaluate();
    const double bound = std::max(1e-10, 10 * 2.2e-16 * condition(M, m.constraints()));
    const long double scale = std::max<long double>(1, before.cwiseAbs().maxCoeff());
    CHECK((m.velocities() - expected).cwiseAbs().maxCoeff() / scale < bound);
    CHECK(std::fabs(rate(m, stop) + e * u) < bound * std::max(1.0, std::fabs(u)));
    const long double loss = energy(M, before) - energy(M, m.velocities()), most = energy(M, before) - energy(M, plastic);
    CHECK(std::fabs(loss - (1 - e * e) * most) < 1e-10L * (1 + energy(M, before)));
    // A plastic impact yields the same velocities as a lock.
    if (e == 0) CHECK((m.velocities() - locked.velocities()).cwiseAbs().maxCoeff() / scale < bound);
  }
  CHECK(impacts > 300);
  for (const KindInfo& kind : all_kinds())
    if (kind.nv > 0) CHECK(kinds[static_cast<std::size_t>(kind.kind)] > 0);
}

TEST_CASE("with rotors, springs and locked neighbours: restitution, and its share of the energy") {
  int impacts = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Prng random(seed + 7700);
    RandomTreeOptions options;
    options.max_bodies = 12;
    Machine m(random_tree(seed, options).model);
    const int b = m.some_body(random);
    if (info(m.tree.joint(b).kind).nv > 0) apply(Lock{m.tree.inboard_joint({b}), 1}, m.tree, m.state, m.workspace);
    m.evaluate();
    const Stop stop = some_stop(random, m);
    if (stop.body < 0 || (m.tree.joint(stop.body).locked >> stop.dof & 1u) != 0) continue;
    ++impacts;
    INFO("seed ", seed, " body ", stop.body, " freedom ", stop.dof);
    const double e = random.uniform(0, 1), u = rate(m, stop), before = kinetic(m);
    Machine plastic = copy(m);
    const double bound = std::max(1e-10, 10 * 2.2e-16 * condition(m.masses(), m.constraints()));
    apply(Impact{plastic.tree.inboard_joint({stop.body}), stop.dof, 0}, plastic.tree, plastic.state, plastic.workspace);
    apply(Impact{m.tree.inboard_joint({stop.body}), stop.dof, e}, m.tree, m.state, m.workspace);
    m.evaluate(), plastic.evaluate();
    CHECK(std::fabs(rate(m, stop) + e * u) < bound * std::max(1.0, std::fabs(u)));
    CHECK(std::fabs(rate(plastic, stop)) < bound * std::max(1.0, std::fabs(u)));
    const double most = before - kinetic(plastic);
    CHECK(most >= -1e-12 * before);
    CHECK(std::fabs(before - kinetic(m) - (1 - e * e) * most) < 1e-11 * (1 + before));
  }
  CHECK(impacts > 150);
}
