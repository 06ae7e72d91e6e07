// Neither steps nor changes allocate memory: counted by the program's own operator new.
#include <atomic>
#include <cstdlib>
#include <new>

#include <doctest/doctest.h>

#include <momentree/batch/batch.hpp>
#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/topology/change.hpp>
#include <tests/oracle/random_model.hpp>

namespace {
std::atomic<long> allocations{0};

void* take(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* take(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const std::size_t a = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(a, (size + a - 1) / a * a)) return memory;
  throw std::bad_alloc();
}
}  // namespace

void* operator new(std::size_t size) { return take(size); }
void* operator new[](std::size_t size) { return take(size); }
void* operator new(std::size_t size, std::align_val_t alignment) { return take(size, alignment); }
void* operator new[](std::size_t size, std::align_val_t alignment) { return take(size, alignment); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

using namespace momentree;

namespace {
// Wind on every third body, and springs between neighbours.
Model in_the_wind(Model model) {
  for (int b = 0; b + 1 < model.size(); b += 2)
    model.add_spring({.name = "spring " + std::to_string(b),
                      .from = {{b}, {0.1, 0, 0}},
                      .to = {{b + 1}, {0, 0.2, 0}},
                      .stiffness = 10,
                      .damping = 0.1,
                      .tension_only = b % 4 == 0,
                      .strength = 1e9});
  for (int b = 0; b < model.size(); b += 3)
    model.add_force(
        {.body = {b}, .point = {0.1, 0, 0}, .force = {Signal::table({{0, 1}, {1, 2}}), 0.0, 0.0}, .drag = {.linear = 0.1}});
  return model;
}
}  // namespace

TEST_CASE("the counter counts") {
  const long before = allocations;
  std::vector<int> some(100);
  CHECK(allocations == before + 1);
  CHECK(some.size() == 100);
}

TEST_CASE("stepping and breaking allocate nothing, with all kinds of joints, until every body is free") {
  for (std::uint64_t seed = 0; seed < 27; ++seed) {
    CAPTURE(seed);
    const Model model = in_the_wind(oracle::random_tree(seed, {.min_bodies = 20, .max_bodies = 40}).model);
    Tree tree(model);
    State state = start_state(model, tree);
    Workspace<double> workspace(tree);
    Evaluator evaluate(tree, workspace);
    const std::unique_ptr<Integrator> method = make_integrator("rk4", tree);
    EnergyLedger ledger;
    oracle::Prng draw(seed);
    evaluate(state);

    const long before = allocations;
    int breaks = 0, steps = 0;
    double sum = 0;
    for (int left = tree.bodies(); left > 0; --left) {
      const int first = draw.integer(0, tree.bodies() - 1);
      for (int k = 0; k < tree.bodies(); ++k) {
        const BodyId body{(first + k) % tree.bodies()};
        if (!can_break(tree, tree.inboard_joint(body))) continue;
        evaluate(state);
        sum += apply(Break{tree.inboard_joint(body)}, tree, state, workspace).energy;
        ++breaks;
        break;
      }
      for (int i = 0; i < 2; ++i) {
        evaluate(state);
        steps += method->step(evaluate, state, ledger, 1e-5);
      }
      sum += totals(tree, state, workspace).kinetic;
      accelerate(tree, state, workspace);
      sum += norm(reaction(tree, state, workspace, tree.inboard_joint({first})).force) +
             norm(body_acceleration(tree, state, workspace, BodyId{first}).linear);
    }
    const long during = allocations - before;
    CHECK(during == 0);
    CHECK(breaks > 0);
    CHECK(steps == 2 * tree.bodies());
    CHECK(sum > 0);
  }
}

TEST_CASE("no change allocates, in the original or in a copy") {
  const Model model = in_the_wind(oracle::random_tree(12, {.min_bodies = 15, .max_bodies = 15, .all_free = true}).model);
  const Tree original(model);
  Tree tree(original);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  oracle::Prng draw(5);
  const JointParameters parameters{.damping = 0.1, .friction = {0.1, 0.1}, .drive = effort_drive({})};
  const long before = allocations;
  int changes = 0;
  for (int k = 0; k < 400; ++k) {
    const BodyId body{draw.integer(0, tree.bodies() - 1)};
    const BodyId to{draw.integer(0, tree.bodies() - 1)};
    forward_dynamics(tree, state, workspace);
    switch (draw.integer(0, 6)) {
      case 6: {
        const int spring = draw.integer(0, tree.springs().count() - 1);
        if (k % 20 == 0 && spring_acts(tree, spring)) apply(BreakSpring{{spring}}, tree, state, workspace), ++changes;
        if (spring_acts(tree, spring)) apply(SetSpring{{spring}, {.stiffness = 3, .rest = 1}}, tree, state, workspace), ++changes;
        break;
      }
      case 0:
        if (can_break(tree, tree.inboard_joint(body))) apply(Break{tree.inboard_joint(body)}, tree, state, workspace), ++changes;
        break;
      case 1:
        if (tree.parent(body.index) >= 0) apply(Lock{tree.inboard_joint(body)}, tree, state, workspace), ++changes;
        break;
      case 2: apply(Unlock{tree.inboard_joint(body)}, tree, state, workspace), ++changes; break;
      case 3:
        if (floats(tree, body)) apply(Reroot{body}, tree, state, workspace), ++changes;
        break;
      case 4:
        if (tree.parent(body.index) >= 0)
          apply(SetParameters{tree.inboard_joint(body), parameters}, tree, state, workspace), ++changes;
        break;
      default:
        if (floats(tree, body) && root_of(tree, body).index != root_of(tree, to).index)
          apply(Join{body, to}, tree, state, workspace), ++changes;
    }
  }
  const long during = allocations - before;
  CHECK(during == 0);
  CHECK(changes > 200);
}

TEST_CASE("a simulation steps without allocating, by every method") {
  const Model model = in_the_wind(oracle::random_tree(2, {.min_bodies = 30, .max_bodies = 30}).model);
  for (const std::string& method : integration_methods()) {
    CAPTURE(method);
    Simulation run(model, {.method = method, .step = 1e-5});
    REQUIRE(run.step(1e-5) == Status::ok);
    const long before = allocations;
    Status status = Status::ok;
    for (int i = 0; i < 100 && status == Status::ok; ++i) status = run.step(1e-5);
    const long stepping = allocations - before;
    status = run.run_until(3e-3);
    const long running = allocations - before - stepping;
    CHECK(status == Status::ok);
    CHECK(stepping == 0);
    CHECK(running == 0);
  }
}

TEST_CASE("steps with drives, motions, functions and strengths allocate nothing") {
  Model model = oracle::random_tree(4, {.min_bodies = 20, .max_bodies = 20, .drives = true}).model;
  JointStrength strength{.force = 1e9, .torque = 1e9};
  Revolute driven{.damping = 0.1, .drive = motion_drive(Signal::sine(0.2, 1)), .strength = strength};
  const BodyId moved = model.add(
      {.name = "a mechanism with a long name/moved", .mass = 1, .inertia = diagonal(0.1), .parent = {3}, .joint = driven});
  const BodyId asked = model.add({.name = "a mechanism with a long name/asked",
                                  .mass = 1,
                                  .inertia = diagonal(0.1),
                                  .parent = moved,
                                  .joint = Revolute{.axis = x_axis}});
  for (const char* method : {"rk4", "dopri5"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method, .step = 1e-4});
    sim.drive("a mechanism with a long name/asked", [=](const EvaluationContext& m) {
      return m.motion(moved).linear.x - m.v({asked.index})[0] + (m.q({0}).empty() ? 0.1 : 0.2);
    });
    REQUIRE(sim.run_until(0.01) == Status::ok);
    const long before = allocations;
    const Status status = sim.run_until(0.05);
    const long during = allocations - before;
    CHECK(status == Status::ok);
    CHECK(during == 0);
  }
}

