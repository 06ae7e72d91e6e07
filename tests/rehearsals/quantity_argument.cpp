// Compiled with quantity_argument.patch: the new quantity has its argument, and conditions use it.
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include <momentree/simulate/quantities/mean_height.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

int main() {
  Model model;
  for (const char* name : {"a", "b"}) {
    BodySpec body{.name = name, .mass = 1, .inertia = diagonal(1, 1, 1)};
    body.joint.kind = Kind::free;
    model.add(std::move(body));
  }
  const auto height = std::make_shared<quantities::MeanHeight>();
  height->arguments([](const Argument& argument) {
    if (auto* bodies = argument.as<std::vector<std::string>>()) *bodies = {"a", "b"};
  });
  Simulation simulation(std::move(model));
  simulation.when(Measure(height).below(-1)).then(impulse("a", {0, 0, 1}));
  (void)simulation.run_until(1);
  const double fell = simulation.events().empty() ? 0 : simulation.events().front().time;
  std::printf("below -1 m at %g s\n", fell);
  return std::fabs(fell - std::sqrt(2 / 9.81)) < 1e-3 ? 0 : 1;
}
