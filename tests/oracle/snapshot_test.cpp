// Restoring: topology, coordinates and momenta, and everything computed from them, to the last bit.
#include <cstring>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/topology/snapshot.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/oracle/machine.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

// A step along the rates, so that restored states continue to move.
void advance(Machine& m) {
  const State::Edit edit = m.state.edit();
  edit.time += 1e-3;
  for (std::size_t i = 0; i < edit.q.size(); ++i) edit.q[i] += 1e-3 * m.workspace.qdot[i];
  for (std::size_t i = 0; i < edit.p.size(); ++i) edit.p[i] += 1e-3 * m.workspace.pdot[i];
  for (int b : m.tree.joints_with().quaternions) {
    const KindInfo& kind = info(m.tree.joint(b).kind);
    double* w = edit.q.data() + m.tree.first_q(b) + kind.nq - 4;
    const double n = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
    for (int i = 0; i < 4; ++i) w[i] /= n;
  }
}
void step(Machine& m) {
  advance(m);
  m.evaluate();
}

// All results of an evaluation.
struct Found {
  std::vector<double> values;
  explicit Found(const Machine& m) {
    const auto add = [this](const double* first, std::size_t count) { values.insert(values.end(), first, first + count); };
    values.push_back(m.state.time());
    add(m.state.q().data(), m.state.q().size());
    add(m.state.p().data(), m.state.p().size());
    add(m.workspace.qdot.get(), m.state.q().size());
    add(m.workspace.pdot.get(), m.state.p().size());
    add(m.workspace.v.get(), m.state.p().size());
    for (int b : m.tree.order()) {
      const Kinematics<double>& k = m.workspace.bodies[static_cast<std::size_t>(b)];
      add(&k.R.xx, 9);
      add(&k.r.x, 3);
      add(&m.tree.frame(b).R.xx, 9);
      add(&m.tree.frame(b).r.x, 3);
      const auto& link = m.tree.link(b);
      for (double x : {link.cos_a, link.sin_a, link.cos_b, link.sin_b, link.cos_0, link.sin_0, link.r.x, link.r.y, link.r.z,
                       link.body.m, link.body.mc.x, link.body.J.xy, m.tree.subtree_mass(b), link.angle_0})
        values.push_back(x);
    }
  }
  bool operator==(const Found& other) const {
    return values.size() == other.values.size() &&
           std::memcmp(values.data(), other.values.data(), values.size() * sizeof(double)) == 0;
  }
};

RandomTreeOptions options(std::uint64_t seed) {
  RandomTreeOptions o;
  o.max_bodies = 12;
  o.all_free = seed % 2 == 0;
  return o;
}

}  // namespace

TEST_CASE("a restored world continues bit for bit: in the same tree, and in a newly built one") {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    INFO("seed ", seed);
    Machine m(random_tree(seed, options(seed)).model);
    const Model compiled = m.model;
    Prng random(seed * 5 + 3);
    for (int k = random.integer(0, 15); k > 0; --k) act(random, m), step(m);
    const Snapshot start = take_snapshot(m.tree, m.state);
    const Model then = m.model;  // its names: bodies added later are added again
    const Prng draws = random;
    std::vector<Found> first;
    for (int k = 0; k < 12; ++k) {
      act(random, m);
      step(m);
      first.emplace_back(m);
    }
    const std::uint64_t revision = m.tree.revision();
    const Stamp stamp = m.state.stamp();

    restore(start, m.tree, m.state);
    m.model = then;
    CHECK(m.tree.revision() != revision);
    CHECK(m.workspace.evaluated == stamp);
    CHECK_FALSE(m.workspace.evaluated == m.state.stamp());
    Machine anew(compiled);
    restore(start, anew.tree, anew.state);
    anew.model = then, anew.workspace = Workspace<double>(anew.tree);
    for (Machine* again : {&m, &anew}) {
      again->evaluate();
      Prng same = draws;
      for (const Found& found : first) {
        act(same, *again);
        step(*again);
        CHECK(Found(*again) == found);
      }
    }
  }
}

TEST_CASE("restoring the start gives the compiled world, without changes") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Machine m(random_tree(seed, options(seed)).model);
    const Found begin(m);
    const Snapshot start = take_snapshot(m.tree, m.state);
    CHECK(start.topology.changed.empty());
    CHECK(start.topology.own.empty());
    Prng random(seed + 99);
    for (int k = 0; k < 20; ++k) act(random, m);
    const Topology there = m.tree.topology();
    restore(start, m.tree, m.state);
    m.evaluate();
    CHECK(Found(m) == begin);
    CHECK(m.tree.topology().changed.empty());
    CHECK(m.size() == static_cast<int>(start.topology.places.size()));
    m.tree.edit().restore(there);
    CHECK(m.tree.topology().changed.size() == there.changed.size());
    CHECK(m.tree.topology().own.size() == there.own.size());
  }
}
