// Public data of a World while it runs and breaks, checked against the oracle, which also reads topology and joints from the
// World.
#include <algorithm>
#include <string>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/laws.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

Real size(const V3<Real>& a) { return std::sqrt(dot(a, a)); }
Real apart(const Vec3& a, const V3<Real>& b) { return size(V3<Real>{{a.x, a.y, a.z}} - b); }
double length(const Vec3& a) { return norm(a); }

/// All joints' numbers one after the other, by body number.
std::vector<double> gather(const World& world, Numbers JointView::*which) {
  std::vector<double> all;
  for (int b = 0; b < world.model().size(); ++b) {
    const JointView joint = world.joint({b});
    all.insert(all.end(), (joint.*which).begin(), (joint.*which).end());
  }
  return all;
}

void check_world(const World& world) {
  const System system = system_of(world);
  const std::vector<double> q = gather(world, &JointView::q), v = gather(world, &JointView::v), p = gather(world, &JointView::p),
                            rates = gather(world, &JointView::pdot);
  REQUIRE(static_cast<int>(q.size()) == system.nq());
  REQUIRE(static_cast<int>(p.size()) == system.nv());
  const std::vector<Real> u(v.begin(), v.end()), momenta(p.begin(), p.end());
  const MassMatrix mass = mass_matrix(system, q);
  const Spectrum range = spectrum(mass);
  CHECK(distance(mass.times(u), momenta) <= 1e-13L * (static_cast<Real>(range.largest) * norm(u) + norm(momenta)));
  const Evaluation e = evaluate(system, q, u);
  CHECK(distance({rates.begin(), rates.end()}, e.pdot) <= 1e-10L * norm(e.pdot));
  Real reach = 1, speed = 0, spin = 0, weight = 0, all = 0;
  for (std::size_t k = 0; k < e.motions.size(); ++k) {
    const auto& m = e.motions[k];
    reach = std::max(reach, size(m.frame.position));
    speed = std::max(speed, size(m.velocity));
    spin = std::max(spin, size(m.angular));
    all += system.links[k].mass;
    weight += system.links[k].mass * size(system.gravity) * (1 + size(m.com));
  }
  for (std::size_t k = 0; k < e.motions.size(); ++k) {
    const BodyMotion& m = world.motions()[k];
    CHECK(apart(m.pose.position, e.motions[k].frame.position) <= 1e-13L * reach);
    const Mat3 R = rotation_matrix(m.pose.rotation);
    for (const auto& [column, i] :
         {std::pair{Vec3{R.xx, R.yx, R.zx}, 0u}, {Vec3{R.xy, R.yy, R.zy}, 1u}, {Vec3{R.xz, R.yz, R.zz}, 2u}}) {
      const M3<Real>& expected = e.motions[k].frame.rotation;
      CHECK(apart(column, {{expected[i], expected[3 + i], expected[6 + i]}}) <= 1e-13L);
    }
    CHECK(apart(m.linear, e.motions[k].velocity) <= 1e-13L * (speed + spin * reach));
    CHECK(apart(m.angular, e.motions[k].angular) <= 1e-13L * spin);
  }
  const Totals sum = world.totals();
  CHECK(std::fabs(sum.kinetic - e.kinetic) <= 1e-12L * e.kinetic);
  CHECK(std::fabs(sum.potential - e.potential) <= 1e-13L * (weight + std::fabs(e.potential)));
  CHECK(apart(sum.linear, e.linear) <= 1e-13L * all * (speed + spin));
  CHECK(apart(sum.angular, e.angular) <= 1e-13L * all * (speed + spin) * reach);
}

}  // namespace

TEST_CASE("the public data of a world that runs and breaks equal the oracle's") {
  int happened = 0;
  for (std::uint64_t seed = 0; seed < 90; ++seed) {
    CAPTURE(seed);
    const RandomTree random = random_tree(seed, {.max_bodies = 25});
    Simulation run(random.model, {.step = 1e-5});
    Prng draw(seed + 77);
    for (int i = 0; i < 4; ++i) {
      const double time = draw.uniform(0, 2e-4);
      const int body = draw.integer(0, random.model.size() - 1);
      run.at(time).then(break_joint(random.model[{body}].joint_name));
    }
    check_world(run.world());
    REQUIRE(run.run_until(1e-4) == Status::ok);
    check_world(run.world());
    REQUIRE(run.run_until(2e-4) == Status::ok);
    check_world(run.world());
    CHECK(run.events().size() == 4);
    int bodies = 0;
    for (const Mechanism& m : run.world().mechanisms()) bodies += static_cast<int>(m.bodies.size());
    CHECK(bodies == random.model.size());
    for (const Event& e : run.events()) happened += e.actions.at(0).text().find("skipped") == std::string::npos;
  }
  CHECK(happened > 200);
}

TEST_CASE("each break in a free system without friction keeps energy and momenta to 1e-12") {
  int happened = 0;
  double worst_energy = 0, worst_linear = 0, worst_angular = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const RandomTree random = random_tree(seed, {.max_bodies = 20, .all_free = true, .gravity = false, .conservative = true});
    Simulation run(random.model, {.step = 1e-4});
    Prng draw(seed + 177);
    std::vector<int> order;
    for (int b = 0; b < random.model.size(); ++b) order.insert(order.begin() + draw.integer(0, b), b);
    for (std::size_t i = 0; i < order.size(); ++i)
      run.at(1e-3 * static_cast<double>(i / 2 + 1)).then(break_joint(random.model[{order[i]}].joint_name));  // two per instant
    const Status status = run.run_until(1e-3 * static_cast<double>(order.size() / 2 + 2)).status;
    CAPTURE(run.result().reason);
    REQUIRE(status == Status::ok);
    CHECK(run.events().size() == order.size());
    for (const Event& e : run.events()) {
      const double energy = e.before.kinetic + e.before.potential;
      worst_energy = std::max(worst_energy, std::abs(e.after.kinetic + e.after.potential + e.released - energy) / energy);
      worst_linear = std::max(worst_linear, length(e.after.linear - e.before.linear) / length(e.before.linear));
      worst_angular = std::max(worst_angular, length(e.after.angular - e.before.angular) / length(e.before.angular));
      happened += e.actions.at(0).text().find("skipped") == std::string::npos;
    }
    for (const Mechanism& m : run.world().mechanisms()) CHECK(m.bodies.size() == 1);
  }
  MESSAGE("worst relative changes: energy " << worst_energy << ", linear " << worst_linear << ", angular momentum "
                                            << worst_angular);
  CHECK(happened > 300);
  CHECK(worst_energy <= 1e-12);
  CHECK(worst_linear <= 1e-12);
  CHECK(worst_angular <= 1e-12);
}
