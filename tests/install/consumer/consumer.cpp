// A program outside the project's tree: a pendulum of a point mass, let go at the horizontal, keeps its energy.
#include <momentree/momentree.hpp>

#include <cmath>
#include <cstdio>

int main() {
  using namespace momentree;
  Model model({.gravity = {0, -9.81, 0}});
  model.add({.name = "pendulum", .mass = 2, .com = {0.5, 0, 0}, .joint = Revolute{.axis = z_axis}});
  Simulation simulation(model, {.step = 1e-3});
  if (!simulation.run_until(1.0)) return 1;
  const Totals totals = simulation.world().totals();
  std::printf("energy after 1 s: %.3e J\n", totals.kinetic + totals.potential);
  return std::abs(totals.kinetic + totals.potential) < 1e-9 && totals.kinetic > 1 ? 0 : 1;
}
