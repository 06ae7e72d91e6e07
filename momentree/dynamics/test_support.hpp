#pragma once
// Random links and states, and the difference of two results: for tests of the implementations of an evaluation.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/model/model.hpp>

namespace momentree::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(engine_()) / 4294967295.0); }
  bool chance(double p) { return between(0, 1) < p; }
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }
  Vec3 vector(double size) {
    const double x = between(-size, size), y = between(-size, size), z = between(-size, size);
    return {x, y, z};
  }

 private:
  std::mt19937 engine_;
};

/// Links as in typical machines: twists of 0, 90° and any angle, zero and nonzero lengths; some with a general placement.
inline Pose random_place(Random& random) {
  if (random.chance(0.15)) {
    const Vec3 r = random.vector(0.4), e = random.vector(0.8);
    return {r, normalized(Quat{1, e.x, e.y, e.z})};
  }
  const double alphas[] = {0, std::acos(0.0), std::acos(0.0), -std::acos(0.0), 0.05, random.between(-2, 2)};
  const double alpha = alphas[random.below(6)];
  const double a = random.chance(0.3) ? 0 : random.between(-0.4, 0.4), d = random.chance(0.4) ? 0 : random.between(-0.4, 0.4);
  const double aside = alpha == 0.05 ? 0.3 : 0;  // the common normal is far away
  return {{a, aside - d * std::sin(alpha), d * std::cos(alpha)}, from_axis_angle(x_axis, alpha)};
}

/// A random state: all coordinates except those of joints with a quaternion, and the momenta of random velocities.
inline void put_at_random(const Tree& tree, State& state, Random& random) {
  std::vector<double> q(state.q().begin(), state.q().end()), p(state.p().size()), v(state.p().size());
  for (const int b : tree.order())
    if (info(tree.kind(b)).nq == info(tree.kind(b)).nv)
      for (int i = 0; i < info(tree.kind(b)).nq; ++i) q[static_cast<std::size_t>(tree.first_q(b) + i)] = random.between(-3, 3);
  for (double& x : v) x = random.between(-1, 1);
  project_momentum(tree, q.data(), v.data(), p.data());
  const State::Edit edit = state.edit();
  std::copy(q.begin(), q.end(), edit.q.begin());
  std::copy(p.begin(), p.end(), edit.p.begin());
}
/// Lets the passes that keep results use the generic functions of all kinds.
inline void use_generic_functions(const Tree& tree, Workspace<double>& workspace) {
  for (const Passes passes : {Passes::momenta, Passes::velocities, Passes::rates, Passes::solutions}) {
    StepScalar scalar = detail::double_steps(passes);
    scalar.width = StepWidth::none;
    workspace.table(passes) = detail::make_step_table(scalar, tree.bodies());
  }
}
/// Fills the buffers of the passes with NaN, so that anything read before it is written shows up.
inline void poison(const Tree& tree, Workspace<double>& workspace) {
  const auto bodies = static_cast<std::size_t>(tree.bodies());
  const auto fill = [](auto* first, std::size_t count) { std::memset(static_cast<void*>(first), 0xff, count * sizeof(*first)); };
  fill(workspace.records.get(), tree.tables().record_capacity);
  fill(workspace.child_sums.get(), bodies), fill(workspace.parent_states.get(), bodies), fill(workspace.motions.get(), bodies);
  fill(workspace.child_wrenches.get(), bodies), fill(workspace.parent_accelerations.get(), bodies);
  fill(workspace.biases.get(), bodies), fill(workspace.inboard_accelerations.get(), bodies);
  fill(workspace.reduced_bias_wrenches.get(), bodies);
  fill(workspace.step_records.get(), tree.tables().record_capacity), workspace.step_records_of = 0;
}

/// Largest difference relative to the largest number; infinite if any number is not finite.
inline double difference(const double* a, const double* b, int n) {
  double x = 0, largest = 0;
  for (int i = 0; i < n; ++i) {
    if (!std::isfinite(a[i]) || !std::isfinite(b[i])) return std::numeric_limits<double>::infinity();
    x = std::max(x, std::fabs(a[i] - b[i]));
    largest = std::max({largest, std::fabs(a[i]), std::fabs(b[i])});
  }
  return x == 0 ? 0 : x / largest;
}

}  // namespace momentree::test
