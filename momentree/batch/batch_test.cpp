#include <momentree/batch/batch.hpp>

#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/tree/edit.hpp>

using namespace momentree;

namespace {

constexpr Isa all_sets[] = {Isa::baseline, Isa::avx2, Isa::avx512};
constexpr Variables both[] = {Variables::momenta, Variables::velocities};

// A chain with a branch, with springs, dampers, and elements that are evaluated lane by lane.
Model mobile(bool elements = true) {
  Model model({.gravity = {0, 0, -9.81}});
  BodyId last = ground;
  for (int k = 0; k < 7; ++k) {
    BodySpec body{.name = "m/" + std::to_string(k),
                  .mass = 0.5 + 0.1 * k,
                  .com = {0.1, 0.02, -0.03},
                  .inertia = {0.01, 0.012, 0.013, 0.001, 0, 0.0005},
                  .parent = k == 5 ? BodyId{2} : last,
                  .at = Pose{{0.2, 0.05, 0}, normalized(Quat{1, 0.1, 0.2, -0.3})}};
    if (k == 3)
      body.joint = Ball{.damping = 0.02, .stiffness = elements ? 0.3 : 0.0}, body.q = {1, 0, 0, 0};
    else if (k == 5)
      body.joint = Prismatic{.axis = {1, 0, 0.2}, .stiffness = 20.0, .rest = 0.1}, body.q = 0.05;
    else
      body.joint = Revolute{.axis = {1.0 - 0.3 * k, 0.2 * k, 1}, .damping = 0.01, .stiffness = k == 1 ? 2.0 : 0.0, .effort = 0.1},
      body.q = 0.3 + 0.1 * k, body.v = 1 - 0.4 * k;
    if (elements && k == 4) body.joint.parameters.drive = effort_drive({Signal::sine(0.2, 2)});
    if (elements && k == 6)
      body.joint = Revolute{.axis = y_axis, .drive = motion_drive(Signal::sine(0.3, 1, 0.4))}, body.q = {}, body.v = {};
    if (elements && k == 2) body.joint.parameters.friction = {.coulomb = 0.05, .speed = 0.1};
    last = model.add(body);
  }
  return model;
}

// Gives each world different momenta or velocities.
void stir(int world, const Tree& tree, State& state) {
  const State::Edit edit = state.edit();
  for (int i = 0; i < tree.nv(); ++i) edit.y[static_cast<std::size_t>(i)] *= 1 + 0.01 * ((world * 7 + i * 3) % 11);
  follow_motions(tree, state.time(), edit.q.data(), edit.y.data());
}

struct Change {
  int step;
  double part;  // of the step, before the change happens
  int body;
  bool breaks;  // otherwise it locks
};
Change change_of(int world) { return {5 + world % 7, 0.1 * (world % 5), 1 + world % 4, world % 3 != 2}; }

// One world with the scalar engine.
struct Alone {
  Tree tree;
  State state;
  Workspace<double> workspace;
  Evaluator evaluate;
  EnergyLedger ledger;
  std::unique_ptr<Integrator> rk4;

