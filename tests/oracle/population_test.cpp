// Bodies that are removed and added while the world moves.
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/integrate/integrator.hpp>
#include <tests/oracle/machine.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

void run(Machine& m, int steps) {
  const auto method = make_integrator("rk4", m.tree);
  Evaluator evaluate(m.tree, m.workspace);
  EnergyLedger ledger;
  for (int k = 0; k < steps; ++k) {
    evaluate(m.state);
    REQUIRE(method->step(evaluate, m.state, ledger, 1e-3));
  }
  m.evaluate();
}

void break_some(Prng& random, Machine& m) {
  const int cut = m.some_body(random);
  if (can_break(m.tree, m.tree.inboard_joint({cut}))) apply(Break{m.tree.inboard_joint({cut})}, m.tree, m.state, m.workspace);
  m.evaluate();
}

// Largest difference of velocities between the bodies that both have.
double difference(const Machine& a, const Column& V, const Machine& b, const Column& W) {
  double worst = 0;
  for (int k = 0; k < std::min(a.size(), b.size()); ++k)
    if (a.tree.alive(k) && b.tree.alive(k))
      worst = std::max(worst, static_cast<double>((V.segment(6 * k, 6) - W.segment(6 * k, 6)).cwiseAbs().maxCoeff() /
                                                  std::max<long double>(1, V.cwiseAbs().maxCoeff())));
  return worst;
}

}  // namespace

TEST_CASE("after a removal the other bodies move as if the removed part still existed") {
  int removed = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    Prng random(seed + 600);
    RandomTreeOptions options;
    options.max_bodies = 12;
    Machine m(random_tree(seed, options).model);
    break_some(random, m);
    break_some(random, m);
    const int root = root_of(m.tree, {m.some_body(random)}).index;
    if (!is_detached(m.tree, root) || m.part(root) == static_cast<int>(m.tree.order().size())) continue;
    ++removed;
    INFO("seed ", seed, " root ", root);
    Machine with(m.model);
    with.tree = m.tree, with.state = m.state;
    const int living = static_cast<int>(m.tree.order().size()), leaving = m.part(root);
    apply(Remove{{root}}, m.tree, m.state, m.workspace);
    CHECK_FALSE(m.tree.alive(root));
    CHECK(with.tree.alive(root));
    CHECK(static_cast<int>(m.tree.order().size()) == living - leaving);
    CHECK(static_cast<int>(m.state.q().size()) == m.tree.nq());
    CHECK(static_cast<int>(m.state.p().size()) == m.tree.nv());
    run(m, 20);
    run(with, 20);
    CHECK(difference(m, m.velocities(), with, with.velocities()) < 1e-13);
  }
  CHECK(removed > 40);
}

TEST_CASE("adding a body changes no velocity and no energy but its own") {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Prng random(seed + 800);
    RandomTreeOptions options;
    options.max_bodies = 10;
    options.gravity = false;
    Machine m(random_tree(seed, options).model);
    for (int k = 0; k < 4; ++k) {
      break_some(random, m);
      INFO("seed ", seed, " body ", k);
      Machine before(m.model);
      before.tree = m.tree, before.state = m.state;
      before.evaluate();
      const bool at_rest = random.chance(0.5);
      const int b = m.add(random, true, at_rest);
      m.evaluate();
      CHECK(m.size() == before.size() + 1);
      const Column V = m.velocities();
      const double bound = std::max(1e-10, 10 * 2.2e-16 * condition(m.masses(), m.constraints()));
      CHECK(difference(before, before.velocities(), m, V) < bound);
      const auto start = [&](int i) { return m.model[{b}].v.empty() ? 0.0 : m.model[{b}].v[i]; };
      for (int i = 0; i < info(m.tree.joint(b).kind).nv; ++i)
        CHECK(std::fabs(m.workspace.v[static_cast<std::size_t>(m.tree.first_p(b) + i)] - start(i)) < 10 * bound);
      // Kinetic energy of the added bodies and armatures.
      const Totals was = totals(before.tree, before.state, before.workspace), now = totals(m.tree, m.state, m.workspace);
      double brought =
          static_cast<double>(V.segment(6 * b, 6).dot(m.masses().block(6 * b, 6 * b, 6, 6) * V.segment(6 * b, 6))) / 2;
      for (int i = 0; i < info(m.tree.joint(b).kind).nv; ++i)
        brought += 0.5 * m.tree.tables().armature[m.tree.first_p(b) + i] * start(i) * start(i);
      CHECK(std::fabs(now.kinetic - was.kinetic - brought) < 1e-11 * (1 + was.kinetic + brought));
      if (at_rest && m.tree.parent(b) < 0) CHECK(brought < 1e-20);
    }
  }
}

