// The integration method for strongly damped joints: closed forms, order, stability for arbitrarily strong damping, energy
// ledger.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

/// A chain with revolute, ball and universal joints, one of them with an armature, in gravity; damping c on every DoF.
Model chain(double c) {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < 5; ++k) {
    BodySpec link{.name = std::to_string(k),
                  .mass = 1,
                  .com = {0.2, 0.02, -0.01},
                  .inertia = {0.01, 0.03, 0.032, 0.001, -0.002, 0.0015},
                  .parent = last,
                  .at = {k == 0 ? 0.0 : 0.4, 0, 0}};
    if (k == 1)
      link.joint = Ball{.damping = c};
    else if (k == 3)
      link.joint = Universal{.axis = x_axis, .axis2 = y_axis, .damping = c};
    else
      link.joint = Revolute{.axis = k == 2 ? x_axis : y_axis, .damping = c, .armature = k == 2 ? 0.02 : 0.0};
    last = model.add(link);
  }
  return model;
}

std::vector<double> placed(const Simulation& run) {
  std::vector<double> q;
  for (int b = 0; b < run.world().model().size(); ++b)
    for (const double x : run.world().joint({b}).q) q.push_back(x);
  return q;
}
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::fabs(a[i] - b[i]));
  return most;
}
std::vector<double> end_of(const Model& model, const Integration& how, double until) {
  Simulation run(model, how);
  REQUIRE(run.run_until(until) == Status::ok);
  return placed(run);
}

}  // namespace

TEST_CASE("a rotor comes to rest as exp(-c t / I), to order 3, and so does the energy ledger") {
  for (const double rotor : {0.0, 0.4}) {
    double before[2] = {};
    for (const double step : {0.04, 0.02, 0.01}) {
      Model model({.gravity = {}});
      model.add(
          {.name = "b", .mass = 1, .inertia = diagonal(0.5), .joint = Revolute{.damping = 2.0, .armature = rotor}, .v = 3.0});
      Simulation run(model, {.method = "damped", .step = step});
      REQUIRE(run.run_until(1) == Status::ok);
      const double inertia = 0.5 + rotor, speed = 3 * std::exp(-2.0 / inertia);
      const double off[2] = {std::fabs(run.world().joint({0}).v[0] - speed),
                             std::fabs(run.energy().dissipated - 0.5 * inertia * (9 - speed * speed))};
      for (const int i : {0, 1}) {
        if (before[i] > 0) CHECK(std::log2(before[i] / off[i]) > 2.7);
        before[i] = off[i];
      }
    }
    CHECK(before[0] < 1e-5);
    CHECK(before[1] < 1e-4);
  }
}

TEST_CASE("however strong the damper: the body comes to rest, its energy is in the ledger") {
  for (const double c : {1e3, 1e6, 1e12}) {
    Model model({.gravity = {}});
    model.add({.name = "b", .mass = 1, .inertia = diagonal(0.5), .joint = Revolute{.damping = c}, .v = 3.0});
    Simulation run(model, {.method = "damped", .step = 0.1});
    REQUIRE(run.run_until(0.1) == Status::ok);
    CHECK(std::fabs(run.world().joint({0}).v[0]) < 50 / c);
    // The step does not resolve how it came to rest: its position error may be a part of v h.
    CHECK(std::fabs(run.world().joint({0}).q[0]) < 0.3 * 3 * 0.1);
    CHECK(std::fabs(run.energy().dissipated - 0.5 * 0.5 * 9) < 50 / c + 1e-12);
    const double rest = run.world().joint({0}).q[0];
    REQUIRE(run.run_until(0.5) == Status::ok);
    CHECK(std::fabs(run.world().joint({0}).q[0] - rest) < 50 / c);
  }
}

