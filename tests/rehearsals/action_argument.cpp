// Compiled with action_argument.patch: the new action has its argument, and carries it out.
#include <cstdio>
#include <utility>

#include <momentree/simulate/actions/soften.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

int main() {
  Model model;
  BodySpec body{.name = "m/a", .mass = 1, .inertia = diagonal(1, 1, 1)};
  body.joint.kind = Kind::universal, body.joint.axis2 = x_axis, body.joint.parameters.stiffness = {1, 2};
  model.add(body);
  actions::Soften soften;
  soften.arguments([](const Argument& argument) {
    if (const auto* joint = argument.as<argument::Joint>()) joint->name = "m/a";
    if (auto* factors = argument.as<std::vector<double>>()) *factors = {0.5, 2};
  });
  Simulation simulation(std::move(model));
  simulation.apply(soften);
  const Values now = simulation.world().tree().parameters(0)->stiffness;
  std::printf("stiffness %g %g\n", now.of(0), now.of(1));
  return now == Values{0.5, 4} ? 0 : 1;
}
