// Methods of integration: their order, measured; adaptive ones against their tolerance; events, stops and light links.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/kinds.hpp>
#include <tests/oracle/reference.hpp>

using namespace momentree;
using namespace momentree::oracle;

namespace {

constexpr double degree = std::numbers::pi / 180;

/// A chain on a pin, a universal joint and a ball, with friction, a spring and an effort; all masses and lengths times `scale`.
Model chain(double scale = 1) {
  Model model;
  Body last = ground;
  const Kind kinds[] = {Kind::revolute, Kind::universal, Kind::ball, Kind::revolute};
  for (int k = 0; k < 4; ++k) {
    const double l = scale, m = l * l * l, j = m * l * l;
    BodySpec link{.name = std::to_string(k),
                  .mass = m,
                  .com = {0.2 * l, 0.02 * l, -0.01 * l},
                  .inertia = {0.01 * j, 0.03 * j, 0.032 * j, 0.001 * j, -0.002 * j, 0.0015 * j},
                  .parent = last,
                  .at = {k == 0 ? 0.0 : 0.4 * l, 0, 0},
                  .joint = joint_of(kinds[k], k % 2 ? x_axis : y_axis, z_axis)};
    link.joint.parameters.damping = 0.05 * j;
    if (k == 0) link.joint.parameters.effort = Values{0.5 * j};
    if (k == 3) link.joint.parameters.stiffness = Values{0.8 * j};
    last = model.add(link);
  }
  return model;
}

/// A free body that tumbles and falls.
Model tumbler() {
  Model model;
  BodySpec body{.name = "b", .mass = 1, .com = {0.1, 0, 0.05}, .inertia = diagonal(1, 2, 3), .joint = joint_of(Kind::free)};
  body.v = {0.3, -0.2, 1, 1.5, 2, -1};
  model.add(body);
  return model;
}

struct Outcome {
  std::vector<double> values;  ///< q, v, dissipated, work
  long evaluations = 0, steps = 0;
};
Outcome run_of(const Model& model, const Integration& how, double until) {
  Simulation run(model, how);
  REQUIRE(run.run_until(until) == Status::ok);
  Outcome end;
  for (int b = 0; b < model.size(); ++b)
    for (const double q : run.world().joint({b}).q) end.values.push_back(q);
  for (int b = 0; b < model.size(); ++b)
    for (const double v : run.world().joint({b}).v) end.values.push_back(v);
  end.values.push_back(run.energy().dissipated);
  end.values.push_back(run.energy().work);
  end.evaluations = run.statistics().evaluations[0];
  end.steps = run.statistics().steps;
  return end;
}
double apart(const Outcome& a, const Outcome& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) most = std::max(most, std::abs(a.values[i] - b.values[i]));
  return most;
}

/// Steps of one length all the way, by the method itself.
Outcome fixed_run(const Model& model, const char* method, double h, int steps) {
  Tree tree(model);
  State state = start_state(model, tree);
  Work<double> work(tree);
  Evaluator evaluate(tree, work);
  Books books;
  const auto how = make_integrator(method, tree);
  for (int i = 0; i < steps; ++i) {
    evaluate(state);
    REQUIRE(how->step(evaluate, state, books, h));
  }
  evaluate(state);
  Outcome end;
  end.values.assign(state.q().begin(), state.q().end());
  end.values.insert(end.values.end(), work.v.get(), work.v.get() + tree.nv());
  end.values.push_back(books.dissipated);
  end.values.push_back(books.work);
  return end;
}

}  // namespace

TEST_CASE("every method has its order, in coordinates, velocities and books") {
  const struct {
    const char* name;
    double order, h;
  } methods[] = {{"midpoint", 2, 0.01}, {"rk4", 4, 0.02}, {"dopri5", 5, 0.04}, {"dop853", 8, 0.1}};
  for (const Model& model : {chain(), tumbler()}) {
    const Outcome exact = fixed_run(model, "dop853", 0.001, 800);
    for (const auto& m : methods) {
      const int steps = static_cast<int>(std::lround(0.8 / m.h));
      double coarse = apart(fixed_run(model, m.name, m.h, steps), exact), slope = 0;
      for (int halvings = 1; halvings <= 2; ++halvings) {
        const double fine = apart(fixed_run(model, m.name, std::ldexp(m.h, -halvings), steps << halvings), exact);
        slope = std::log2(coarse / fine);
        MESSAGE(m.name << ", " << model.size() << " bodies, error " << fine << ", slope " << slope);
        coarse = fine;
      }
      CHECK(slope > m.order - 0.5);
    }
  }
}

TEST_CASE("the error of adaptive methods follows the tolerance, and so does their work") {
  for (const Model& model : {chain(), tumbler()}) {
    const Outcome exact = fixed_run(model, "dop853", 0.001, 1000);
    for (const char* method : {"dopri5", "dop853"}) {
      CAPTURE(method);
      long before = 0;
      for (const double tolerance : {1e-5, 1e-7, 1e-9, 1e-11}) {
        const Outcome found = run_of(model, {.method = method, .rtol = tolerance, .atol = tolerance}, 1);
        const double error = apart(found, exact);
        MESSAGE(method << " at " << tolerance << ": error " << error << ", " << found.evaluations << " evaluations, "
                       << found.steps << " steps");
        CHECK(error < 300 * tolerance);
        CHECK(found.evaluations > before);
        before = found.evaluations;
      }
    }
  }
}
