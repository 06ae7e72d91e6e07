// Joint forces and prescribed motions of random trees, checked against the oracle.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/forces/motion.hpp>
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

// The model with prescribed motions for about half of its joints with one DoF.
Model with_motions(const Model& model, Prng& random, int& motions) {
  Model out({.gravity = model.gravity()});
  for (BodySpec body : model.bodies()) {
    JointParameters& p = body.joint.parameters;
    if (info(body.joint.kind).nv == 1 && random.chance(0.5)) {
      p.effort = {}, p.limits = {};
      const double amplitude = random.uniform(0.1, 1), frequency = random.uniform(0.1, 1), phase = random.uniform(-3, 3);
      p.drive = motion_drive(Signal::sine(amplitude, frequency, phase, random.uniform(-1, 1)));
      ++motions;
    }
    out.add_unjudged(body);
  }
  return out;
}

double narrow(Real x) { return static_cast<double>(x); }

// Velocities, ṗ and u̇ of a tree with prescribed motions: the oracle is given the rates of the driven DoFs.
void check_motions(const System& at_rest, Machine& m) {
  System system = at_rest;
  system.time = m.state.time();
  m.evaluate();
  const int nv = m.tree.nv();
  const std::vector<double> q(m.state.q().begin(), m.state.q().end());
  const MassMatrix mass = mass_matrix(system, q);
  MassMatrix free = mass;
  std::vector<Real> p(m.state.p().begin(), m.state.p().end());
  std::vector<char> driven(static_cast<std::size_t>(nv), 0);
  std::vector<Real> expected_rates(static_cast<std::size_t>(nv), 0);
  for (const int b : m.tree.joints_with().motions) {
    const int i = m.tree.first_p(b);
    const oracle::Curve s = signal_at(m.tree.parameters(b)->drive->motion[0].signal(), system.time);
    driven[static_cast<std::size_t>(i)] = 1;
    CHECK(std::fabs(narrow(q[static_cast<std::size_t>(m.tree.first_q(b))] - s.r)) <= 1e-15 * (1 + std::fabs(narrow(s.r))));
    p[static_cast<std::size_t>(i)] = s.t, expected_rates[static_cast<std::size_t>(i)] = s.tt;
  }
  for (int i = 0; i < nv; ++i) {
    if (!driven[static_cast<std::size_t>(i)]) continue;
    for (int j = 0; j < nv; ++j) {
      if (!driven[static_cast<std::size_t>(j)]) p[static_cast<std::size_t>(j)] -= mass(i, j) * p[static_cast<std::size_t>(i)];
      free(i, j) = free(j, i) = i == j ? 1 : 0;
    }
  }
  const double condition = spectrum(mass).condition();
  const std::vector<Real> v = solve(free, p), is(m.workspace.v.get(), m.workspace.v.get() + nv);
  CHECK(narrow(oracle::distance(v, is)) <= std::max(1e-13, 1e-15 * condition) * narrow(oracle::norm(v)));
  Evaluation e = evaluate(system, q, v);
  for (int i = 0; i < nv; ++i)
    if (driven[static_cast<std::size_t>(i)]) e.pdot[static_cast<std::size_t>(i)] = expected_rates[static_cast<std::size_t>(i)];
  const std::vector<Real> rates(m.workspace.pdot.get(), m.workspace.pdot.get() + nv);
  CHECK(narrow(oracle::distance(rates, e.pdot)) <= std::max(1e-9, 1e-15 * condition) * narrow(oracle::norm(e.pdot)));
  check(measure_accelerations(system, m.tree, m.state, m.workspace, spectrum(mass)));
}

}  // namespace

TEST_CASE("friction, soft stops, efforts and position control: forces and accelerations equal the oracle's") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    const Model model = random_tree(seed, {.max_bodies = 30, .drives = true}).model;
    Machine m(model);
    System system = system_of(model);
    system.time = m.state.edit().time = Prng(seed).uniform(0, 1);
    m.evaluate();
    const StateMeasures measures = measure_state(system, m.tree, m.state, m.workspace);
    check(measures.laws);
    check(measure_accelerations(system, m.tree, m.state, m.workspace, measures.range));
  }
}