  explicit Alone(const Model& model, Variables variables = Variables::momenta)
      : tree(compile(model)),
        state(start_state(model, tree, variables)),
        workspace(tree),
        evaluate(tree, workspace),
        rk4(make_integrator("rk4", tree)) {}
  Alone(const Alone&) = delete;
  Alone& operator=(const Alone&) = delete;
  void step(double h) {
    if (h == 0) return;
    evaluate(state);
    rk4->step(evaluate, state, ledger, h);
  }
  void apply(const Change& change) {
    evaluate(state);
    if (change.breaks)
      momentree::apply(Break{tree.inboard_joint({change.body})}, tree, state, workspace);
    else
      momentree::apply(Lock{tree.inboard_joint({change.body})}, tree, state, workspace);
  }
};

constexpr double h = 1e-3;
constexpr int steps = 40;

// Runs all worlds of a batch, numbered from `first`, each with its own change at its own instant.
void run(Batch& batch, int first) {
  std::vector<double> own(static_cast<std::size_t>(batch.worlds()));
  for (int i = 0; i < batch.worlds(); ++i) {
    State state = batch.state(i);
    stir(first + i, batch.tree(i), state);
    batch.set_state(i, state);
  }
  for (int k = 0; k < steps; ++k) {
    for (int i = 0; i < batch.worlds(); ++i) {
      const Change change = change_of(first + i);
      own[static_cast<std::size_t>(i)] = change.step == k ? change.part * h : h;
    }
    batch.step(own);
    for (int i = 0; i < batch.worlds(); ++i) {
      const Change change = change_of(first + i);
      own[static_cast<std::size_t>(i)] = 0;
      if (change.step != k) continue;
      if (change.breaks)
        batch.apply(i, Break{{change.body}});
      else
        batch.apply(i, Lock{{change.body}});
      own[static_cast<std::size_t>(i)] = h - change.part * h;
    }
    batch.step(own);
  }
}

double difference(const State& a, const State& b) {
  REQUIRE(a.q().size() == b.q().size());
  REQUIRE(a.y().size() == b.y().size());
  REQUIRE(a.variables() == b.variables());
  double worst = std::fabs(a.time() - b.time());
  for (std::size_t i = 0; i < a.q().size(); ++i) worst = std::fmax(worst, std::fabs(a.q()[i] - b.q()[i]));
  for (std::size_t i = 0; i < a.y().size(); ++i) worst = std::fmax(worst, std::fabs(a.y()[i] - b.y()[i]));
  return worst;
}

// The same state in velocities.
State in_velocities(const Tree& tree, const State& state) {
  Workspace<double> workspace(tree);
  forward_dynamics(tree, state, workspace);
  State u(tree, Variables::velocities);
  u.assign(state.time(), state.q(), {workspace.v.get(), static_cast<std::size_t>(tree.nv())}, tree);
  return u;
}

}  // namespace

TEST_CASE("worlds of a batch have the bits of those alone, each with a change at its own time") {
  const Model model = mobile();
  constexpr int worlds = 13;
  for (const Isa isa : all_sets)
    for (const Variables variables : both) {
      if (!batch::available(isa)) continue;
      Batch batch(model, worlds, {.variables = variables, .widest = isa});
      CHECK(batch.isa() == isa);
      CHECK(batch.variables() == variables);
      CHECK(batch.groups() == 1);
      run(batch, 0);
      CHECK(batch.groups() > 4);
      double worst = 0;
      for (int i = 0; i < worlds; ++i) {
        Alone alone(model, variables);
        stir(i, alone.tree, alone.state);
        const Change change = change_of(i);
        for (int k = 0; k < steps; ++k) {
          if (k == change.step) {
            alone.step(change.part * h);
            alone.apply(change);
            alone.step(h - change.part * h);
          } else {
            alone.step(h);
          }
        }
        CHECK(batch.time(i) == doctest::Approx(steps * h));
        worst = std::fmax(worst, difference(batch.state(i), alone.state));
      }
      // On x86-64 there is no machine code for the baseline.
      CHECK(worst <= (batch::makes_machine_code(isa) == batch::makes_machine_code(std::nullopt) ? 0 : 1e-12));
    }
}

TEST_CASE("no bit of a world depends on the other lanes or on the number of threads") {
  const Model model = mobile();
  for (const Precision precision : {Precision::float64, Precision::float32}) {
    for (const Isa isa : all_sets)
      for (const Variables variables : both) {
        if (!batch::available(isa)) continue;
        Batch together(model, 21, {.precision = precision, .variables = variables, .threads = 3, .widest = isa});
        CHECK(together.threads() == 3);
        run(together, 0);
        for (int i = 0; i < 21; ++i) {
          Batch alone(model, 1, {.precision = precision, .variables = variables, .widest = isa});
          run(alone, i);
          CHECK(difference(together.state(i), alone.state(0)) == 0);
        }
      }
  }
}

