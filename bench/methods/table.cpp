// Which method for what: measured error against evaluations, as a table in Markdown (docs/howto/choose-a-method.md). Counts and
// errors repeat; no time is measured.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <bench/models.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

/// A free body with spin about its middle axis, falling.
Model tumbler() {
  Model model;
  BodySpec body{.name = "b", .mass = 1, .inertia = diagonal(1, 2, 3), .joint = Free{}};
  body.v = {0.3, -0.2, 1, 0.1, 2, -0.1};
  model.add(body);
  return model;
}

/// Two rods on pins in full swing, without friction.
Model double_pendulum() {
  Model model({.gravity = {0, -9.81, 0}});
  Body last = ground;
  for (int k = 0; k < 2; ++k)
    last = model.add({.name = std::to_string(k),
                      .mass = 1,
                      .com = {0.5, 0, 0},
                      .inertia = diagonal(0.001, 1.0 / 12, 1.0 / 12),
                      .parent = last,
                      .at = {k == 0 ? 0.0 : 1.0, 0, 0},
                      .joint = Revolute{},
                      .q = 0.3});
  return model;
}

struct End {
  std::vector<double> q;
  long evaluations = 0;
  double energy = 0;
  bool fine = false;
};
End run_of(const Model& model, const Integration& how, double until) {
  Simulation run(model, how);
  End end;
  end.fine = run.run_until(until) == Status::ok;
  for (int b = 0; b < model.size(); ++b)
    for (const double q : run.world().joint({b}).q) end.q.push_back(q);
  end.evaluations = run.statistics().evaluations[0];
  end.energy = std::fabs(run.energy().error);
  return end;
}

}  // namespace

int main() {
  const struct {
    const char* name;
    Model model;
    double until;
    std::vector<double> steps;
  } rows[] = {{"free body, 10 s", tumbler(), 10, {0.05, 0.01, 0.002}},
              {"double pendulum, 5 s", double_pendulum(), 5, {0.01, 0.002, 0.0005}},
              {"spatial chain of 10, 0.5 s", bench::spatial_chain(10), 0.5, {0.002, 0.0005, 0.0001}}};
  std::printf("| mechanism | method | step or rtol = atol | evaluations | error of q | error of the energy (J) |\n");
  std::printf("| --- | --- | --- | ---: | ---: | ---: |\n");
  for (const auto& row : rows) {
    const End exact = run_of(row.model, {.method = "dop853", .rtol = 1e-14, .atol = 1e-14}, row.until);
    const auto print = [&](const Integration& how, double setting) {
      const End end = run_of(row.model, how, row.until);
      double error = 0;
      for (std::size_t i = 0; i < end.q.size(); ++i) error = std::max(error, std::fabs(end.q[i] - exact.q[i]));
      if (end.fine)
        std::printf("| %s | `%s` | %.0e | %ld | %.1e | %.1e |\n", row.name, how.method.c_str(), setting, end.evaluations, error,
                    end.energy);
      else
        std::printf("| %s | `%s` | %.0e | diverged | | |\n", row.name, how.method.c_str(), setting);
    };
    for (const char* method : {"rk4", "midpoint"})
      for (const double step : row.steps) print({.method = method, .step = step}, step);
    for (const char* method : {"dopri5", "dop853"})
      for (const double tolerance : {1e-5, 1e-8, 1e-11})
        print({.method = method, .rtol = tolerance, .atol = tolerance}, tolerance);
  }
}