TEST_CASE("prescribed motions: velocities, momenta's rates, accelerations, wrenches with the driven coordinates eliminated") {
  int motions = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    Prng random(seed + 5);
    const Model model = with_motions(random_tree(seed, {.max_bodies = 30, .drives = seed % 2 == 0}).model, random, motions);
    Machine m(model);
    check_motions(system_of(model), m);
    // At another instant, with the same momenta.
    {
      const State::Edit edit = m.state.edit();
      edit.time = random.uniform(0, 1);
      follow_motions(m.tree, edit.time, edit.q.data(), edit.p.data());
    }
    check_motions(system_of(model), m);
  }
  CHECK(motions > 500);
}

TEST_CASE(
    "after any changes near driven joints every body's equations of motion hold, and lossless changes keep all velocities") {
  int reversed = 0, driven = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    Prng random(seed * 17 + 3);
    int motions = 0;
    const Model model = with_motions(random_tree(seed, {.max_bodies = 15, .all_free = seed % 2 == 0}).model, random, motions);
    Machine m(model);
    const System system = system_of(model);
    for (int action = 0; action < 8; ++action) {
      const int b = random.integer(0, m.size() - 1), what = random.integer(0, 4);
      CAPTURE(action);
      CAPTURE(what);
      m.evaluate();
      const Totals before = totals(m.tree, m.state, m.workspace);
      bool steady = true, floating = true;
      for (int k = 0; k < m.size(); ++k) floating = floating && floats(m.tree, {k});
      std::vector<Vec3> spins;
      for (int k = 0; k < m.size(); ++k) {
        const Kinematics<double>& body = m.workspace.bodies[static_cast<std::size_t>(k)];
        spins.push_back(body.R * body.velocity.w);
      }
      switch (what) {
        case 0:
          if (can_break(m.tree, m.tree.inboard_joint({b}))) apply(Break{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace);
          break;
        case 1:
          steady = false;
          if (info(m.tree.joint(b).kind).nv > 0) apply(Lock{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace);
          break;
        case 2: {
          const int to = random.integer(0, m.size() - 1);
          if (root_of(m.tree, {to}).index != root_of(m.tree, {b}).index && floats(m.tree, {b}))
            apply(Join{{b}, {to}}, m.tree, m.state, m.workspace);
          break;
        }
        case 3:  // the motion is removed
          if (m.tree.link(b).driven != 0) apply(SetParameters{m.tree.inboard_joint({b}), {}}, m.tree, m.state, m.workspace);
          break;
        default:
          if (floats(m.tree, {b})) apply(Reroot{{b}}, m.tree, m.state, m.workspace);
      }
      CHECK(equations_of_motion(system, m.tree, m.state, m.workspace) < 1e-10);
      CHECK(work_of_reactions(m.tree, m.state, m.workspace) < 1e-12);
      const Totals after = totals(m.tree, m.state, m.workspace);
      double fast = 1;
      for (const Vec3& w : spins) fast = std::max(fast, momentree::norm(w));
      for (int k = 0; k < m.size() && steady; ++k) {
        const Kinematics<double>& body = m.workspace.bodies[static_cast<std::size_t>(k)];
        CHECK(momentree::norm(body.R * body.velocity.w - spins[static_cast<std::size_t>(k)]) <= 1e-9 * fast);
      }
      for (int k = 0; k < m.size(); ++k) floating = floating && floats(m.tree, {k});  // a root may have been locked
      if (floating) CHECK(momentree::norm(after.linear - before.linear) <= 1e-9 * (1 + momentree::norm(before.linear)));
      for (int k = 0; k < m.size(); ++k) {
        if (m.tree.link(k).driven == 0) continue;
        ++driven, reversed += m.tree.reversed(k);
        const double rate = prescribed_motion(m.tree, k).at(m.state.time()).rate;
        CHECK(m.workspace.v[static_cast<std::size_t>(m.tree.first_p(k))] == rate);
      }
    }
  }
  CHECK(driven > 1000);
  CHECK(reversed > 50);
}
