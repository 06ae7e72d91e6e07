// Code for one mechanism, from the installed library: written, and run where there is machine code.
#include <cstdio>
#include <momentree/generate/kernel_cache.hpp>
#include <momentree/generate/source.hpp>
#include <momentree/momentree.hpp>

int main() {
  using namespace momentree;
  Model model;
  model.add({.name = "rod", .mass = 1, .com = {0, 0, -0.5}, .joint = Revolute{.axis = y_axis, .damping = 0.1}, .q = 0.5});
  const Tree tree = compile(model);
  const std::string source = kernel_source(kernel_expressions(tree), {.name = "rod", .about = ""});
  const KernelCache kernels;
  Simulation sim(model);
  sim.use_generated(kernels.provider());
  const bool moved = sim.run_until(0.1) == Status::ok;
  const bool ran = kernels.statistics().compiled == 1 || !kernels.message().empty();
  std::printf("%zu characters, %ld compiled %s\n", source.size(), kernels.statistics().compiled, kernels.message().c_str());
  return moved && ran && source.find("void rod_rates(") != std::string::npos ? 0 : 1;
}
