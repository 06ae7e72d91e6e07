// Complete breaks in random trees: the resulting momenta, continuity and conservation; one break at a time and in quick
// succession.
#include <algorithm>
#include <map>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/topology/change.hpp>
#include <tests/oracle/laws.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

constexpr double round_off = 0x1p-53;

Real size(const Vec3& a) {
  return std::sqrt(static_cast<Real>(a.x) * a.x + static_cast<Real>(a.y) * a.y + static_cast<Real>(a.z) * a.z);
}
Real size(const V3<Real>& a) { return std::sqrt(dot(a, a)); }
std::vector<Real> wide(std::span<const double> a) { return {a.begin(), a.end()}; }

/// A tree, its state, and the oracle's view of both.
struct Scene {
  System system;
  Tree tree;
  State state;
  Workspace<double> workspace;
  Scene(const Model& model) : system(system_of(model)), tree(model), state(start_state(model, tree)), workspace(tree) {}

  std::vector<double> q() const { return {state.q().begin(), state.q().end()}; }
  std::vector<Real> v() { return evaluated(), wide({workspace.v.get(), static_cast<std::size_t>(tree.nv())}); }
  void evaluated() { forward_dynamics(tree, state, workspace); }
  Evaluation oracle() { return evaluated(), evaluate(system, q(), v(), false); }
  Released break_joint(int body) {
    evaluated();
    const Released released = apply(Break{tree.inboard_joint({body})}, tree, state, workspace);
    system = broken(system, body);
    return released;
  }
};

/// Scale of conservation errors: energies and momenta of all bodies, without their signs.
struct Scale {
  Real energy = 0, linear = 0, angular = 0, reach = 1, speed = 0, spin = 0;
  Scale(const System& system, const Evaluation& e) {
    energy = e.kinetic + std::fabs(e.potential);
    Real mass = 0;
    for (std::size_t k = 0; k < e.motions.size(); ++k) {
      const auto& m = e.motions[k];
      reach = std::max(reach, size(m.com));
      speed = std::max({speed, size(m.velocity), size(m.com_velocity)});
      spin = std::max(spin, size(m.angular));
      mass += system.links[k].mass;
      energy += system.links[k].mass * size(system.gravity) * size(m.com);
    }
    linear = mass * (speed + spin);
    angular = linear * reach;
  }
};

/// The worst value of each figure over many breaks, for the log; the largest ratio decides.
struct Record {
  std::map<std::string, oracle::Measure> worst;
  int count = 0;
  void enter(const oracle::Measure& m) {
    const auto [it, first] = worst.try_emplace(m.law, m);
    if (!first && (m.ratio() > it->second.ratio() || !m.holds())) it->second = m;
    ++count;
    INFO(std::string(m.law) << ": " << m.error << " > " << m.bound);
    CHECK(m.holds());
  }
  void enter(const char* law, Real error, Real bound) {
    enter(oracle::Measure{law, static_cast<double>(error), static_cast<double>(bound)});
  }
  ~Record() {
    for (const auto& [law, m] : worst) MESSAGE(std::string(law) << ": worst " << m.error << " of " << m.bound);
  }
};

bool is_ancestor(const System& system, int ancestor, int body) {
  for (int b = system.links[static_cast<std::size_t>(body)].parent; b >= 0; b = system.links[static_cast<std::size_t>(b)].parent)
    if (b == ancestor) return true;
  return false;
}

/// Velocities after the break of `body`: those of the other bodies are unchanged, the new root's are in its own axes.
std::vector<Real> velocities_after(const System& before, const System& after, const std::vector<Real>& v, const Evaluation& e,
                                   int body) {
  std::vector<Real> out;
  for (int k = 0; k < static_cast<int>(before.links.size()); ++k) {
    if (k == body) {
      const auto& m = e.motions[static_cast<std::size_t>(k)];
      for (const V3<Real>& a : {transposed(m.frame.rotation) * m.velocity, transposed(m.frame.rotation) * m.angular})
        out.insert(out.end(), a.begin(), a.end());
    } else {
      out.insert(out.end(), v.begin() + before.first_v[static_cast<std::size_t>(k)],
                 v.begin() + before.first_v[static_cast<std::size_t>(k) + 1]);
    }
  }
  REQUIRE(static_cast<int>(out.size()) == after.nv());
  return out;
}

