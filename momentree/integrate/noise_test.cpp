// Tolerances below the resolution of velocities that are found from momenta: round-off must not be taken for an error of the
// step.
#include <doctest/doctest.h>

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

}  // namespace momentree
