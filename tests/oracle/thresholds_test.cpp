// Joints that break by their own loads: which, and when, does not depend on the method or its steps.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

// A chain that swings from level, its links tied to one another ever more weakly.
std::vector<Event> breaks(const Integration& integration) {
  Model model;
  Body last = ground;
  for (int k = 1; k <= 8; ++k)
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = 0.5,
                      .com = {0.15, 0, 0},
                      .inertia = diagonal(1e-4, 4e-3, 4e-3),
                      .parent = last,
                      .at = {k == 1 ? 0.0 : 0.3, 0, 0},
                      .joint = Revolute{.axis = {0, 1, 0}, .damping = 0.01},
                      .q = 0.05 * k});
  Simulation sim(model, integration);
  const double strength[8] = {60, 44, 35, 27, 21, 15, 9.5, 4.2};
  for (int k = 1; k <= 8; ++k) {
    const std::string joint = "c/" + std::to_string(k);
    sim.when(reaction_force(joint).exceeds(strength[k - 1])).then(break_joint(joint));
  }
  REQUIRE(sim.run_until(1.5) == Status::ok);
  return sim.events();
}

}  // namespace

TEST_CASE("a chain whose joints break by tension: the same joints at the same instants by every method") {
  const std::vector<Event> exact = breaks({.method = "dopri5", .rtol = 1e-11, .atol = 1e-13});
  REQUIRE(exact.size() >= 3);
  for (const Integration& how : {Integration{.method = "rk4", .step = 1e-4}, Integration{.method = "dop853", .rtol = 1e-10}}) {
    const std::vector<Event> found = breaks(how);
    REQUIRE(found.size() == exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      CHECK(found[i].actions == exact[i].actions);
      CHECK(std::fabs(found[i].time - exact[i].time) < 1e-7);
    }
  }
  double last = 0;
  for (const Event& e : exact) {
    CHECK(e.time >= last);
    last = e.time;
  }
}

TEST_CASE("global order through an event that waits for a condition") {
  // A pendulum whose pin wears out to a ball when its speed passes a threshold: errors of the end against the step.
  const auto end = [](const std::string& method, double step) {
    Model model;
    model.add({.name = "rod",
               .mass = 1,
               .com = {0.4, 0, 0},
               .inertia = diagonal(0.01, 0.05, 0.05),
               .joint = Revolute{.axis = {0, 1, 0}}});
    Simulation sim(model, {.method = method, .step = step, .event_tolerance = 1e-13, .rtol = 1e-13, .atol = 1e-14});
    sim.when(speed_of("rod").exceeds(4)).then(change_joint("rod", Ball{}));
    REQUIRE(sim.run_until(1) == Status::ok);
    REQUIRE(sim.events().size() == 1);
    return sim.world().motions()[0].pose.position + rotation_matrix(sim.world().motions()[0].pose.rotation) * Vec3{1, 0.2, 0};
  };
  const Vec3 exact = end("dop853", 1e-3);
  const double coarse = norm(end("rk4", 5e-3) - exact), fine = norm(end("rk4", 2.5e-3) - exact);
  CHECK(std::log2(coarse / fine) > 3.7);
  CHECK(fine > 1e-11);  // of the method, not of rounding
}
