// Results computed from one state and tree are never taken for those of another, whenever and wherever these live.
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/snapshot.hpp>

using namespace momentree;

namespace {

// v = p / (mass / 4 + 0.1)
Model pendulum(double mass) {
  Model model({.gravity = {}});
  model.add({.name = "bob", .mass = mass, .com = {0.5, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{.axis = y_axis}});
  return model;
}
double speed(const Tree& tree, const State& state, Workspace<double>& workspace) {
  forward_dynamics(tree, state, workspace);
  return workspace.v[0];
}
State with_momentum(const Tree& tree, double p) {
  State state(tree);
  state.edit().p[0] = p;
  return state;
}

// True if a temporary Edit would leave a way to write behind after its end.
template <class S>
concept gives_data = requires(S& state) {
  state.edit().p.data();
};
template <class S>
concept gives_iterator = requires(S& state) {
  state.edit().p.begin();
};

}  // namespace

TEST_CASE("states at one address, one after the other, are distinguished") {
  const Tree tree(pendulum(1));
  Workspace<double> workspace(tree);
  for (int i = 1; i <= 3; ++i) {
    State state(tree);
    state.edit().p[0] = i;
    CHECK(speed(tree, state, workspace) == doctest::Approx(i / 0.35));
  }
  for (int i = 1; i <= 3; ++i) {
    const State state = with_momentum(tree, i);
    CHECK(speed(tree, state, workspace) == doctest::Approx(i / 0.35));
    CHECK(totals(tree, state, workspace).kinetic == doctest::Approx(0.5 * i * i / 0.35));
  }
  std::optional<State> slot;
  for (int i = 1; i <= 3; ++i) {
    slot.emplace(with_momentum(tree, i));
    CHECK(speed(tree, *slot, workspace) == doctest::Approx(i / 0.35));
  }
  for (int i = 1; i <= 3; ++i) {
    const auto state = std::make_unique<State>(with_momentum(tree, i));
    CHECK(speed(tree, *state, workspace) == doctest::Approx(i / 0.35));
  }
}

TEST_CASE("trees of equal shape and different masses are distinguished, one after the other or side by side") {
  std::optional<Workspace<double>> workspace;
  for (int mass = 1; mass <= 3; ++mass) {
    const Tree tree(pendulum(mass));
    const State state = with_momentum(tree, 1);
    if (!workspace) workspace.emplace(tree);
    CHECK(speed(tree, state, *workspace) == doctest::Approx(1 / (0.25 * mass + 0.1)));
  }
  const Tree light(pendulum(1)), heavy(pendulum(4));
  const State one = with_momentum(light, 1), other = with_momentum(heavy, 1);
  for (int turn = 0; turn < 2; ++turn) {
    CHECK(speed(light, one, *workspace) == doctest::Approx(1 / 0.35));
    CHECK(speed(heavy, other, *workspace) == doctest::Approx(1 / 1.1));
  }
  CHECK(Tree(pendulum(1)).revision() != Tree(pendulum(1)).revision());
}

TEST_CASE("a copy of a tree is the same tree until one of them changes") {
  Model model = pendulum(1);
  model.add({.name = "tail",
             .mass = 1,
             .com = {0.5, 0, 0},
             .inertia = diagonal(0.1),
             .parent = {0},
             .at = {1, 0, 0},
             .joint = Revolute{}});
  Tree tree(model);
  const Tree copy = tree;
  State state = with_momentum(tree, 1);
  Workspace<double> workspace(tree);
  const double both = speed(tree, state, workspace);
  CHECK(copy.revision() == tree.revision());
  CHECK(speed(copy, state, workspace) == both);
  const State before = state;
  apply(Break{tree.inboard_joint({1})}, tree, state, workspace);
  CHECK(copy.revision() != tree.revision());
  CHECK(before.topology() == copy.revision());
  CHECK(state.topology() == tree.revision());

  Tree a = copy, b = copy;  // the same change made to each is a separate revision
  State of_a = before, of_b = before;
  forward_dynamics(a, of_a, workspace);
  apply(Lock{a.inboard_joint({1})}, a, of_a, workspace);
  forward_dynamics(b, of_b, workspace);
  apply(Lock{b.inboard_joint({1})}, b, of_b, workspace);
  CHECK(a.revision() != b.revision());

  const std::uint64_t was = a.revision();
  const Tree moved = std::move(a);
  CHECK(moved.revision() == was);
  CHECK(a.revision() != was);  // NOLINT(bugprone-use-after-move): belongs to no tree any more
}

TEST_CASE("copies of states, assignments and swaps") {
  const Tree tree(pendulum(1));
  Workspace<double> workspace(tree);
  State one = with_momentum(tree, 1), two = with_momentum(tree, 2);
  CHECK(speed(tree, one, workspace) == doctest::Approx(1 / 0.35));

  const State copy = one;
  CHECK(copy.stamp() != one.stamp());
  CHECK(evaluated_on(tree, one, workspace));
  CHECK_FALSE(evaluated_on(tree, copy, workspace));

  State& self = one;
  one = self;
  CHECK(evaluated_on(tree, one, workspace));  // self-assignment changes nothing

  one = two;
  CHECK_FALSE(evaluated_on(tree, one, workspace));
  CHECK(speed(tree, one, workspace) == doctest::Approx(2 / 0.35));
  two.edit().p[0] = 3;
  one = two;
  CHECK(speed(tree, one, workspace) == doctest::Approx(3 / 0.35));

  two.edit().p[0] = 4;
  CHECK(speed(tree, one, workspace) == doctest::Approx(3 / 0.35));
  std::swap(one, two);
  CHECK(speed(tree, one, workspace) == doctest::Approx(4 / 0.35));
  CHECK(speed(tree, two, workspace) == doctest::Approx(3 / 0.35));

  std::vector<State> many;  // moved when it grows
  for (int i = 0; i < 10; ++i) many.push_back(with_momentum(tree, i));
  for (int i = 0; i < 10; ++i) CHECK(speed(tree, many[static_cast<std::size_t>(i)], workspace) == doctest::Approx(i / 0.35));
  many.erase(many.begin());
  for (int i = 1; i < 10; ++i) CHECK(speed(tree, many[static_cast<std::size_t>(i - 1)], workspace) == doctest::Approx(i / 0.35));
}

TEST_CASE("a moved state keeps its stamp, and leaves none behind") {
  const Tree tree(pendulum(1));
  Workspace<double> workspace(tree);
  State one = with_momentum(tree, 1);
  CHECK(speed(tree, one, workspace) == doctest::Approx(1 / 0.35));
  State moved = std::move(one);
  CHECK(evaluated_on(tree, moved, workspace));
  CHECK(one.topology() == 0);  // NOLINT(bugprone-use-after-move)
  one = with_momentum(tree, 5);
  CHECK_FALSE(evaluated_on(tree, one, workspace));
  CHECK(speed(tree, one, workspace) == doctest::Approx(5 / 0.35));
  CHECK(speed(tree, moved, workspace) == doctest::Approx(1 / 0.35));
  State& self = moved;
  moved = std::move(self);
  CHECK(evaluated_on(tree, moved, workspace));
  CHECK(moved.p()[0] == 1);
}

TEST_CASE("an edit invalidates what was evaluated before and during it") {
  const Tree tree(pendulum(1));
  Workspace<double> workspace(tree);
  State state(tree);
  for (int i = 1; i <= 3; ++i) {
    state.edit().p[0] = i;
    CHECK(speed(tree, state, workspace) == doctest::Approx(i / 0.35));
  }
  {
    const State::Edit edit = state.edit();
    CHECK(state.being_edited());
    CHECK_FALSE(evaluated_on(tree, state, workspace));
    edit.p[0] = 4, edit.time = 1;
    CHECK(speed(tree, state, workspace) == doctest::Approx(4 / 0.35));
    edit.p[0] = 4.5;
    CHECK(speed(tree, state, workspace) == doctest::Approx(4.5 / 0.35));
    CHECK_FALSE(evaluated_on(tree, state, workspace));
    CHECK(totals(tree, state, workspace).kinetic == doctest::Approx(0.5 * 4.5 * 4.5 / 0.35));
    const State::Edit another = state.edit();
    another.p[0] = 5;
    CHECK(totals(tree, state, workspace).kinetic == doctest::Approx(0.5 * 25 / 0.35));
    accelerate(tree, state, workspace);
    another.p[0] = 4.9, edit.p[0] = 5;
  }
  CHECK_FALSE(state.being_edited());
  CHECK(state.time() == 1);
  CHECK(speed(tree, state, workspace) == doctest::Approx(5 / 0.35));
  for (double& p : state.edit().p) p = 6;  // the edit lives as long as the loop
  CHECK(speed(tree, state, workspace) == doctest::Approx(6 / 0.35));

  // Must not compile: keeping write access beyond the Edit.
  using Writable = State::Edit::Writable;
  CHECK_FALSE(std::is_copy_constructible_v<Writable>);
  CHECK_FALSE(std::is_copy_constructible_v<State::Edit>);
  CHECK_FALSE(gives_data<State>);
  CHECK_FALSE(gives_iterator<State>);
}

TEST_CASE("a restored state counts as another one, even with the same numbers") {
  Tree tree(pendulum(1));
  Workspace<double> workspace(tree);
  State state = with_momentum(tree, 1);
  const Snapshot before = take_snapshot(tree, state);
  CHECK(speed(tree, state, workspace) == doctest::Approx(1 / 0.35));
  state.edit().p[0] = 2;
  CHECK(speed(tree, state, workspace) == doctest::Approx(2 / 0.35));
  restore(before, tree, state);
  CHECK_FALSE(evaluated_on(tree, state, workspace));
  CHECK(speed(tree, state, workspace) == doctest::Approx(1 / 0.35));
}

TEST_CASE("a workspace has locations and accelerations of one state only, and none after it was moved from") {
  const Tree tree(pendulum(1));
  Workspace<double> workspace(tree);
  State one = with_momentum(tree, 1), two = with_momentum(tree, 2);
  accelerate(tree, one, workspace);
  CHECK(accelerated_on(tree, one, workspace));
  CHECK_FALSE(accelerated_on(tree, two, workspace));
  locate_bodies(tree, two, workspace);
  CHECK_FALSE(accelerated_on(tree, one, workspace));
  CHECK(workspace.bodies[0].velocity.w.z != 0);
  const double w = workspace.bodies[0].velocity.w.z;
  locate_bodies(tree, one, workspace);
  CHECK(workspace.bodies[0].velocity.w.z == doctest::Approx(w / 2));

  Workspace<double> other = std::move(workspace);
  CHECK(evaluated_on(tree, one, other));
  CHECK_FALSE(evaluated_on(tree, one, workspace));  // NOLINT(bugprone-use-after-move)
  CHECK(workspace.capacity() == 0);
  workspace = Workspace<double>(tree);
  CHECK(speed(tree, one, workspace) == doctest::Approx(1 / 0.35));
  CHECK(speed(tree, two, other) == doctest::Approx(2 / 0.35));
}
