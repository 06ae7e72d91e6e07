// A program outside the project's tree reads a scenario, and is told what is wrong with another.
#include <momentree/io/scenario.hpp>
#include <momentree/momentree.hpp>

#include <cstdio>

int main() {
  using namespace momentree;
  const char* text =
      "format = 1\n"
      "[[mechanism]]\nname = \"m\"\n"
      "[[mechanism.body]]\nname = \"rod\"\nmass = 1\ncom = [0.5, 0, 0]\ninertia = [0, 0.1, 0.1]\n"
      "[mechanism.body.joint]\nkind = \"revolute\"\naxis = [0, 1, 0]\n";
  const io::ReadResult good = io::read_scenario_text(text, "rod.toml");
  for (const io::Diagnostic& d : good.diagnostics) std::puts(d.message().c_str());
  if (!good.scenario || good.scenario->model.size() != 1) return 1;
  Simulation simulation(good.scenario->model, good.scenario->integration);
  if (simulation.run_until(0.1) != Status::ok) return 1;

  const io::ReadResult bad = io::read_scenario_text("format = 1\nmechanisms = 2\n", "bad.toml");
  bool told = false;
  for (const io::Diagnostic& d : bad.diagnostics) std::puts(d.message().c_str()), told = told || d.line == 2;
  return told && !bad.scenario ? 0 : 1;
}
