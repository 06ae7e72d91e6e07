// Impacts of articulated mechanisms on a floor, against conservation laws; a rod that falls, against a time-stepping scheme that
// shares nothing with the engine.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/solid.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

/// A random tree, a little above a floor that its bodies hit with balls at their centres of mass.
Model mechanism_above_floor(std::uint64_t seed) {
  Prng random(seed + 91000);
  RandomTreeOptions options;
  options.min_bodies = 2, options.max_bodies = 8, options.parameters = false, options.all_free = random.chance(0.5);
  Model model = random_tree(seed, options).model;
  double lowest = 1e9;
  {
    const Simulation sim(model);
    for (int b = 0; b < model.size(); ++b)
      lowest = std::min(lowest, (sim.world().motions()[static_cast<std::size_t>(b)].pose * model[{b}].com).z);
  }
  for (int b = 0; b < model.size(); ++b)
    model.add_collider({.body = {b}, .solid = contact::sphere(0.05, Pose{model[{b}].com, {}})});
  model.add_collider({.plane = true, .point = {0, 0, lowest - 0.06}});
  const double mu = random.uniform(0, 1.2);
  model.add_contact_rule({.law = {.friction = mu, .static_friction = mu, .restitution = random.uniform(0, 1)}});
  model.add_contact_rule({.law = {.off = true}, .one_name = "*", .other_name = "*"});
  return model;
}

/// A thin rod in a vertical plane whose ends, balls, fall on the floor without bouncing: Moreau's scheme with the midpoint of the
/// configuration, and Gauss-Seidel sweeps over the two contacts.
struct Rod {
  double x = 0, z = 0.5, angle = 0.4, vx = 0.3, vz = 0, w = 0;
  static constexpr double mass = 2, half = 0.5, radius = 0.02, moment = 0.15, friction = 0.3, g = 9.81;

  void step(double h) {
    x += 0.5 * h * vx, z += 0.5 * h * vz, angle += 0.5 * h * w;
    vz -= h * g;
    double normal[2] = {}, along[2] = {};
    double changed = 1;
    for (int sweep = 0; sweep < 2000 && changed > 1e-15; ++sweep) {
      changed = 0;
      for (int k = 0; k < 2; ++k) {
        // The lowest point of an end, from the centre.
        const double s = k == 0 ? half : -half, rx = s * std::cos(angle), rz = s * std::sin(angle) - radius;
        if (z + rz > 0) continue;
        const double un = vz + w * rx, n = std::max(0.0, normal[k] - un / (1 / mass + rx * rx / moment));
        const double dn = n - normal[k];
        normal[k] = n, vz += dn / mass, w += dn * rx / moment;
        const double ut = vx - w * rz, most = friction * n;
        const double t = std::min(most, std::max(-most, along[k] - ut / (1 / mass + rz * rz / moment)));
        const double dt = t - along[k];
        along[k] = t, vx += dt / mass, w -= dt * rz / moment;
        changed = std::max({changed, std::fabs(dn), std::fabs(dt)});
      }
    }
    x += 0.5 * h * vx, z += 0.5 * h * vz, angle += 0.5 * h * w;
  }
};

}  // namespace

TEST_CASE("10000 impacts of random mechanisms on a floor: none gains energy, and momentum changes by what the floor exerts") {
  int impacts = 0, mechanisms = 0;
  for (std::uint64_t seed = 0; impacts < 10000; ++seed) {
    REQUIRE(seed < 3000);
    Simulation sim(mechanism_above_floor(seed), {.method = "dopri5", .step = 1e-3, .rtol = 1e-7, .atol = 1e-9});
    INFO("seed ", seed);
    int steps = 0;
    sim.watch([&](double) { return ++steps < 3000 && sim.events().size() < 60; });
    static_cast<void>(sim.run_until(0.6));  // a motion that diverges has had its impacts, too
    int own = 0;
    for (const Event& event : sim.events()) {
      if (event.name != "impact") continue;
      ++own;
      const double kinetic = event.before.kinetic;
      CHECK(event.after.kinetic <= kinetic * (1 + 1e-12));
      CHECK(event.lost >= -1e-12 * kinetic);
      const std::array<double, 6>& G = event.ground_impulse;
      const double size = norm(event.before.linear) + norm(Vec3{G[0], G[1], G[2]});
      CHECK(norm(event.after.linear - event.before.linear - Vec3{G[0], G[1], G[2]}) <= 1e-12 * size);
    }
    impacts += own, mechanisms += own > 0 ? 1 : 0;
  }
  CHECK(mechanisms > 200);
}

TEST_CASE("a rod that falls, slaps the floor and slides moves as time stepping says, the nearer the shorter its steps are") {
  constexpr double until = 0.8;
  Model model({.gravity = {0, 0, -Rod::g}});
  const Rod start;
  const BodyId rod = model.add({.name = "rod",
                                .mass = Rod::mass,
                                .inertia = diagonal(0.01, Rod::moment, Rod::moment),
                                .joint = Free{},
                                .q = {start.x, 0, start.z, std::cos(start.angle / 2), 0, -std::sin(start.angle / 2), 0},
                                .v = {start.vx * std::cos(start.angle), 0, -start.vx * std::sin(start.angle), 0, 0, 0}});
  for (const double end : {Rod::half, -Rod::half})
    model.add_collider({.body = rod, .solid = contact::sphere(Rod::radius, {end, 0, 0})});
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = Rod::friction, .static_friction = Rod::friction}});
  Simulation sim(model, {.method = "dop853", .step = 1e-3, .rtol = 1e-12, .atol = 1e-14});
  const RunResult run = sim.run_until(until);
  INFO(run.reason);
  REQUIRE(run);
  CHECK(sim.events().size() >= 3);
  const Vec3 exact = sim.world().motions()[0].pose.position;
  double before = 0;
  for (const int steps : {3000, 12000, 48000}) {
    Rod stepped;
    for (int k = 0; k < steps; ++k) stepped.step(until / steps);
    const double error = std::hypot(stepped.x - exact.x, stepped.z - exact.z);
    CAPTURE(steps);
    CAPTURE(error);
    CHECK(error < 3.0 / steps);
    if (before > 0) CHECK(error < 0.5 * before);
    before = error;
  }
}