TEST_CASE("an overdamped chain is stable at steps at which rk4 diverges") {
  const Model model = chain(200);  // its fastest modes come to rest in a microsecond
  Simulation wild(model, {.method = "rk4", .step = 1e-3});
  CHECK(wild.run_until(1) == Status::diverged);
  const std::vector<double> exact = end_of(model, {.method = "damped", .step = 2.5e-4}, 2);
  double before = 0;
  for (const double step : {0.04, 0.02, 0.01}) {
    Simulation run(model, {.method = "damped", .step = step});
    REQUIRE(run.run_until(2) == Status::ok);
    const double off = apart(placed(run), exact);
    MESSAGE("overdamped, step " << step << ": error " << off << ", of the energy " << run.energy().error << " J of "
                                << run.energy().dissipated << (before > 0 ? std::log2(before / off) : 0));
    CHECK(off < 1e-3);
    if (before > 0) CHECK(off < before / 2);
    CHECK(std::fabs(run.energy().error) < 1e-3 * run.energy().dissipated);
    before = off;
  }
  // It agrees with the motion computed by an explicit method with sufficiently short steps.
  const Model mild = chain(2);
  CHECK(apart(end_of(mild, {.method = "damped", .step = 1e-3}, 0.5),
              end_of(mild, {.method = "dop853", .rtol = 1e-10, .atol = 1e-10}, 0.5)) < 1e-5);
}

TEST_CASE("order 3 in everything that moves") {
  const Model model = chain(0.3);
  const std::vector<double> exact = end_of(model, {.method = "dop853", .rtol = 1e-12, .atol = 1e-12}, 0.8);
  const double coarse = apart(end_of(model, {.method = "damped", .step = 4e-3}, 0.8), exact),
               fine = apart(end_of(model, {.method = "damped", .step = 2e-3}, 0.8), exact);
  MESSAGE("error " << fine << ", order " << std::log2(coarse / fine));
  CHECK(std::log2(coarse / fine) > 2.8);
}

TEST_CASE("a joint damped without bound is as good as locked, whatever it does to its neighbours") {
  const auto model = [](double c) {
    Model m;
    BodyId last = ground;
    for (int k = 0; k < 3; ++k)
      last = m.add({.name = std::to_string(k),
                    .mass = 1,
                    .com = {0.2, 0, 0},
                    .inertia = diagonal(0.01, 0.03, 0.03),
                    .parent = last,
                    .at = {k == 0 ? 0.0 : 0.4, 0, 0},
                    .joint = Revolute{.axis = y_axis, .damping = k == 1 ? c : 0.0},
                    .q = 0.3 * k});
    return m;
  };
  Simulation locked(model(0), {.step = 1e-3});
  locked.apply(lock("1"));
  REQUIRE(locked.run_until(0.6) == Status::ok);
  double before = HUGE_VAL;
  for (const double c : {1e3, 1e5, 1e8, 1e12}) {
    CAPTURE(c);
    Simulation run(model(c), {.method = "damped", .step = 1e-3});
    REQUIRE(run.run_until(0.6) == Status::ok);
    const double off = apart(placed(run), placed(locked));
    MESSAGE("damping " << c << ": " << off << " rad from the locked joint");
    CHECK(off < before);
    before = off;
  }
  CHECK(before < 1e-5);
}

TEST_CASE("with breaks, locks and new parameters during the run, the energy ledger closes") {
  Simulation run(chain(50), {.method = "damped", .step = 2e-3});
  run.at(0.1).then(lock("4"));
  run.at(0.2).then(break_joint("2"));
  run.at(0.3).then(set_parameters("0", {.damping = 500.0}));
  const SimulationSnapshot start = run.snapshot();
  REQUIRE(run.run_until(0.5) == Status::ok);
  REQUIRE(run.events().size() == 3);
  MESSAGE("energy error " << run.energy().error << " J, dissipated " << run.energy().dissipated);
  CHECK(std::fabs(run.energy().error) < 2e-3 * run.energy().dissipated);
  const std::vector<double> end = placed(run);
  run.restore(start);
  REQUIRE(run.run_until(0.5) == Status::ok);
  CHECK(placed(run) == end);
}
