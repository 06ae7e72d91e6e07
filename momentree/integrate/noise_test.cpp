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

TEST_CASE("noise: a body whose inertia is far below that of its mass about its own frame is integrated at the limit of rounding") {
  for (const bool in_tree : {false, true}) {
    CAPTURE(in_tree);
    Model model({.gravity = {0.3, -9.81, 2}});
    const BodyId light = model.add({.name = "light",
                                    .mass = 1,
                                    .com = {0.7, 0.5, std::sqrt(0.26)},  // 1 m away
                                    .inertia = diagonal(1e-12),
                                    .joint = Free{},
                                    .q = {0, 0, 0, 1, 0, 0, 0},
                                    .v = {0.1, 0.2, 0.3, 1, 2, 3}});
    if (in_tree) model.add({.name = "other", .mass = 1e-3, .inertia = diagonal(1e-13), .joint = Free{}, .q = {0, 0, 0, 1, 0, 0, 0}});
    Simulation sim(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-12});
    REQUIRE(sim.run_until(5) == Status::ok);
    CHECK(sim.statistics().evaluations[0] < 700);
    // A sphere: its axis stays, and its centre of mass falls freely.
    const Motion<double> start{{0.1, 0.2, 0.3}, {1, 2, 3}};
    const Vec3 c{0.7, 0.5, std::sqrt(0.26)}, g{0.3, -9.81, 2};
    const Vec3 fallen = c + 5.0 * (start.v + cross(start.w, c)) + 12.5 * g;
    const Quat turned = from_axis_angle(normalized(start.w), 5 * norm(start.w));
    const Pose now = sim.world().motions()[light.index].pose;
    CHECK(norm(now.position + rotation_matrix(now.rotation) * c - fallen) < 1e-10);
    CHECK(norm(log_rotation(conjugate(turned) * now.rotation)) < 1e-10);
  }
}

}  // namespace momentree