/// √M_aa Σ_b √M_bb |v_b| per DoF a: a bound for the terms of p_a = Σ_b M_ab v_b, whatever the axes.
std::vector<Real> sizes_of_terms(const MassMatrix& mass, const std::vector<Real>& v) {
  Real all = 0;
  for (int b = 0; b < mass.size(); ++b) all += std::sqrt(mass(b, b)) * std::fabs(v[static_cast<std::size_t>(b)]);
  std::vector<Real> sizes;
  for (int a = 0; a < mass.size(); ++a) sizes.push_back(std::sqrt(mass(a, a)) * all);
  return sizes;
}

/// Breaks the inboard joint of `body`; returns the energy that was removed with it.
double check_break(Scene& scene, int body, Record& record) {
  const System before = scene.system;
  const std::vector<double> q = scene.q(), p(scene.state.p().begin(), scene.state.p().end());
  const std::vector<Real> v = scene.v();
  const Evaluation e = scene.oracle();
  const Totals sum = totals(scene.tree, scene.state, scene.workspace);
  const std::vector<Real> heavy = sizes_of_terms(mass_matrix(before, q), v);

  const Released released = scene.break_joint(body);
  const System& after = scene.system;
  REQUIRE(scene.tree.bodies() == static_cast<int>(before.links.size()));
  REQUIRE(scene.tree.nq() == after.nq());
  REQUIRE(scene.tree.nv() == after.nv());
  const std::vector<double> q_after = scene.q();
  const std::vector<Real> v_after = velocities_after(before, after, v, e, body), p_after = wide(scene.state.p());
  const MassMatrix mass = mass_matrix(after, q_after);
  const std::vector<Real> p_oracle = mass.times(v_after);
  const std::vector<Real> sizes = sizes_of_terms(mass, v_after);
  Real worst = 0;
  for (int k = 0; k < scene.tree.bodies(); ++k) {
    const std::size_t i = static_cast<std::size_t>(k);
    REQUIRE(scene.tree.parent(k) == after.links[i].parent);
    REQUIRE(scene.tree.first_q(k) == after.first_q[i]);
    REQUIRE(scene.tree.first_p(k) == after.first_v[i]);
    const int nv = after.first_v[i + 1] - after.first_v[i];
    for (int c = 0; c < nv; ++c) {
      const std::size_t a = static_cast<std::size_t>(after.first_v[i] + c);
      Real scale = sizes[a];
      if (k != body) scale += heavy[static_cast<std::size_t>(before.first_v[i] + c)];
      const Real error = std::fabs(p_after[a] - p_oracle[a]);
      if (!(error <= worst * scale)) worst = error / scale;
      if (k != body && !is_ancestor(before, k, body)) CHECK(p_after[a] == p[static_cast<std::size_t>(before.first_v[i] + c)]);
    }
    for (int c = 0; c < after.first_q[i + 1] - after.first_q[i] && k != body; ++c)
      CHECK(q_after[static_cast<std::size_t>(after.first_q[i] + c)] == q[static_cast<std::size_t>(before.first_q[i] + c)]);
  }
  const Spectrum masses = spectrum(mass);
  const double condition = masses.condition();
  record.enter("p of the oracle, of its terms", worst, 1e-14L);

  const Evaluation now = scene.oracle();
  const Scale scale(before, e);
  Real place = 0, linear = 0, angular = 0;
  for (std::size_t k = 0; k < e.motions.size(); ++k) {
    place = std::max(place, size(now.motions[k].frame.position - e.motions[k].frame.position));
    linear = std::max(linear, size(now.motions[k].velocity - e.motions[k].velocity));
    angular = std::max(angular, size(now.motions[k].angular - e.motions[k].angular));
  }
  const Real unsure = std::max(1e-12L, 10 * static_cast<Real>(round_off * condition));
  record.enter("body positions are continuous", place, 1e-13L * scale.reach);
  record.enter("body velocities are continuous", linear, unsure * (scale.speed + scale.spin * scale.reach));
  record.enter("body angular velocities are continuous", angular, unsure * scale.spin);

  const Totals then = totals(scene.tree, scene.state, scene.workspace);
  const Real kept = then.kinetic + then.potential + released.energy;
  // Velocities are accurate to the residual of M v = p, 1e-13 ‖M‖ ‖v‖, and so is the energy.
  Real squares = 0;
  for (const Real u : v_after) squares += u * u;
  const Real loose = 1e-13L * static_cast<Real>(masses.largest) * squares;
  record.enter("energy", std::fabs(kept - sum.kinetic - sum.potential), std::max(1e-12L * scale.energy, loose));
  record.enter("released energy",
               std::fabs(released.energy - (e.kinetic + e.potential - evaluate(after, q_after, v_after, false).kinetic -
                                            potential(after, q_after))),
               1e-13L * scale.energy);
  record.enter("linear momentum", size(then.linear - sum.linear), 1e-12L * scale.linear);
  record.enter("angular momentum", size(then.angular - sum.angular), 1e-12L * scale.angular);
  return released.energy;
}

