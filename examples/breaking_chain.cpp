// A chain of 100 bodies swings and breaks: the example of Naudet and Lefeber (2005).
#include <momentree/momentree.hpp>

#include <cstdio>
#include <string>

using namespace momentree;

int main() {
  Model chain({.gravity = {0, -9.81, 0}});
  BodyId link = ground;
  for (int k = 1; k <= 100; ++k)
    link = chain.add({.name = "chain/" + std::to_string(k),
                      .mass = 0.010,
                      .com = {0.025, 0, 0},
                      .inertia = diagonal(2.083e-6),
                      .parent = link,
                      .at = {k == 1 ? 0.0 : 0.05, 0, 0},
                      .joint = Revolute{.axis = z_axis, .damping = 1e-5},
                      .q = 0.001 * k});

  Simulation sim(chain, {.method = "rk4", .step = 1e-3});
  sim.at(1.8).then(break_joint("chain/41"));
  if (const RunResult run = sim.run_until(3.0); !run) return std::fprintf(stderr, "%s\n", run.reason.c_str()), 1;

  for (const Event& e : sim.events())
    std::printf("%g s: %s, %zu mechanisms\n", e.time, e.actions[0].text().c_str(), e.mechanisms_after.size());
  const Vec3 tip = sim.world().motions()[99].pose.position;
  std::printf("%g s: chain/100 is at (%.3f, %.3f) m\n", sim.time(), tip.x, tip.y);
}
