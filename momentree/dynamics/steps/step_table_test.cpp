// Stages by a table of steps against the generic functions, in random trees and through topology changes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/steps/step_library.hpp>
#include <momentree/dynamics/steps/step_table.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/test_support.hpp>

namespace momentree {
namespace {

using namespace test;

/// Links as robots have them: right angles, axes that meet, offsets along one axis, masses without products of inertia, welds.
Model robot(Random& random, bool parameters) {
  Model model({.gravity = {0, 0, random.chance(0.5) ? -9.81 : 0.0}});
  const int bodies = random.chance(0.03) ? 300 : 1 + random.below(20);  // so many have more steps than one cache holds
  const auto length = [&] { return random.chance(0.5) ? 0.0 : random.between(-0.5, 0.5); };
  for (int k = 0; k < bodies; ++k) {
    BodySpec body{.name = "b" + std::to_string(k), .mass = random.between(0.5, 2)};
    body.com = {length(), length(), length()};
    body.inertia = diagonal(random.between(0.06, 0.1), random.between(0.06, 0.1), random.between(0.06, 0.1));
    const int outer = random.chance(0.7) ? k - 1 : random.below(k + 1) - 1;
    body.parent = outer < 0 ? ground : BodyId{outer};
    const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, 0, 0.8}};
    const double angles[] = {0, std::numbers::pi / 2, -std::numbers::pi / 2, std::numbers::pi, random.between(-3, 3)};
    body.at = {{length(), length(), length()}, from_axis_angle(axes[random.below(4)], angles[random.below(5)])};
    const Vec3 axis = axes[random.below(4)];
    const Values armature{parameters && random.chance(0.3) ? 0.05 : 0.0};
    switch (random.below(12)) {
      case 0: body.joint = Prismatic{.axis = axis, .armature = armature}; break;
      case 1: body.joint = Helical{.axis = axis, .pitch = 0.2}; break;
      case 2: body.joint = Cylindrical{.axis = axis}; break;
      case 3: body.joint = Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}}; break;
      case 4: body.joint = Ball{}; break;
      case 5: body.joint = Planar{}; break;
      case 6: body.joint = Free{}; break;
      case 7: body.joint = Weld{}; break;
      default: body.joint = Revolute{.axis = axis, .armature = armature}; break;
    }
    model.add(body);
  }
  return model;
}

double largest(const double* x, int n) {
  double all = 1;
  for (int i = 0; i < n; ++i) all = std::max(all, std::abs(x[i]));
  return all;
}

/// A stage by the table against passes that keep what others read, by the generic functions.
double error_of_stage(const Tree& tree, const State& state, Workspace<double>& table, Workspace<double>& generic) {
  const double *q = state.q().data(), *u = state.u().data();
  const Motion<double> ground_acceleration{-tree.gravity(), {}};
  poison(tree, table);
  sweep_velocities<double, false>(tree, q, u, table);
  sweep_velocities<double, true>(tree, q, u, generic);
  for (int i = 0; i < tree.nv(); ++i) table.a[i] = generic.a[i] = std::sin(1.0 + i);
  for (const int b : tree.order())
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if ((tree.link(b).locked >> i & 1u) != 0) table.a[tree.first_p(b) + i] = generic.a[tree.first_p(b) + i] = 0;
  solve_accelerations<double, false>(tree, q, table, ground_acceleration);
  solve_accelerations<double, true>(tree, q, generic, ground_acceleration);
  const double scale = largest(generic.a.get(), tree.nv());
  return std::max(difference(generic.a.get(), table.a.get(), tree.nv()) / scale,
                  difference(generic.qdot.get(), table.qdot.get(), tree.nq()));
}

}  // namespace

TEST_CASE("steps: where the processor runs it there is machine code, unless the environment forbids it") {
  const char* const wanted = std::getenv("MOMENTREE_MACHINE");
  const bool expected = machine::native_target(1, 8).has_value() && (wanted == nullptr || std::string(wanted) != "0");
#ifdef __linux__
  CHECK(StepLibrary::of_process().available(StepWidth::one) == expected);
#else
  CHECK_FALSE((StepLibrary::of_process().available(StepWidth::one) && !expected));
#endif
}

