// Closed loops in momenta: rates, steps and runs against those in velocities, which loops_test.cpp checks against the equations
// of motion, and against derivatives by differences.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/dynamics/loops/loop_momenta.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/loop_measures.hpp>
#include <tests/oracle/loop_rows.hpp>

using namespace momentree;
using namespace momentree::oracle;

TEST_CASE("loops in momenta: rates of 2000 random mechanisms, for any representative of the momenta") {
  int compared = 0, driven = 0, skipped = 0;  // besides motions that the loops do not allow
  constexpr double conditioned = 1e-9;        // A squares the ratio of the rows' singular values, which is 1e-3 or more
  double worst = 0, worst_rate = 0;
  for (std::uint64_t seed = 0; compared < 2000; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.drives = seed % 2 == 1;
    const Model model = with_loops(seed, options, seed % 4 > 1);
    if (model.loops().empty() || dofs(model) == 0 || check_assembly(model)) continue;
    const World velocities(model, Variables::velocities);
    const World momenta(model, Variables::momenta, Variables::momenta);
    const Tree& tree = momenta.tree();
    const int n = tree.nv(), nq = tree.nq();
    REQUIRE(momenta.state().variables() == Variables::momenta);
    driven += tree.joints_with().motions.empty() ? 0 : 1;
    const Vector u = as_vector(velocities.v()), a = as_vector(velocities.a()), p = as_vector(momenta.p());
    const double speed = 1 + largest(u), noise = 1e-15 * amplification(velocities, p);
    // Rounding of the momenta alone moves light parts by more than is asked for here, or rows are nearly dependent.
    if (noise > 1e-12 || nearly_singular(rows_of(velocities))) {
      ++skipped;
      continue;
    }
    ++compared;
    CHECK(std::equal(velocities.state().q().begin(), velocities.state().q().end(), momenta.state().q().begin()));
    worst = std::max(worst, largest(as_vector(momenta.v()) - u) / speed);
    CHECK(largest(as_vector(momenta.v()) - u) < conditioned * speed);
    const double steep = options.drives ? 100 : 1;  // friction of drives changes fast with velocity
    CHECK(largest(as_vector(momenta.a()) - a) < steep * 1e-10 * (1 + largest(a)) * speed);
    double loads = 1;  // which ṗ is a sum of
    for (const JointId loop : velocities.loops()) {
      const Wrench load = velocities.joint_forces(loop).reaction;
      loads += norm(load.force) + norm(load.torque);
    }
    const Vector pdot = as_vector(velocities.pdot());
    CHECK(largest(as_vector(momenta.pdot()) - pdot) < steep * 1e-10 * (loads + largest(pdot)) * speed);
    CHECK(momenta.loop_status().rank == velocities.loop_status().rank);

    // σ of any size; then du/dt along q̇ and ṗ* must be u̇.
    Workspace<double> workspace(tree);
    Prng random(seed + 77);
    evaluate_state_with_loops(tree, momenta.state(), workspace);
    const Power power = workspace.power;
    std::vector<double> impulses(static_cast<std::size_t>(tree.loops().rows));
    for (double& x : impulses) x = random.uniform(-1, 1) * largest(p);
    const double* const q = momenta.state().q().data();
    detail::sum_loop_momenta(tree, q, workspace, impulses.data());
    std::vector<double> other(momenta.p().begin(), momenta.p().end());
    const std::span<const LoopStop> stops = tree.loops().stops;
    for (std::size_t s = 0; s < stops.size(); ++s) {
      const int b = stops[s].body;
      if (s == 0 || stops[s - 1].body != b)
        absorb(tree, b, joint_state(tree, q, workspace, b), workspace.loops->momenta[static_cast<std::size_t>(b)], -1,
               other.data());
    }
    evaluate_with_loops(tree, momenta.time(), q, other.data(), workspace, LoopRows::choose);
    const Vector moved = as_vector(workspace.v.get(), n);
    const double rounding = 1e-15 * amplification(velocities, as_vector(other.data(), n));
    CHECK(largest(moved - u) < conditioned * speed + 100 * rounding);
    CHECK(largest(as_vector(workspace.qdot.get(), nq) - as_vector(velocities.qdot())) < conditioned * speed + 100 * rounding);
    const double scale = 1 + std::fabs(power.dissipated) + std::fabs(power.work);
    CHECK(std::fabs(workspace.power.dissipated - power.dissipated) < steep * 1e-9 * scale);
    CHECK(std::fabs(workspace.power.work - power.work) < steep * 1e-9 * scale);
    const Vector qdot = as_vector(workspace.qdot.get(), nq), rate = as_vector(workspace.pdot.get(), n);
    const Vector q0 = as_vector(q, nq), p0 = as_vector(other.data(), n);
    const auto velocity = [&](double t) -> Vector {
      const Vector at = q0 + t * qdot, now = p0 + t * rate;
      find_velocities_with_loops(tree, at.data(), now.data(), workspace);
      return as_vector(workspace.v.get(), n);
    };
    const double step = 2e-3 / (speed + std::sqrt(1 + largest(a)));
    const Vector found = derivative(velocity, step);
    const double off = largest(found - a) / (1 + largest(a) + speed * speed);
    worst_rate = std::max(worst_rate, off - 1e3 * rounding / step);
    CHECK(off < 1e-7 + 1e3 * rounding / step);
  }
  MESSAGE("velocities " << worst << ", rates " << worst_rate << ", driven " << driven << ", skipped " << skipped);
  CHECK(driven > 300);
  CHECK(skipped < 1000);
}