TEST_CASE("worlds in float stay close to those in double") {
  const Model model = mobile();
  for (const Variables variables : both) {
    Batch exact(model, 9, {.variables = variables}), coarse(model, 9, {.precision = Precision::float32, .variables = variables});
    CHECK(coarse.lanes() == 2 * exact.lanes());
    run(exact, 0);
    run(coarse, 0);
    double worst = 0;
    for (int i = 0; i < 9; ++i) worst = std::fmax(worst, difference(exact.state(i), coarse.state(i)));
    CHECK(worst < 2e-4);
    CHECK(worst > 1e-9);  // they were indeed computed in float
  }
}

TEST_CASE("worlds in velocities move as those in momenta, through their changes") {
  const Model model = mobile();
  Batch p(model, 13), u(model, 13, {.variables = Variables::velocities});
  for (int i = 0; i < 13; ++i) {
    State state = u.state(i);
    REQUIRE(state.variables() == Variables::velocities);
    stir(i, u.tree(i), state);
    u.set_state(i, state);
    State same(p.tree(i), Variables::velocities);
    same.assign(state.time(), state.q(), state.u(), p.tree(i));
    p.set_state(i, same);  // converts it
    CHECK(difference(in_velocities(p.tree(i), p.state(i)), state) < 1e-13);
    State back(u.tree(i));
    back.assign(state.time(), state.q(), p.state(i).p(), u.tree(i));
    u.set_state(i, back);
    CHECK(difference(u.state(i), state) < 1e-13);
    u.set_state(i, state);
  }
  for (int k = 0; k < steps; ++k) {
    p.step(h), u.step(h);
    for (int i = 0; i < 13; ++i)
      if (const Change change = change_of(i); change.step == k)
        for (Batch* batch : {&p, &u}) {
          if (change.breaks)
            batch->apply(i, Break{{change.body}});
          else
            batch->apply(i, Lock{{change.body}});
        }
  }
  CHECK(u.groups() == p.groups());
  double worst = 0;
  for (int i = 0; i < 13; ++i) {
    CHECK(u.group(i) == p.group(i));
    worst = std::fmax(worst, difference(in_velocities(p.tree(i), p.state(i)), u.state(i)));
  }
  CHECK(worst < 1e-8);  // the error of rk4 in the two
  CHECK(worst > 1e-15);
}

TEST_CASE("an edit may leave a state in the other variables") {
  Batch batch(mobile(), 2, {.variables = Variables::velocities});
  batch.step(h);
  const State before = batch.state(1);
  batch.edit(1, [](Tree& tree, State& state, Workspace<double>& workspace) {
    state = [&] {
      State momenta(tree);
      momenta.assign(state.time(), state.q(), {workspace.p.get(), static_cast<std::size_t>(tree.nv())}, tree);
      return momenta;
    }();
  });
  CHECK(difference(batch.state(1), before) < 1e-13);
  batch.apply(1, Lock{{2}});
  CHECK(batch.state(1).variables() == Variables::velocities);
}

TEST_CASE("worlds that reach the same topology share lanes again") {
  for (const Variables variables : both) {
    Batch batch(mobile(), 6, {.variables = variables});
    for (int i = 0; i < 6; ++i) {
      batch.step(h);
      batch.apply(i, Break{{3}});
    }
    CHECK(batch.groups() == 1);
    batch.apply(2, Lock{{1}});
    CHECK(batch.groups() == 2);
    batch.apply(2, Unlock{{1}});
    CHECK(batch.groups() == 1);
    const Impulse push{.body = {2}, .force = {1, 0.5, 0}, .point = {0.1, 0.2, 0}};
    const State before = batch.state(4);
    batch.apply(4, push);
    CHECK(batch.groups() == 1);
    CHECK(difference(before, batch.state(4)) > 1e-3);
  }
}

