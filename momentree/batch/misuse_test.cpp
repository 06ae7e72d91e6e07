// Invalid arguments and calls of batches; and that their states and trees are distinguished.
#pragma GCC diagnostic ignored "-Wuse-after-free"  // a batch destroyed in its own callback, which stops the program
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/batch/batch.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/error_of.hpp>
#include <tests/misuse.hpp>

using namespace momentree;
using namespace momentree::test;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

Model chain(double mass = 1) {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < 3; ++k)
    last = model.add({.name = "c/" + std::to_string(k),
                      .mass = mass,
                      .com = {0.1, 0, 0},
                      .inertia = diagonal(0.1),
                      .parent = last,
                      .at = {k == 0 ? 0 : 0.2, 0, 0},
                      .joint = Revolute{.axis = y_axis}});
  return model;
}

}  // namespace

TEST_CASE("the worlds of a batch, read one after the other with one workspace, have separate energies") {
  constexpr int worlds = 9;
  Batch batch(chain(), worlds);
  for (int i = 0; i < worlds; ++i) batch.edit(i, [i](Tree&, State& state, Workspace<double>&) { state.edit().p[0] = i + 1; });
  for (int i = 0; i < worlds; i += 2) batch.apply(i, Break{{2}});
  for (int i = 0; i < worlds; i += 3) batch.apply(i, Lock{{1}});
  REQUIRE(batch.groups() == 4);
  std::vector<double> apart, together, copied;
  for (int i = 0; i < worlds; ++i) {
    const State state = batch.state(i);
    Workspace<double> workspace(batch.tree(i));
    apart.push_back(totals(batch.tree(i), state, workspace).kinetic);
  }
  Workspace<double> workspace(batch.tree(0));
  for (int i = 0; i < worlds; ++i) {
    const State state = batch.state(i);
    together.push_back(totals(batch.tree(i), state, workspace).kinetic);
  }
  for (int i = 0; i < worlds; ++i) {
    const Tree tree = batch.tree(i);
    copied.push_back(totals(tree, batch.state(i), workspace).kinetic);
  }
  CHECK(apart == together);
  CHECK(apart == copied);
  for (int i = 1; i < worlds; ++i) CHECK(apart[static_cast<std::size_t>(i)] != apart[static_cast<std::size_t>(i - 1)]);
}

TEST_CASE("a state of one world fits all worlds of its topology, and no others") {
  Batch batch(chain(), 4);
  batch.apply(3, Break{{2}});
  State state = batch.state(0);
  state.edit().p[0] = 5;
  batch.set_state(1, state);
  CHECK(batch.state(1).p()[0] == 5);
  batch.set_state(2, start_state(chain(), batch.tree(2)));
  const char* const foreign = "the state belongs to tree(world)";
  check_stopped("a state of another topology", foreign, [&] { batch.set_state(3, batch.state(0)); });
  check_stopped("a state of another batch", foreign, [&] { batch.set_state(0, Batch(chain(), 1).state(0)); });
  check_stopped("a default state", foreign, [&] { batch.set_state(0, State()); });
  check_stopped("a state that is being edited", "the state's Edit has ended", [&] {
    const State::Edit edit = state.edit();
    batch.set_state(0, state);
  });
}