namespace {

/// A free ring of five rods with ball joints.
Model ring() {
  Model model({.gravity = {}});
  Prng random(5);
  const int n = 5;
  BodyId last{};
  for (int i = 0; i < n; ++i) {
    BodySpec rod{.name = "rod" + std::to_string(i), .mass = 1, .com = {0.5, 0, 0}, .inertia = diagonal(0.01, 0.1, 0.1)};
    rod.joint.kind = i == 0 ? Kind::free : Kind::ball;
    rod.parent = i == 0 ? ground : last;
    rod.at.position = {i == 0 ? 0.0 : 1.0, 0, 0};
    if (i > 0) rod.q = Values{std::cos(0.2 * 3.14159265358979), 0, 0, std::sin(0.2 * 3.14159265358979)};
    rod.v = random_velocities(random, rod.joint.kind);
    last = model.add(rod);
  }
  LoopSpec clasp;
  clasp.name = "clasp", clasp.body = last, clasp.to = {0}, clasp.joint.kind = Kind::ball;
  clasp.child_at.position = {1, 0, 0};
  model.add_loop(clasp);
  return model;
}

}  // namespace

TEST_CASE("loops in momenta: runs of every method go where those in velocities go") {
  int runs = 0, stiff = 0;
  for (std::uint64_t seed = 0; runs < 120; ++seed) {
    CAPTURE(seed);
    RandomTreeOptions options;
    options.parameters = seed % 3 != 0, options.conservative = seed % 3 == 1, options.several_mechanisms = seed % 2 == 0;
    const Model model = with_loops(seed, options, seed % 4 == 2);
    if (model.loops().empty() || dofs(model) == 0 || check_assembly(model)) continue;
    const World start(model, Variables::velocities);
    if (amplification(start, as_vector(start.p())) > 1e3) continue;
    const double until = 0.1;
    Simulation exact = run_of(model, "dop853", Variables::velocities);
    if (exact.run_until(until).status != Status::ok || fastest(exact.world()) > 20) {
      ++stiff;
      continue;
    }
    ++runs;
    const double speed = fastest(exact.world());
    for (const char* method : {"dop853", "dopri5"}) {
      Simulation sim = run_of(model, method, Variables::momenta);
      REQUIRE(sim.run_until(until).status == Status::ok);
      CHECK(sim.world().state().variables() == Variables::momenta);
      CHECK_MESSAGE(apart(exact.world(), sim.world()) < 2e-8 * speed * speed, method);
      const EnergyBalance balance = sim.energy(), other = exact.energy();
      const double scale = 1 + std::fabs(balance.initial) + balance.largest_kinetic;
      CHECK(std::fabs(balance.dissipated - other.dissipated) < 1e-7 * scale);
      CHECK(std::fabs(balance.work - other.work) < 1e-7 * scale);
      CHECK(std::fabs(balance.error) < 1e-7 * scale);
      CHECK(sim.world().loop_status().residual < 1e-12);
    }
  }
  MESSAGE("too fast: " << stiff);
}

TEST_CASE("loops in momenta: the order of rk4 and midpoint, and a ring keeps its momenta") {
  const Model model = ring();
  Simulation exact = run_of(model, "dop853", Variables::velocities);
  REQUIRE(exact.run_until(1).status == Status::ok);
  for (const auto& [method, order] : {std::pair{"rk4", 4}, std::pair{"midpoint", 2}}) {
    CAPTURE(method);
    double error[2], drift[2];
    for (int k = 0; k < 2; ++k) {
      Simulation sim = run_of(model, method, Variables::momenta, k == 0 ? 0.02 : 0.01);
      const Totals before = sim.world().totals();
      REQUIRE(sim.run_until(1).status == Status::ok);
      const Totals after = sim.world().totals();
      error[k] = apart(exact.world(), sim.world());
      drift[k] = norm(after.linear - before.linear) + norm(after.angular - before.angular);
      CHECK(sim.world().loop_status().residual < 1e-12);
    }
    MESSAGE(method << ": errors " << error[0] << " " << error[1] << ", momenta " << drift[0] << " " << drift[1]);
    CHECK(error[1] < error[0] * std::pow(0.5, order) * 1.6);
    CHECK((drift[1] < 1e-12 || drift[1] < drift[0] * std::pow(0.5, order) * 1.6));
  }
}