TEST_CASE("bodies can be added to worlds of a batch") {
  const Model model = mobile();
  Model larger = mobile();  // completes the body
  const BodyId extra =
      larger.add({.name = "x", .mass = 1, .inertia = diagonal(0.1), .parent = {4}, .joint = Revolute{}, .q = 0.2});
  for (const Variables variables : both) {
    Batch batch(model, 3, {.variables = variables});
    const BodyId added = batch.apply(1, Add{&larger[extra]});
    CHECK(added.index == model.size());
    CHECK(batch.groups() == 2);
    CHECK(batch.tree(1).bodies() == model.size() + 1);
    for (int k = 0; k < 5; ++k) batch.step(h);
    CHECK(batch.time(1) == batch.time(0));
    CHECK_FALSE(batch.diverged(1));
  }
}

TEST_CASE("an effort set for one world acts as the same effort in its model") {
  Model model = mobile(false);
  for (const Variables variables : both) {
    Batch batch(model, 5, {.variables = variables});
    batch.set_effort(3, {4}, 0, 0.7);
    BodySpec spec = model[{4}];
    Model other({.gravity = {0, 0, -9.81}});
    for (int b = 0; b < model.size(); ++b) {
      BodySpec body = model[{b}];
      if (b == 4) body.joint.parameters.effort = 0.8;  // 0.1 is the model's
      other.add(body);
    }
    Batch with(other, 1, {.variables = variables});
    for (int k = 0; k < 20; ++k) batch.step(h), with.step(h);
    CHECK(difference(batch.state(3), with.state(0)) < 1e-13);
    CHECK(difference(batch.state(3), batch.state(2)) > 1e-4);
    batch.apply(3, Lock{{1}});  // it joins other worlds, with its effort
    with.apply(0, Lock{{1}});
    for (int k = 0; k < 20; ++k) batch.step(h), with.step(h);
    CHECK(difference(batch.state(3), with.state(0)) < 1e-13);
    batch.apply(3, Break{{4}});  // removes the joint
    with.apply(0, Break{{4}});
    for (int k = 0; k < 20; ++k) batch.step(h), with.step(h);
    CHECK(difference(batch.state(3), with.state(0)) < 1e-13);
  }
}

TEST_CASE("a world that diverges keeps its last state, and the others continue") {
  for (const Variables variables : both) {
    Batch batch(mobile(), 4, {.variables = variables}), other(mobile(), 4, {.variables = variables});
    State state = batch.state(2);
    state.edit().y[0] = 1e13;
    batch.set_state(2, state);
    const State before = batch.state(2);
    for (int k = 0; k < 3; ++k) batch.step(h), other.step(h);
    CHECK(batch.diverged(2));
    CHECK(difference(batch.state(2), before) == 0);
    CHECK(difference(batch.state(1), other.state(1)) == 0);
    batch.set_state(2, batch.state(1));
    CHECK_FALSE(batch.diverged(2));
    batch.step(h);
    CHECK(difference(batch.state(2), batch.state(1)) == 0);
  }
}

TEST_CASE("an edit that gives worlds in lanes what these do not have is refused, and leaves the world unchanged") {
  CHECK_THROWS_AS(Batch(mobile(), 0), Error);

  Batch batch(mobile(), 2);
  batch.step(h);
  const State before = batch.state(1);
  const auto function = std::make_shared<const JointFunction>([](const EvaluationContext&, std::span<double>) {});
  CHECK_THROWS_AS(batch.edit(1, [&](Tree& tree, State&, Workspace<double>&) { tree.edit().set_function(1, function); }), Error);
  const auto refuses = [&](const JointParameters& parameters, const char* what) {
    std::string said;
    try {
      batch.apply(1, SetParameters{{1}, parameters});
    } catch (const Error& error) {
      said = error.message();
    }
    INFO(said);
    CHECK(said.find(what) != std::string::npos);
  };
  refuses({.limits = {.upper = 1.0}}, "hard stops");
  refuses({.strength = {.force = 10}}, "strengths");
  CHECK(difference(batch.state(1), before) == 0);
  CHECK(batch.groups() == 1);
}
