// A chain of a million bodies, on a thread with a stack of 1 MiB: no function recurses along the tree.
#include <string>

#include <pthread.h>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/topology/change.hpp>

using namespace momentree;

namespace {

constexpr int links = 1000000;

struct Outcome {
  int bodies = 0, parts = 0;
  double first = 0, last = 0, root = 0;
  Totals before, after;
};

/// Revolute joints about z one metre apart, all rotating about the ground like one rod.
void evaluate_chain(Outcome& out) {
  Model model({.gravity = {0, 0, 0}});
  BodyId last = ground;
  JointSpec hinge;
  hinge.kind = Kind::revolute;
  for (int k = 0; k < links; ++k)
    last = model.add({.name = std::to_string(k),
                      .mass = 1,
                      .com = {0.5, 0, 0},
                      .inertia = diagonal(1),
                      .parent = last,
                      .at = {k == 0 ? 0.0 : 1.0, 0, 0},
                      .joint = hinge,
                      .v = k == 0 ? 1e-3 : 0.0});
  Tree tree(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  out.bodies = tree.bodies();
  out.first = workspace.v[0];
  out.last = state.p().back();
  out.before = totals(tree, state, workspace);
  apply(Break{tree.inboard_joint({links / 2})}, tree, state, workspace);
  forward_dynamics(tree, state, workspace);
  out.after = totals(tree, state, workspace);
  for (int b = tree.first_root(); b >= 0; b = tree.next_sibling(b)) ++out.parts;
}

void* run(void* out) {
  evaluate_chain(*static_cast<Outcome*>(out));
  return nullptr;
}

}  // namespace

TEST_CASE("a chain of a million bodies is compiled, evaluated and broken in a small stack") {
  pthread_attr_t small;
  REQUIRE(pthread_attr_init(&small) == 0);
  REQUIRE(pthread_attr_setstacksize(&small, 1024 * 1024) == 0);
  Outcome out;
  pthread_t thread;
  REQUIRE(pthread_create(&thread, &small, run, &out) == 0);
  REQUIRE(pthread_join(thread, nullptr) == 0);
  pthread_attr_destroy(&small);

  CHECK(out.bodies == links);
  CHECK(out.parts == 2);
  // The last link: its centre moves sideways with ω (n − ½); p = (½ (n − ½) + 1) ω.
  const double n = links, w = 1e-3;
  CHECK(out.last == doctest::Approx((0.5 * (n - 0.5) + 1) * w).epsilon(1e-9));
  // Σ (k − ½)² = n (4 n² − 1) / 12.
  CHECK(out.before.kinetic == doctest::Approx(0.5 * w * w * (n * (4 * n * n - 1) / 12 + n)).epsilon(1e-6));
  CHECK(out.before.linear.y == doctest::Approx(w * n * n / 2).epsilon(1e-6));
  CHECK(out.after.kinetic == doctest::Approx(out.before.kinetic).epsilon(1e-6));
  CHECK(out.after.linear.y == doctest::Approx(out.before.linear.y).epsilon(1e-6));
}