TEST_CASE("misuse: invalid worlds, steps and efforts") {
  Batch batch(chain(), 3);
  const char* const no_world = "the batch has this world";
  for (const int world : {-1, 3, 1 << 30}) {
    CAPTURE(world);
    const Misuse all[] = {
        {"time", no_world, [&] { static_cast<void>(batch.time(world)); }},
        {"diverged", no_world, [&] { static_cast<void>(batch.diverged(world)); }},
        {"tree", no_world, [&] { static_cast<void>(batch.tree(world)); }},
        {"state", no_world, [&] { static_cast<void>(batch.state(world)); }},
        {"set_state", no_world, [&] { batch.set_state(world, batch.state(0)); }},
        {"set_effort", no_world, [&] { batch.set_effort(world, {0}, 0, 1); }},
        {"apply", no_world, [&] { batch.apply(world, Break{{1}}); }},
        {"edit", no_world, [&] { batch.edit(world, [](Tree&, State&, Workspace<double>&) {}); }},
    };
    for (const Misuse& misuse : all) check_stopped(misuse);
  }
  const char* const a_step = "a step that is finite and not negative";
  const std::vector<double> two(2, 1e-3);
  const Misuse all[] = {
      {"a step that is no number", a_step, [&] { batch.step(no_number); }},
      {"a step without end", a_step, [&] { batch.step(inf); }},
      {"a step back", a_step, [&] { batch.step(-1e-3); }},
      {"steps for other worlds", "one step for every world", [&] { batch.step(two); }},
      {"one step that is no number", a_step,
       [&] {
         batch.step(std::vector<double>{0, no_number, 0});
       }},
      {"an effort on no joint", "the joint is in the tree", [&] { batch.set_effort(0, {9}, 0, 1); }},
      {"an effort on a joint of no number", "the joint is in the tree", [&] { batch.set_effort(0, {}, 0, 1); }},
      {"an effort on no degree of freedom", "the joint has this degree of freedom", [&] { batch.set_effort(0, {0}, 1, 1); }},
      {"an effort that is no number", "a finite effort", [&] { batch.set_effort(0, {0}, 0, no_number); }},
      {"a change of no joint", "the joint is in the tree", [&] { batch.apply(0, Lock{{9}}); }},
      {"a moved-from batch", "has not been moved from",
       [&] {
         const Batch moved = std::move(batch);
         batch.step(1e-3);
       }},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
  CHECK(error_of([] { Batch(chain(), 0); }).find("at least one world") != std::string::npos);
  CHECK(error_of([] { Batch(Model(), 3); }).find("at least one body") != std::string::npos);
  CHECK(error_of([] { Batch(chain(), -5); }).find("at least one world") != std::string::npos);
  CHECK(error_of([] { Batch(Model(), 2); }).find("at least one body") != std::string::npos);
  for (const int threads : {-1, 1025, 1 << 30})
    CHECK(error_of([threads] { Batch(chain(), 1, {.threads = threads}); }).find("threads") != std::string::npos);
}

TEST_CASE("misuse: edits") {
  Batch batch(chain(), 3);
  const char* const only = "an edit of a batch only reads the batch";
  const auto in_edit = [&](auto act) {
    return [&batch, act] {
      batch.edit(0, [&](Tree& tree, State& state, Workspace<double>& workspace) { act(batch, tree, state, workspace); });
    };
  };
  check_fine("reads", in_edit([](Batch& b, Tree&, State&, Workspace<double>&) {
               static_cast<void>(b.state(1));
               static_cast<void>(b.tree(1).nq() + b.worlds() + b.time(2));
             }));
  const Misuse all[] = {
      {"step", only, in_edit([](Batch& b, Tree&, State&, Workspace<double>&) { b.step(1e-3); })},
      {"apply", only, in_edit([](Batch& b, Tree&, State&, Workspace<double>&) { b.apply(1, Break{{1}}); })},
      {"edit", only,
       in_edit([](Batch& b, Tree&, State&, Workspace<double>&) { b.edit(1, [](Tree&, State&, Workspace<double>&) {}); })},
      {"set_state", only, in_edit([](Batch& b, Tree&, State&, Workspace<double>&) { b.set_state(1, b.state(2)); })},
      {"set_effort", only, in_edit([](Batch& b, Tree&, State&, Workspace<double>&) { b.set_effort(1, {0}, 0, 1); })},
      {"move", only, in_edit([](Batch& b, Tree&, State&, Workspace<double>&) { const Batch other = std::move(b); })},
      {"replace", only, in_edit([](Batch& b, Tree&, State&, Workspace<double>&) { b = Batch(chain(), 1); })},
      {"a tree changed, its state not", "after the edit, the state still belongs to the tree",
       in_edit([](Batch&, Tree& tree, State&, Workspace<double>&) { tree.edit().detach(1); })},
      {"a tree of another model", "after the edit, the tree still belongs to the batch's model",
       in_edit([](Batch&, Tree& tree, State& state, Workspace<double>&) {
         tree = Tree(chain(2));
         state = State(tree);
       })},
      {"destroy", only,
       [] {
         auto own = std::make_unique<Batch>(chain(), 1);
         own->edit(0, [&](Tree&, State&, Workspace<double>&) { own.reset(); });
       }},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);

  const State before = batch.state(0);
  CHECK_THROWS_AS(batch.edit(0,
                             [](Tree& tree, State& state, Workspace<double>& workspace) {
                               apply(Break{tree.inboard_joint({1})}, tree, state, workspace);
                               throw std::runtime_error("not that");
                             }),
                  std::runtime_error);
  CHECK(batch.groups() == 1);
  CHECK(std::equal(before.p().begin(), before.p().end(), batch.state(0).p().begin()));
  batch.apply(0, Break{{1}});  // and it can be changed as before
  CHECK(batch.groups() == 2);
}