TEST_CASE("steps with stops and conditions allocate nothing") {
  Model model;
  BodyId last = ground;
  for (int k = 0; k < 6; ++k)
    last = model.add({.name = "a mechanism with a long name/link " + std::to_string(k),
                      .mass = 1,
                      .com = {0.2, 0, 0},
                      .inertia = diagonal(0.01),
                      .parent = last,
                      .at = {k == 0 ? 0.0 : 0.4, 0, 0},
                      .joint = Revolute{.axis = {0, 1, 0}, .limits = {.lower = -3, .upper = 3}}});
  Simulation sim(model, {.step = 1e-4});
  const std::string joint = model[BodyId{2}].joint_name, body = model[BodyId{5}].name;
  for (const Condition& c :
       {reaction_force(joint).exceeds(1e6), reaction_torque(joint).exceeds(1e6), reaction(joint, "fx").exceeds(1e6),
        position_of(joint).exceeds(2), speed_of(joint).exceeds(100), distance_between(body, "ground").below(0.01),
        height_of(body).below(-50), kinetic_energy_of("a mechanism with a long name").exceeds(1e6)})
    sim.when(c).then(lock(joint));
  REQUIRE(sim.run_until(0.01) == Status::ok);  // makes room
  const long before = allocations;
  const Status status = sim.run_until(0.05);
  const long during = allocations - before;
  CHECK(status == Status::ok);
  CHECK(sim.events().empty());
  CHECK(during == 0);
}

