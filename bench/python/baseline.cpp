// The C++ side of bench/python/overhead: the same operations, in nanoseconds, as JSON. Started by that script, so that both are
// measured in turns.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <momentree/batch/batch.hpp>
#include <momentree/momentree.hpp>

using namespace momentree;

namespace {

using Clock = std::chrono::steady_clock;

template <class Call>
double nanoseconds(int count, const Call& call) {
  double best = 1e300;
  for (int round = 0; round < 7; ++round) {
    const auto start = Clock::now();
    for (int k = 0; k < count; ++k) call();
    best = std::min(best, std::chrono::duration<double, std::nano>(Clock::now() - start).count() / count);
  }
  return best;
}

// As in overhead.
Model arm() {
  Model model;
  BodyId link = ground;
  const Vec3 axes[] = {z_axis, y_axis, x_axis};
  for (int k = 0; k < 7; ++k)
    link = model.add({.name = "arm/" + std::to_string(k),
                      .mass = 1,
                      .com = {0.1, 0.02, 0},
                      .inertia = diagonal(0.01, 0.02, 0.03),
                      .parent = link,
                      .at = {k == 0 ? 0 : 0.3, 0, 0},
                      .joint = Revolute{.axis = axes[k % 3], .damping = 0.1},
                      .q = 0.1 * k});
  return model;
}

}  // namespace

int main() {
  const Model model = arm();
  Simulation sim(model, {.step = 1e-4});
  double sum = 0;
  const auto set = [&](int joint, double x) {
    std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end());
    std::vector<double> p(sim.world().state().p().begin(), sim.world().state().p().end());
    q[static_cast<std::size_t>(joint)] += x;
    sim.adjust(q, p);
  };
  const double evaluate = nanoseconds(20'000, [&] {
    set(0, 1e-9);
    sum += sim.world().qdot()[0] + sim.world().pdot()[0];
  });
  const double matrix = nanoseconds(5'000, [&] {
    double M[49];
    set(0, 1e-9);
    sim.world().equations().mass_matrix(M);
    sum += M[0];
  });
  const double step = nanoseconds(5'000, [&] { static_cast<void>(sim.step(1e-4)); });
  Batch batch(model, 1000, {.threads = 1});
  const double batch_step = nanoseconds(50, [&] { batch.step(1e-4); });
  std::printf(R"({"evaluate": %.1f, "mass_matrix": %.1f, "step": %.1f, "batch": %.1f})", evaluate, matrix, step, batch_step);
  return sum == 0.5 ? 1 : 0;
}
