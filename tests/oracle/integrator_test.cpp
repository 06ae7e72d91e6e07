// Integration methods: their measured order; adaptive methods against their tolerance; events, stops and light links.
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

/// A chain with revolute, universal and ball joints, with friction, a spring and an effort; all masses and lengths times `scale`.
Model chain(double scale = 1) {
  Model model;
  BodyId last = ground;
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

/// Steps of constant length, made by the method itself.
Outcome fixed_run(const Model& model, const std::string& method, double h, int steps) {
  Tree tree(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  Evaluator evaluate(tree, workspace);
  EnergyLedger ledger;
  const auto how = make_integrator(method, tree);
  for (int i = 0; i < steps; ++i) {
    evaluate(state);
    REQUIRE(how->step(evaluate, state, ledger, h));
  }
  evaluate(state);
  Outcome end;
  end.values.assign(state.q().begin(), state.q().end());
  end.values.insert(end.values.end(), workspace.v.get(), workspace.v.get() + tree.nv());
  end.values.push_back(ledger.dissipated);
  end.values.push_back(ledger.work);
  return end;
}

}  // namespace

TEST_CASE("every method has its order, in coordinates, velocities and the energy ledger") {
  const struct {
    std::string name;
    double order, h[2];
  } methods[] = {
      {"midpoint", 2, {0.01, 0.02}}, {"rk4", 4, {0.01, 0.05}}, {"dopri5", 5, {0.01, 0.05}}, {"dop853", 8, {0.02, 0.2}}};
  int number = 0;
  for (const Model& model : {chain(), tumbler()}) {
    const Outcome exact = fixed_run(model, "dop853", 0.001, 800);
    for (const auto& m : methods) {
      const double h = m.h[number];
      const int steps = static_cast<int>(std::lround(0.8 / h));
      double coarse = apart(fixed_run(model, m.name, h, steps), exact), slope = 0;
      for (int halvings = 1; halvings <= 2; ++halvings) {
        const double fine = apart(fixed_run(model, m.name, std::ldexp(h, -halvings), steps << halvings), exact);
        slope = std::log2(coarse / fine);
        MESSAGE(m.name << ", " << model.size() << " bodies, error " << fine << ", slope " << slope);
        coarse = fine;
      }
      CHECK(slope > m.order - 0.5);
    }
    ++number;
  }
}

TEST_CASE("the error of adaptive methods follows the tolerance, and so does their work") {
  for (const Model& model : {chain(), tumbler()}) {
    const Outcome exact = fixed_run(model, "dop853", 0.001, 1000);
    for (const std::string method : {"dopri5", "dop853"}) {
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

TEST_CASE("the tolerance holds in chains so small and light that no momentum reaches it") {
  for (const double scale : {1.0, 5e-3}) {
    const Model model = chain(scale);
    const double until = 0.4 * std::sqrt(scale);
    Tree tree(model);
    const Outcome exact = fixed_run(model, "dop853", until / 800, 800);
    const Outcome found = run_of(model, {.method = "dopri5", .step = 1e-5, .rtol = 1e-8, .atol = 1e-8}, until);
    Simulation run(model, {.method = "dopri5", .step = 1e-5, .rtol = 1e-8, .atol = 1e-8});
    REQUIRE(run.run_until(until) == Status::ok);
    double largest = 0;
    for (int b = 0; b < model.size(); ++b)
      for (const double p : run.world().joint({b}).p) largest = std::max(largest, std::abs(p));
    MESSAGE("largest momentum " << largest << ", error " << apart(found, exact));
    if (scale < 1) CHECK(largest < 1e-8);
    CHECK(apart(found, exact) < 1e-6);
  }
}

TEST_CASE("dense output is of order 4 for dopri5, of order 7 for dop853") {
  const struct {
    std::string name;
    double order, h[2];
    int evaluations;
  } methods[] = {{"dopri5", 4, {0.01, 0.02}, 0}, {"dop853", 7, {0.04, 0.2}, 3}};
  int number = 0;
  for (const Model& model : {chain(), tumbler()}) {
    Tree tree(model);
    const State start = start_state(model, tree);
    Workspace<double> workspace(tree), elsewhere(tree);
    Evaluator evaluate(tree, workspace), other(tree, elsewhere);
    EnergyLedger ledger;
    std::vector<double> q(static_cast<std::size_t>(tree.nq())), p(static_cast<std::size_t>(tree.nv()));
    for (const auto& m : methods) {
      const auto method = make_integrator(m.name, tree), reference = make_integrator("dop853", tree);
      CHECK_FALSE(method->interpolate(evaluate, 0.5, q.data(), p.data()));
      const auto error = [&](double h) {
        State end = start;
        evaluate(end);
        REQUIRE(method->step(evaluate, end, ledger, h));
        const long before = evaluate.count;
        double most = 0;
        for (const double theta : {0.0, 0.1, 0.3, 0.6, 0.85, 1.0}) {
          REQUIRE(method->interpolate(evaluate, theta, q.data(), p.data()));
          State exact = start;
          for (int i = 0; i < 16 && theta > 0; ++i) {
            other(exact);
            REQUIRE(reference->step(other, exact, ledger, theta * h / 16));
          }
          for (std::size_t i = 0; i < q.size(); ++i) most = std::max(most, std::abs(q[i] - exact.q()[i]));
          for (std::size_t i = 0; i < p.size(); ++i) most = std::max(most, std::abs(p[i] - exact.p()[i]));
        }
        CHECK(evaluate.count == before + m.evaluations);  // once per step, and only if it is requested
        CHECK(workspace.evaluated == end.stamp());
        return most;
      };
      const double h = m.h[number], coarse = error(h), fine = error(h / 2);
      MESSAGE(m.name << ", " << model.size() << " bodies: error " << fine << ", local slope " << std::log2(coarse / fine));
      CHECK(std::log2(coarse / fine) > m.order + 0.5);
    }
    ++number;
  }
}

TEST_CASE("steps of adaptive methods end on events, restart there, and the methods agree through breaks") {
  std::vector<double> ends[2];
  for (const int i : {0, 1}) {
    const double tolerance = i == 0 ? 1e-10 : 1e-12;
    Simulation run(chain(), {.method = i == 0 ? "dopri5" : "dop853", .rtol = tolerance, .atol = tolerance});
    run.at(0.1234567).then(break_joint("2"));
    run.at(0.3).then(lock("1"));
    REQUIRE(run.run_until(0.5) == Status::ok);
    CHECK(run.time() == 0.5);
    REQUIRE(run.events().size() == 2);
    CHECK(run.events()[0].time == 0.1234567);
    CHECK(run.events()[1].time == 0.3);
    CHECK(std::abs(run.energy().error) < 1e-8);
    for (int b = 0; b < 4; ++b)
      for (const double q : run.world().joint({b}).q) ends[i].push_back(q);
  }
  for (std::size_t i = 0; i < ends[0].size(); ++i) check_near(ends[0][i], ends[1][i], 1e-8, "coordinate");
}

TEST_CASE("methods keep their order through events between their steps") {
  const auto end = [](const std::string& method, double h, double tolerance) {
    Simulation run(chain(),
                   {.method = method, .step = h, .rtol = tolerance, .atol = tolerance, .max_step = tolerance > 1 ? h : HUGE_VAL});
    run.at(0.1234567).then(break_joint("2"));
    run.at(0.2111111).then(lock("1"));
    REQUIRE(run.run_until(0.4) == Status::ok);
    Outcome found;
    for (int b = 0; b < 4; ++b)
      for (const double q : run.world().joint({b}).q) found.values.push_back(q);
    return found;
  };
  const Outcome exact = end("dop853", 1e-3, 1e-13);
  const struct {
    std::string name;
    double order, h;
  } methods[] = {{"midpoint", 2, 0.004}, {"rk4", 4, 0.004}, {"dopri5", 5, 0.01}};
  for (const auto& m : methods) {
    const double error[2] = {apart(end(m.name, m.h, 1e6), exact), apart(end(m.name, m.h / 2, 1e6), exact)};
    const double slope = std::log2(error[0] / error[1]);
    MESSAGE(m.name << " through events: error " << error[1] << ", slope " << slope);
    CHECK(slope > m.order - 0.4);
  }
}

TEST_CASE("stops are hit at the times of the closed form, however long the steps of an adaptive method") {
  Model model;
  model.add(
      {.name = "ball", .mass = 2, .inertia = diagonal(0.1), .joint = Prismatic{.limits = {.lower = -0.5, .restitution = 0.6}}});
  for (const std::string method : {"dopri5", "dop853"}) {
    Simulation run(model, {.method = method});
    REQUIRE(run.run_until(1.5) == Status::ok);
    double t = std::sqrt(2 * 0.5 / 9.81), v = 9.81 * t;
    REQUIRE(run.events().size() >= 5);
    for (std::size_t i = 0; i < 4; ++i) {
      check_near(run.events()[i].time, t, 2e-9, "instant of an impact");
      v *= 0.6;
      t += 2 * v / 9.81;
    }
  }
}

TEST_CASE("an undone run of an adaptive method repeats the same bits") {
  for (const std::string method : {"dopri5", "dop853", "midpoint"}) {
    Simulation run(chain(), {.method = method});
    REQUIRE(run.run_until(0.1) == Status::ok);
    const SimulationSnapshot then = run.snapshot();
    Simulation other = run.branch();
    REQUIRE(run.run_until(0.3) == Status::ok);
    const std::vector<double> end(run.world().joint({2}).q.begin(), run.world().joint({2}).q.end());
    run.restore(then);
    for (Simulation* again : {&run, &other}) {
      REQUIRE(again->run_until(0.3) == Status::ok);
      for (std::size_t i = 0; i < end.size(); ++i) CHECK(again->world().joint({2}).q[i] == end[i]);
    }
  }
}

TEST_CASE("adaptive methods against closed forms: the pendulum over 200 s, the torque-free body") {
  const auto forms = reference("closed_forms.json");
  for (const std::string method : {"dopri5", "dop853"}) {
    const double tolerance = method == "dopri5" ? 1e-11 : 1e-12;
    Model pendulum({.gravity = {0, -9.81, 0}});
    pendulum.add({.name = "p", .mass = 1, .com = {0, -1, 0}, .joint = joint_of(Kind::revolute), .q = 90 * degree});
    Simulation swing(pendulum, {.method = method, .rtol = tolerance, .atol = tolerance});
    int rows = 0;
    for (const auto& row : forms["A01_simple_pendulum"]["values"]) {
      if (row["t"] > 200.0) break;
      REQUIRE(swing.run_until(row["t"]) == Status::ok);
      check_near(swing.world().joint({0}).q[0], row["theta"], 1e-7, "angle");
      ++rows;
    }
    CHECK(rows > 2);
    Model body({.gravity = {0, 0, 0}});
    body.add({.name = "b", .mass = 1, .inertia = diagonal(1, 2, 3), .joint = joint_of(Kind::free), .v = {0, 0, 0, 1, 0, 1}});
    Simulation spin(body, {.method = method, .rtol = tolerance, .atol = tolerance});
    for (const auto& row : forms["torque_free_rigid_body"]["values"]) {
      REQUIRE(spin.run_until(row["t"]) == Status::ok);
      const auto v = spin.world().joint({0}).v;
      check_near(Vec3{v[3], v[4], v[5]}, vec3_of(row["w"]), 1e-8, "angular velocity");
    }
  }
}

TEST_CASE("the midpoint rule keeps the energy of holonomic chains; its error does not grow") {
  Model model({.gravity = {0, -9.81, 0}});
  BodyId last = ground;
  for (int k = 0; k < 2; ++k)
    last = model.add({.name = std::to_string(k),
                      .mass = 1,
                      .com = {0.5, 0, 0},
                      .inertia = diagonal(0.001, 1.0 / 12, 1.0 / 12),
                      .parent = last,
                      .at = {k == 0 ? 0.0 : 1.0, 0, 0},
                      .joint = joint_of(Kind::revolute),
                      .q = k == 0 ? -0.9 : 0.5});
  Simulation run(model, {.method = "midpoint", .step = 0.01});
  double worst[2] = {};
  for (int i = 1; i <= 400; ++i) {
    REQUIRE(run.run_until(0.1 * i) == Status::ok);
    double& w = worst[i > 200];
    w = std::max(w, std::abs(run.energy().error));
  }
  MESSAGE("energy error of the halves: " << worst[0] << ", " << worst[1] << " J");
  CHECK(worst[0] < 5e-3);
  CHECK(worst[1] < 1.3 * worst[0]);
}

TEST_CASE("a tolerance that cannot be met ends the run with a message") {
  // Every step would have to be shorter than the clock's resolution.
  Model model({.gravity = {0, 0, 0}});
  model.add({.name = "b", .mass = 1, .inertia = diagonal(1), .joint = Revolute{.damping = 1e-3}, .v = 1e5});
  Simulation run(model, {.method = "dopri5", .step = 1e-3, .rtol = 1e-30, .atol = 1e-30});
  const RunResult ended = run.run_until(1);
  CHECK((ended == Status::diverged || ended == Status::stalled));  // by round-off: no step is good, or only tiny ones are
  CHECK(ended.reason.find("larger") != std::string::npos);
  CHECK(ended.reason.find("rtol and atol") != std::string::npos);
}