TEST_CASE("steps: stages equal those of the generic functions, in robots and through their topology changes") {
  Random random(5);
  double worst = 0;
  for (int round = 0; round < 3000; ++round) {
    const Model model = robot(random, round % 2 == 1);
    Tree tree = compile(model);
    State state(tree);
    Workspace<double> changes(tree), table(tree), generic(tree);
    use_generic_functions(tree, generic);
    for (int k = 0; k < 4; ++k) {
      put_at_random(tree, state, random);
      State u(tree, Variables::velocities);
      std::vector<double> speeds(static_cast<std::size_t>(tree.nv()));
      for (double& speed : speeds) speed = random.between(-1, 1);
      for (const int b : tree.order())
        for (int i = 0; i < info(tree.kind(b)).nv; ++i)
          if ((tree.link(b).locked >> i & 1u) != 0) speeds[static_cast<std::size_t>(tree.first_p(b) + i)] = 0;
      u.assign(0, state.q(), speeds, tree);
      const double error = error_of_stage(tree, u, table, generic);
      CHECK_MESSAGE(error < 1e-9, "round ", round, ", change ", k);
      worst = std::max(worst, error);
      change_at_random(tree, state, changes, random, 0.5);
      if (!random.chance(0.3)) continue;
      forward_dynamics(tree, state, changes);
      apply(Lock{{random.below(tree.bodies())}, static_cast<unsigned>(1 + random.below(7))}, tree, state, changes);
    }
  }
  MESSAGE("largest error ", worst);
}

namespace {

// The largest difference beside the largest number, or 1: without gravity some are zero but for round-off.
double apart(const double* a, const double* b, int n) {
  double off = 0, most = 1;
  for (int i = 0; i < n; ++i) {
    if (!std::isfinite(a[i]) || !std::isfinite(b[i])) return std::numeric_limits<double>::infinity();
    off = std::max(off, std::fabs(a[i] - b[i])), most = std::max(most, std::fabs(b[i]));
  }
  return off / most;
}
// Of numbers that two workspaces have for every body, the largest difference beside the largest number. Numbers of joints that
// no evaluation writes, and those of the record that its kind does not use, are left out.
template <class V>
double difference_of(const Tree& tree, const V* a, const V* b) {
  constexpr int n = sizeof(V) / sizeof(double);
  std::vector<double> one, other;
  for (const int body : tree.order())
    for (int i = 0; i < n; ++i) {
      one.push_back(reinterpret_cast<const double*>(a + body)[i]);
      other.push_back(reinterpret_cast<const double*>(b + body)[i]);
    }
  return apart(one.data(), other.data(), static_cast<int>(one.size()));
}
/// Of the numbers in records that others read: M̂, which may be zero but for round-off, with those of all bodies.
double difference_of_records(const Tree& tree, const Workspace<double>& a, const Workspace<double>& b) {
  std::array<std::vector<double>, 4> one, other;
  const UncheckedTree all(tree);
  for (const int body : tree.order())
    dispatch_kernels(tree.kind(body), tree.variant(body), [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (requires(typename K::template Record<double> w) { w.G; }) {
        const auto add = [](const auto& w, auto& to) {
          const auto put = [](const auto& x, auto& numbers) {
            const auto* const first = reinterpret_cast<const double*>(&x);
            numbers.insert(numbers.end(), first, first + sizeof x / sizeof(double));
          };
          put(w.M, to[0]), put(w.G, to[1]), put(w.u0, to[2]), put(w.Mj.inverse, to[3]);
        };
        add(a.record<K>(all, body), one), add(b.record<K>(all, body), other);
      }
    });
  double most = 0;
  for (std::size_t i = 0; i < one.size(); ++i)
    most = std::max(most, apart(one[i].data(), other[i].data(), static_cast<int>(one[i].size())));
  return most;
}
double difference_of_kept(const Tree& tree, const Workspace<double>& a, const Workspace<double>& b, bool accelerations) {
  double most = std::max(difference_of_records(tree, a, b), apart(a.v.get(), b.v.get(), tree.nv()));
  most = std::max(most, apart(a.qdot.get(), b.qdot.get(), tree.nq()));
  if (!accelerations)
    return std::max({most, apart(a.pdot.get(), b.pdot.get(), tree.nv()), difference_of(tree, a.motions.get(), b.motions.get())});
  most = std::max(most, apart(a.a.get(), b.a.get(), tree.nv()));
  most = std::max(most, difference_of(tree, a.inboard_accelerations.get(), b.inboard_accelerations.get()));
  return std::max(most, difference_of(tree, a.reduced_bias_wrenches.get(), b.reduced_bias_wrenches.get()));
}

}  // namespace