std::vector<int> breakable(const Scene& scene) {
  std::vector<int> bodies;
  for (int b = 0; b < scene.tree.bodies(); ++b)
    if (can_break(scene.tree, scene.tree.inboard_joint({b}))) bodies.push_back(b);
  return bodies;
}

}  // namespace

TEST_CASE("a break in a random tree, at states drawn by velocities and by momenta") {
  Record record;
  int breaks = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    const RandomTree random = random_tree(seed, {.max_bodies = 40});
    Prng draw(seed + 5000);
    for (const bool by_momenta : {false, true}) {
      CAPTURE(by_momenta);
      Scene scene(random.model);
      if (by_momenta)
        for (double& p : scene.state.edit().p) p = draw.uniform(-1, 1);
      const std::vector<int> bodies = breakable(scene);
      if (bodies.empty()) continue;
      check_break(scene, bodies[static_cast<std::size_t>(draw.integer(0, static_cast<int>(bodies.size()) - 1))], record);
      const StateMeasures laws = measure_state(scene.system, scene.tree, scene.state, scene.workspace);
      for (const oracle::Measure& m : laws.laws) {
        INFO(std::string(m.law) << ": " << m.error << " > " << m.bound);
        CHECK(m.holds());
      }
      ++breaks;
    }
  }
  CHECK(breaks > 550);
}

TEST_CASE("every joint breaks, in a random order: nothing is lost until all bodies are free") {
  Record record;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const RandomTree random = random_tree(seed, {.max_bodies = 30});
    Scene scene(random.model);
    Prng draw(seed + 9000);
    const Evaluation e = scene.oracle();
    const Scale scale(scene.system, e);
    const Totals start = totals(scene.tree, scene.state, scene.workspace);
    Real released = 0;
    std::vector<int> left = breakable(scene);
    const int joints = static_cast<int>(left.size());
    for (int count = 1; !left.empty(); ++count) {
      const int pick = draw.integer(0, static_cast<int>(left.size()) - 1);
      const int body = left[static_cast<std::size_t>(pick)];
      released += count <= 3 ? check_break(scene, body, record) : scene.break_joint(body).energy;
      REQUIRE(!can_break(scene.tree, scene.tree.inboard_joint({body})));
      left = breakable(scene);
      CHECK(static_cast<int>(left.size()) == joints - count);
    }
    for (int b = 0; b < scene.tree.bodies(); ++b) {
      CHECK(scene.tree.parent(b) == -1);
      CHECK(scene.tree.joint(b).kind == Kind::free);
    }
    const Totals end = totals(scene.tree, scene.state, scene.workspace);
    record.enter("energy over all breaks", std::fabs(end.kinetic + end.potential + released - start.kinetic - start.potential),
                 1e-12L * scale.energy);
    record.enter("linear momentum over all breaks", size(end.linear - start.linear), 1e-12L * scale.linear);
    record.enter("angular momentum over all breaks", size(end.angular - start.angular), 1e-12L * scale.angular);
    const Evaluation now = scene.oracle();
    Real speed = 0;
    for (std::size_t k = 0; k < e.motions.size(); ++k)
      speed = std::max(speed, size(now.motions[k].com_velocity - e.motions[k].com_velocity));
    record.enter("velocities of the centres of mass over all breaks", speed, 1e-9L * scale.speed);
  }
}