TEST_CASE("bodies added, removed, broken off and joined: the projection agrees throughout") {
  int added = 0, removed = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Prng random(seed + 1200);
    RandomTreeOptions options;
    options.max_bodies = 8, options.parameters = false;
    Machine m(random_tree(seed, options).model);
    for (int k = 0; k < 30; ++k) {
      INFO("seed ", seed, " action ", k);
      const int b = m.some_body(random);
      const int living = static_cast<int>(m.tree.order().size());
      switch (random.integer(0, 4)) {
        case 0: break_some(random, m); break;
        case 1:
          if (living > 8) break;
          m.add(random, false, false);
          ++added;
          break;
        case 2: {
          if (m.tree.parent(b) >= 0 || !is_detached(m.tree, b) || living - m.part(b) < 3) break;
          Machine before(m.model);
          before.tree = m.tree, before.state = m.state, before.workspace = Workspace<double>(m.tree);
          before.evaluate();
          apply(Remove{{b}}, m.tree, m.state, m.workspace);
          m.evaluate();
          CHECK(difference(before, before.velocities(), m, m.velocities()) < 1e-13);
          ++removed;
          break;
        }
        default: {
          const int to = m.some_body(random);
          if (!floats(m.tree, {b}) || root_of(m.tree, {b}).index == root_of(m.tree, {to}).index) break;
          const Outcome o = compare(m, [&] { apply(random_attach(random, m, b, to), m.tree, m.state, m.workspace); });
          CHECK(o.difference < o.bound);
          CHECK(o.gain < 1e-10L);
          CHECK(o.carnot < 1e-10L);
        }
      }
      m.evaluate();
    }
  }
  CHECK(added > 100);
  CHECK(removed > 40);
}

TEST_CASE("ten thousand bodies are added and removed: the storage does not grow") {
  RandomTreeOptions options;
  options.min_bodies = 6, options.max_bodies = 6;
  Machine m(random_tree(3, options).model);
  BodySpec spec;
  spec.name = "shot", spec.mass = 1, spec.inertia = diagonal(0.1);
  spec.joint = Free{};
  Model shots;
  const BodySpec shot = shots[shots.add(spec)];
  const int nq = m.tree.nq(), nv = m.tree.nv(), bodies = m.size();
  const Totals start = totals(m.tree, m.state, m.workspace);
  const double* storage = nullptr;
  for (int k = 0; k < 10000; ++k) {
    forward_dynamics(m.tree, m.state, m.workspace);
    const BodyId body = apply(Add{&shot}, m.tree, m.state, m.workspace);
    CHECK(body.index == bodies + k);
    if (k == 0) storage = m.state.q().data();
    m.workspace = Workspace<double>(m.tree);
    apply(Remove{body}, m.tree, m.state, m.workspace);
  }
  CHECK(m.state.q().data() == storage);
  CHECK(m.tree.nq() == nq);
  CHECK(m.tree.nv() == nv);
  CHECK(static_cast<int>(m.tree.order().size()) == bodies);
  m.evaluate();
  CHECK(totals(m.tree, m.state, m.workspace).kinetic == doctest::Approx(start.kinetic).epsilon(1e-13));
}