TEST_CASE("steps: passes that keep results equal the generic functions, in robots and through their topology changes") {
  Random random(8);
  double worst = 0;
  for (int round = 0; round < 1500; ++round) {
    const Model model = robot(random, round % 2 == 1);
    Tree tree = compile(model);
    State state(tree);
    Workspace<double> changes(tree), steps(tree), generic(tree);
    use_generic_functions(tree, generic);
    for (int k = 0; k < 4; ++k) {
      put_at_random(tree, state, random);
      const double *q = state.q().data(), *p = state.p().data();
      poison(tree, steps);
      const auto both = [&](const auto& f) { f(steps), f(generic); };
      const auto compare = [&](const char* what, bool accelerations) {
        const double off = difference_of_kept(tree, steps, generic, accelerations);
        CHECK_MESSAGE(off < 1e-9, std::string(what), ", round ", round, ", change ", k, ": ", off);
        worst = std::max(worst, off);
      };
      const auto forces = [&](Workspace<double>& w) {
        for (const int b : tree.order())
          for (int i = 0; i < info(tree.kind(b)).nv; ++i)
            w.a[tree.first_p(b) + i] = (tree.link(b).locked >> i & 1u) == 0 ? std::sin(1.0 + tree.first_p(b) + i) : 0.0;
      };
      both([&](auto& w) { evaluate_motions(tree, q, p, w); });
      compare("momenta", false);
      both([&](auto& w) { forces(w), evaluate_accelerations(tree, q, w); });
      compare("rates", true);
      both([&](auto& w) { forces(w), solve_with_factors(tree, q, w, w.a.get()); });
      const double off = apart(steps.a.get(), generic.a.get(), tree.nv());
      CHECK(off < 1e-9);
      const std::vector<double> u(generic.v.get(), generic.v.get() + tree.nv());
      poison(tree, steps);
      both([&](auto& w) {
        sweep_velocities<double, true>(tree, q, u.data(), w), forces(w);
        solve_accelerations<double, true>(tree, q, w, {-tree.gravity(), {}});
      });
      compare("velocities", true);
      change_at_random(tree, state, changes, random, 0.5);
      if (!random.chance(0.3)) continue;
      forward_dynamics(tree, state, changes);
      apply(Lock{{random.below(tree.bodies())}, static_cast<unsigned>(1 + random.below(7))}, tree, state, changes);
    }
  }
  MESSAGE("largest difference ", worst);
}

TEST_CASE("steps: a topology that comes back has the same bits") {
  Random random(6);
  for (int round = 0; round < 200; ++round) {
    const Model model = robot(random, true);
    const Tree tree = compile(model);
    State state(tree, Variables::velocities);
    Workspace<double> one(tree), other(tree);
    const auto stage = [&](const Tree& of, const State& at, Workspace<double>& workspace) {
      evaluate_velocity_stage(of, 0, at.q().data(), at.u().data(), workspace);
      return std::vector<double>(workspace.a.get(), workspace.a.get() + of.nv());
    };
    const std::vector<double> before = stage(tree, state, one);
    Tree changed = tree;
    State moved(changed);
    Workspace<double> changes(changed);
    change_at_random(changed, moved, changes, random, 0.5);
    State away(changed, Variables::velocities);
    stage(changed, away, one);
    CHECK(stage(tree, state, one) == before);
    CHECK(stage(tree, state, other) == before);
  }
}

TEST_CASE("steps: many threads make the same steps at once") {
  Random random(7);
  std::vector<Model> models;
  for (int k = 0; k < 20; ++k) models.push_back(robot(random, true));
  std::vector<std::vector<double>> results(4);
  std::vector<std::thread> threads;
  for (auto& result : results)
    threads.emplace_back([&] {
      for (const Model& model : models) {
        const Tree tree = compile(model);
        const State state(tree, Variables::velocities);
        Workspace<double> workspace(tree);
        evaluate_velocity_stage(tree, 0, state.q().data(), state.u().data(), workspace);
        result.insert(result.end(), workspace.a.get(), workspace.a.get() + tree.nv());
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const auto& result : results) CHECK(result == results.front());
}

}  // namespace momentree
