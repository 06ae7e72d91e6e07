// Use from several threads at once. The results must be those of one thread; a build with ThreadSanitizer (preset tsan) checks
// that this is not luck.
#include <functional>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/batch/batch.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr int count = 4;

void in_threads(const std::function<void(int)>& act) {
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i) threads.emplace_back(act, i);
  for (std::thread& thread : threads) thread.join();
}

Model chain() {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < 5; ++k)
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = 1,
                      .com = {0.1, 0, 0},
                      .inertia = diagonal(0.1),
                      .parent = last,
                      .at = {k == 0 ? 0 : 0.2, 0, 0},
                      .joint = Revolute{.axis = y_axis, .damping = 0.01, .limits = {.lower = -3, .upper = 3}},
                      .q = 0.2});
  return model;
}

}  // namespace

TEST_CASE("simulations of one model, each in a thread, with actions, conditions and functions that they share") {
  const Model model = chain();
  const Condition hard = reaction_force("c/3").exceeds(25);
  const Action cut = break_joint("c/4"), hold = lock("c/1");
  const auto push = [](const EvaluationContext& now) { return now.time() < 0.1 ? 0.5 : 0.0; };
  std::vector<double> ends(count + 1);
  const auto run = [&](int i) {
    Simulation sim(model, {.method = i % 2 == 0 ? "rk4" : "dopri5"});
    sim.drive("c/0", push);
    sim.when(hard).then(cut);
    sim.at(0.1).then(hold);
    sim.observe(0.02, [](const World& world) { return world.totals().kinetic >= 0; });
    CHECK(sim.run_until(0.3) == Status::ok);
    ends[static_cast<std::size_t>(i)] = sim.world().joint({0}).q[0];
  };
  in_threads(run);
  run(count);
  CHECK(ends[0] == ends[2]);
  CHECK(ends[0] == ends[count]);
  CHECK(ends[1] == ends[3]);
}

TEST_CASE("branches of one run, each in a thread") {
  Simulation trunk(chain());
  trunk.drive("c/0", [](const EvaluationContext& now) { return -0.2 * now.v({0})[0]; });
  trunk.when(speed_of("c/4").exceeds(4)).then(break_joint("c/4"));
  REQUIRE(trunk.run_until(0.1) == Status::ok);
  std::vector<Simulation> branches;
  for (int i = 0; i < count; ++i) branches.push_back(trunk.branch());
  in_threads([&](int i) {
    Simulation& own = branches[static_cast<std::size_t>(i)];
    own.apply(impulse("c/2", {0, 0, 0.1 * i}));
    CHECK(own.run_until(0.3) == Status::ok);
  });
  REQUIRE(trunk.run_until(0.3) == Status::ok);
  for (const Simulation& each : branches) CHECK(each.time() == trunk.time());
}

TEST_CASE("one tree that all threads evaluate, and a tree, state and workspace per thread") {
  const Model model = chain();
  const Tree shared(model);
  const State start = start_state(model, shared);
  std::vector<double> kinetic(count);
  in_threads([&](int i) {
    Workspace<double> work(shared);
    for (int k = 0; k < 200; ++k) {
      State state = start;
      state.edit().p[0] = 1 + 0.001 * k;
      kinetic[static_cast<std::size_t>(i)] = totals(shared, state, work).kinetic;
      Tree tree = shared;
      if (k % 20 == i) apply(Break{tree.inboard_joint({i})}, tree, state, work);
    }
  });
  for (const double each : kinetic) CHECK(each == kinetic[0]);
}

TEST_CASE("batches with threads, run from several threads") {
  const Model pendulum = [] {
    Model model;
    model.add(
        {.name = "bob", .mass = 1, .com = {0, 0, -1}, .inertia = diagonal(0.01), .joint = Revolute{.axis = y_axis}, .q = 0.5});
    return model;
  }();
  std::vector<double> ends(count);
  in_threads([&](int i) {
    Batch batch(pendulum, 40, {.threads = 3});
    for (int k = 0; k < 50; ++k) {
      batch.step(1e-3);
      if (k == 20) batch.apply(7, Lock{{0}});
    }
    ends[static_cast<std::size_t>(i)] = batch.state(39).q()[0];
    CHECK(batch.groups() == 2);
  });
  for (const double each : ends) CHECK(each == ends[0]);
}
