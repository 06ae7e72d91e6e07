// Comparison of integration methods: measured error against evaluations, as a table in Markdown (docs/howto/choose-a-method.md).
// Counts and errors are reproducible; no time is measured.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <bench/methods/lie_group.hpp>
#include <bench/models.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

/// A free body that spins about its middle axis, falling.
Model tumbler() {
  Model model;
  BodySpec body{.name = "b", .mass = 1, .inertia = diagonal(1, 2, 3), .joint = Free{}};
  body.v = {0.3, -0.2, 1, 0.1, 2, -0.1};
  model.add(body);
  return model;
}

/// A double pendulum of two rods with large swings, without friction.
Model double_pendulum() {
  Model model({.gravity = {0, -9.81, 0}});
  BodyId last = ground;
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

/// A heavy top on its point, spinning at 40 rad/s and leaning.
Model spinning_top() {
  Model model;
  BodySpec body{.name = "top", .mass = 0.5, .com = {0, 0, 0.1}, .inertia = diagonal(5e-4, 5e-4, 8e-4), .joint = Ball{}};
  body.q = {std::cos(0.2), std::sin(0.2), 0, 0};
  body.v = {0, 0, 40};
  model.add(body);
  return model;
}

/// An overdamped arm of five links: its fastest mode decays in tens of microseconds.
Model damped_arm() {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < 5; ++k)
    last = model.add({.name = std::to_string(k),
                      .mass = 1,
                      .com = {0.2, 0, 0},
                      .inertia = diagonal(0.001, 0.0133, 0.0133),
                      .parent = last,
                      .at = {k == 0 ? 0.0 : 0.4, 0, 0},
                      .joint = Revolute{.axis = k % 2 ? x_axis : y_axis, .damping = 20.0},
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

End run_on_the_group(const Model& model, double step, double until) {
  const Tree tree(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  Evaluator evaluate(tree, workspace);
  bench::Rkmk4 method(tree);
  const auto energy = [&] {
    const Totals t = totals(tree, state, workspace);
    return t.kinetic + t.potential;
  };
  evaluate(state);
  const double before = energy();
  for (long i = std::lround(until / step); i > 0; --i) {
    evaluate(state);
    method.step(evaluate, state, step);
  }
  End end;
  end.fine = true;
  end.q.assign(state.q().begin(), state.q().end());
  end.evaluations = evaluate.count;
  end.energy = std::fabs(energy() - before);
  return end;
}

}  // namespace

int main() {
  const struct {
    const char* name;
    Model model;
    double until;
    std::vector<double> steps;
    std::vector<const char*> fixed, adaptive;
    bool on_the_group = false;
  } rows[] = {
      {"free body, 10 s", tumbler(), 10, {0.05, 0.01, 0.002}, {"rk4", "midpoint"}, {"dopri5", "dop853"}, true},
      {"spinning top, 2 s", spinning_top(), 2, {0.01, 0.005, 0.001}, {"rk4"}, {"dopri5", "dop853"}, true},
      {"double pendulum, 5 s", double_pendulum(), 5, {0.01, 0.002, 0.0005}, {"rk4", "midpoint"}, {"dopri5", "dop853"}},
      {"spatial chain of 10, 0.5 s",
       bench::spatial_chain(10),
       0.5,
       {0.002, 0.0005, 0.0001},
       {"rk4", "midpoint"},
       {"dopri5", "dop853"}},
      {"strongly damped arm, 2 s", damped_arm(), 2, {0.05, 0.01, 0.002, 0.00005}, {"rk4", "damped"}, {"dopri5", "dop853"}}};
  std::printf("| mechanism | method | step or rtol = atol | evaluations | error of q | error of the energy (J) |\n");
  std::printf("| --- | --- | --- | ---: | ---: | ---: |\n");
  for (const auto& row : rows) {
    const End exact = run_of(row.model, {.method = "dop853", .rtol = 1e-14, .atol = 1e-14}, row.until);
    const auto print = [&](const char* method, const End& end, double setting) {
      double error = 0;
      for (std::size_t i = 0; i < end.q.size(); ++i) error = std::max(error, std::fabs(end.q[i] - exact.q[i]));
      if (end.fine)
        std::printf("| %s | `%s` | %.0e | %ld | %.1e | %.1e |\n", row.name, method, setting, end.evaluations, error, end.energy);
      else
        std::printf("| %s | `%s` | %.0e | diverged | | |\n", row.name, method, setting);
    };
    for (const char* method : row.fixed)
      for (const double step : row.steps) print(method, run_of(row.model, {.method = method, .step = step}, row.until), step);
    for (const double step : row.steps)
      if (row.on_the_group) print("rkmk4", run_on_the_group(row.model, step, row.until), step);
    for (const char* method : row.adaptive)
      for (const double tolerance : {1e-5, 1e-8, 1e-11})
        print(method, run_of(row.model, {.method = method, .rtol = tolerance, .atol = tolerance}, row.until), tolerance);
  }
}