TEST_CASE("the equations of motion allocate nothing") {
  const Model model = in_the_wind(oracle::random_tree(7, {.min_bodies = 30, .max_bodies = 30, .drives = true}).model);
  const Tree tree(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  const auto n = static_cast<std::size_t>(tree.nv());
  std::vector<double> M(n * n), J(6 * n), c(n), tau(n);
  const long before = allocations;
  mass_matrix(tree, state, workspace, M.data());
  bias(tree, state, workspace, c.data());
  efforts(tree, state, workspace, tau.data());
  inverse_dynamics(tree, state, workspace, tau.data(), c.data());
  point_jacobian(tree, state, workspace, {20}, {1, 0, 0}, J.data());
  CHECK(allocations == before);
  CHECK(M[0] != 0);
}

TEST_CASE("arrays of a batch allocate nothing for each world") {
  const Model model = oracle::random_tree(4, {.min_bodies = 20, .max_bodies = 20}).model;
  constexpr int count = 300;
  for (const int threads : {1, 2})
    for (const Variables variables : {Variables::momenta, Variables::velocities}) {
      Batch batch(model, count, {.variables = variables, .threads = threads});
      std::vector<int> worlds;
      for (int i = 0; i < count; ++i) worlds.push_back(i * 7 % count);
      const auto row = [](int width) { return std::vector<double>(static_cast<std::size_t>(count * width)); };
      std::vector<double> time = row(1), q = row(batch.nq(0)), p = row(batch.nv(0)), v = p, motions = row(13);
      long before = 0;
      for (int call = 0; call < 2; ++call) {  // the first call may allocate working memory
        before = allocations;
        batch.read(worlds, time.data(), q.data(), p.data(), v.data());
        batch.momenta_of(worlds, q.data(), v.data(), p.data());
        batch.write(worlds, time.data(), q.data(), p.data());
        batch.write(worlds, time.data(), q.data(), v.data(), Variables::velocities);
        batch.set_efforts(worlds, v.data());
        batch.motions(worlds, {3}, motions.data());
      }
      CHECK(allocations - before < 10);
      batch.step(1e-4);
      before = allocations;
      for (int step = 0; step < 10; ++step) batch.step(1e-4);
      CHECK(allocations == before);
    }
}

namespace {
JointSpec pin() {
  JointSpec joint;
  joint.kind = Kind::revolute, joint.axis = y_axis;
  return joint;
}

// Parallelograms side by side: a crank on the ground, and a bar to the tip of the next crank, which a loop joint closes.
Model windows(int count, bool closed = true) {
  Model model;
  const auto name = [](const char* what, int i) { return "a mechanism with a long name/" + (what + std::to_string(i)); };
  const auto bar = [&](const std::string& called, BodyId parent, double at, double q) {
    return model.add({.name = called,
                      .mass = 1,
                      .com = {0.15, 0, 0},
                      .inertia = diagonal(1e-4, 0.01, 0.01),
                      .parent = parent,
                      .at = {at, 0, 0},
                      .joint = pin(),
                      .q = q});
  };
  std::vector<BodyId> cranks, bars;
  for (int i = 0; i <= count; ++i) cranks.push_back(bar(name("crank", i), ground, 0.4 * i, 0.7));
  for (int i = 0; i < count; ++i) bars.push_back(bar(name("bar", i), cranks[static_cast<std::size_t>(i)], 0.3, -0.7));
  for (std::size_t i = 0; closed && i < bars.size(); ++i) {
    LoopSpec loop{.name = name("pin", static_cast<int>(i)), .body = bars[i], .to = cranks[i + 1]};
    loop.joint = pin(), loop.joint.parameters.damping = 0.01;
    loop.at.position = {0.3, 0, 0}, loop.child_at.position = {0.4, 0, 0};
    model.add_loop(loop);
  }
  return model;
}
}  // namespace

TEST_CASE("steps with loops allocate nothing, nor do stops, conditions and dense output, by every method with loops") {
  for (const char* method : {"rk4", "midpoint", "dopri5", "dop853"}) {
    CAPTURE(method);
    Model model = windows(3);
    model.add({.name = "a mechanism with a long name/door",
               .mass = 1,
               .com = {0.1, 0, 0},
               .inertia = diagonal(0.01),
               .joint = Revolute{.axis = y_axis, .limits = {.lower = -3, .upper = 3, .restitution = 0.9}},
               .v = 3.0});
    Simulation sim(model, {.method = method, .step = 1e-3});
    const std::string crank = model[BodyId{0}].joint_name, loop = "a mechanism with a long name/pin0";
    for (Condition condition : {reaction_force(crank).exceeds(1e6), reaction_torque(loop).exceeds(1e6)}) {
      condition.least_norm = true;
      sim.when(condition).then(lock(crank));
    }
    for (const Condition& condition : {position_of(crank).exceeds(100), speed_of(crank).exceeds(1e4)})
      sim.when(condition).then(lock(crank));
    REQUIRE(sim.run_until(0.02) == Status::ok);  // makes room
    const long before = allocations;
    const Status status = sim.run_until(0.06);
    const long during = allocations - before;
    CHECK(status == Status::ok);
    CHECK(sim.world().loop_status().rank == 6);
    CHECK(sim.events().empty());
    CHECK(during == 0);
  }
}

TEST_CASE("worlds of a batch with loops are stepped without allocating, in several topologies") {
  for (const int threads : {1, 2})
    for (const Variables variables : {Variables::velocities, Variables::momenta}) {
      Batch batch(windows(3), 12, {.variables = variables, .threads = threads});
      const std::string loop = "a mechanism with a long name/pin";
      for (int world = 0; world < 3; ++world) batch.apply(world, break_joint(loop + std::to_string(world)));
      batch.apply(3, weld("a mechanism with a long name/bar0", "a mechanism with a long name/crank2"));
      for (int k = 0; k < 3; ++k) batch.apply(4, break_joint(loop + std::to_string(k)));
      batch.set_effort(5, {0}, 0, 0.1);
      CHECK(batch.groups() == 6);
      const long before = allocations;
      for (int step = 0; step < 10; ++step) batch.step(1e-3);
      CHECK(allocations == before);
      for (int world = 0; world < 12; ++world) CHECK_FALSE(batch.diverged(world));
    }
}

TEST_CASE("changes of loops allocate nothing, once there have been as many loops and rows") {
  const Model model = windows(4, false);
  Tree tree(model);
  State state = start_state(model, tree);
  Workspace<double> workspace(tree);
  oracle::Prng draw(5);
  const auto loop_between = [&](BodyId body, BodyId to) {
    MakeLoop change;
    change.loop.body = body.index, change.loop.to = to.index;
    change.loop.joint.kind = Kind::ball;
    const Pose at = user_pose(tree, locate_body(tree, state, workspace, body.index), body.index);
    change.loop.joint.at =
        to == ground ? at : inverse(user_pose(tree, locate_body(tree, state, workspace, to.index), to.index)) * at;
    return change;
  };
  long during = 0;
  int made = 0, set = 0, broken = 0, locked = 0;
  for (int round = 0; round < 40; ++round) {
    const long before = allocations;
    for (int k = 0; k < 6; ++k) {  // from bar to bar, and to the ground
      forward_dynamics(tree, state, workspace);
      const BodyId body{5 + draw.integer(0, 3)}, to{draw.integer(-1, 4)};
      if (tree.parent(body.index) == to.index) continue;
      const JointId loop = apply(loop_between(body, to), tree, state, workspace);
      ++made;
      forward_dynamics(tree, state, workspace);
      if (draw.chance(0.5)) {
        SetLoop lock{loop, tree.loops().back().joint, {}, Values{1, 0, 0, 0}, 0, true};
        lock.to.locked = 7;
        apply(lock, tree, state, workspace), ++set;
      }
      forward_dynamics(tree, state, workspace);
      apply(Lock{tree.inboard_joint(body)}, tree, state, workspace), ++locked;
      forward_dynamics(tree, state, workspace);
      apply(Unlock{tree.inboard_joint(body)}, tree, state, workspace);
    }
    forward_dynamics(tree, state, workspace);
    while (tree.has_loops()) {
      apply(BreakLoop{tree.loops()[0].id()}, tree, state, workspace), ++broken;
      forward_dynamics(tree, state, workspace);
    }
    if (round >= 20) during += allocations - before;
  }
  CHECK(during == 0);
  CHECK(made > 100);
  CHECK(broken == made);
  CHECK(set > 50);
  CHECK(locked > 100);
}
