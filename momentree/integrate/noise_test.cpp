// Tolerances below the resolution of velocities that are found from momenta: round-off must not be taken for an error of the
// step.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

TEST_CASE("noise: a chain of light links in momenta ends at any tolerance, where velocities end, too") {
  Model model({.gravity = {0, -9.81, 0}});
  constexpr int links = 60;
  for (int k = 0; k < links; ++k)
    model.add({.name = "b" + std::to_string(k),
               .mass = 0.01,
               .com = {0.025, 0, 0},
               .inertia = diagonal(1e-7, 2.083e-6, 2.083e-6),
               .parent = k == 0 ? ground : BodyId{k - 1},
               .at = {{k == 0 ? 0.0 : 0.05, 0, 0}, Quat{}},
               .joint = Revolute{.damping = {1e-5}},
               .q = {0.001 * (k + 1)}});
  const auto run = [&](Variables variables) {
    Simulation sim(model, {.method = "dop853", .variables = variables, .rtol = 1e-13, .atol = 1e-14});
    sim.watch([steps = 0](double) mutable { return ++steps < 3000; });
    CHECK(sim.run_until(0.3).status == Status::ok);
    return sim;
  };
  const Simulation p = run(Variables::momenta), u = run(Variables::velocities);
  CHECK(p.statistics().evaluations[0] < 3 * u.statistics().evaluations[0]);
  for (std::size_t i = 0; i < links; ++i) CHECK(std::fabs(p.world().state().q()[i] - u.world().state().q()[i]) < 1e-9);
}

namespace {

/// A sphere that spins while its centre of mass moves, with its frame `away` from there (m).
struct Sphere {
  double inertia, away;
  Vec3 gravity{}, drift{0.1, 0.2, 0.3}, spin{1, 2, 3};  ///< of the centre (m/s); rad/s
  Variables variables = Variables::velocities;

  /// Its evaluations in 5 s at tolerances of 1e-12, and how far it is then from where it should be.
  struct Run {
    long evaluations = 0;
    double off = 0;
  };
  Run run(bool beside_another = false) const {
    const Vec3 c = away * Vec3{0.7, 0.5, std::sqrt(0.26)};
    const Vec3 v = drift - cross(spin, c);
    Model model({.gravity = gravity});
    const BodyId body = model.add({.name = "sphere",
                                   .mass = 1,
                                   .com = c,
                                   .inertia = diagonal(inertia),
                                   .joint = Free{},
                                   .q = {0, 0, 0, 1, 0, 0, 0},
                                   .v = {v.x, v.y, v.z, spin.x, spin.y, spin.z}});
    if (beside_another)
      model.add({.name = "other", .mass = 1e-3, .inertia = diagonal(1e-13), .joint = Free{}, .q = {0, 0, 0, 1, 0, 0, 0}});
    Simulation sim(model, {.method = "dop853", .variables = variables, .rtol = 1e-12, .atol = 1e-12});
    sim.watch([steps = 0](double) mutable { return ++steps < 3000; });
    REQUIRE(sim.run_until(5) == Status::ok);
    const Pose now = sim.world().motions()[static_cast<std::size_t>(body.index)].pose;
    const Quat turned = from_axis_angle(normalized(spin), 5 * norm(spin));
    const Vec3 centre = now.position + rotation_matrix(now.rotation) * c, there = c + 5.0 * drift + 12.5 * gravity;
    return {sim.statistics().evaluations[0],
            std::max(norm(centre - there), norm(log_rotation(conjugate(turned) * now.rotation)))};
  }
};

constexpr Vec3 falling{0.3, -9.81, 2};

}  // namespace

TEST_CASE("noise: neither its inertia nor its frame costs a floating body evaluations") {
  for (const bool beside_another : {false, true})
    for (const Vec3& gravity : {Vec3{}, falling}) {
      CAPTURE(beside_another);
      CAPTURE(gravity.y);
      const Sphere::Run plain = Sphere{.inertia = 1, .away = 0, .gravity = gravity}.run(beside_another);
      const Sphere::Run light = Sphere{.inertia = 1e-12, .away = 1, .gravity = gravity}.run(beside_another);
      if (gravity.y == 0) CHECK(plain.evaluations < 700);
      CHECK(light.evaluations == plain.evaluations);
      CHECK(plain.off < 1e-10);  // of 120 m if it falls
      CHECK(light.off < 1e-10);
    }
}

TEST_CASE("noise: in momenta, neither does the inertia of a body whose frame is at its centre of mass") {
  for (const Vec3& gravity : {Vec3{}, falling}) {
    CAPTURE(gravity.y);
    const Sphere::Run plain = Sphere{.inertia = 1, .away = 0, .gravity = gravity, .variables = Variables::momenta}.run();
    const Sphere::Run light = Sphere{.inertia = 1e-12, .away = 0, .gravity = gravity, .variables = Variables::momenta}.run();
    CHECK(light.evaluations == plain.evaluations);
    CHECK(light.off < 1e-10);
    // p holds the angular momentum about the frame's own origin, where that of the spin is lost in rounding: each one that is of
    // the size of p/2⁵³ turns a body with so little inertia by some 1e-8 rad in a second.
    const Sphere::Run far = Sphere{.inertia = 1e-6, .away = 1, .gravity = gravity, .variables = Variables::momenta}.run();
    CHECK(far.evaluations < 2 * plain.evaluations);
    CHECK(far.off < 3e-7);
  }
}

}  // namespace momentree
