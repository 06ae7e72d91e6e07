// Worlds with closed loops and exact couplings in batches move and change exactly as in simulations of their own.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/batch/batch.hpp>
#include <momentree/batch/lockstep.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>

using namespace momentree;

namespace {

constexpr double h = 0x1p-10;  // s; sums of such steps are exact

using Random = std::mt19937_64;
double uniform(Random& random, double low, double high) { return std::uniform_real_distribution(low, high)(random); }
Vec3 vector_of(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}
Pose pose_of(Random& random) {
  return {vector_of(random, 0.3), normalized(Quat{1, uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)})};
}

BodySpec body_of(Random& random, std::string name, BodyId parent, int kind) {
  BodySpec body{.name = std::move(name),
                .mass = uniform(random, 0.5, 2),
                .com = vector_of(random, 0.1),
                .inertia = diagonal(0.02, 0.025, 0.03),
                .parent = parent,
                .at = pose_of(random)};
  if (kind == 0)
    body.joint = Ball{.damping = 0.02}, body.q = {1, 0, 0, 0}, body.v = {uniform(random, -1, 1), 0, 0.3};
  else if (kind == 1)
    body.joint = Cylindrical{.axis = vector_of(random, 1) + x_axis, .damping = 0.1, .stiffness = 5.0}, body.q = {0.1, 0.02};
  else
    body.joint = Revolute{.axis = vector_of(random, 1) + y_axis, .damping = 0.05, .stiffness = 1.0},
    body.q = uniform(random, -1, 1), body.v = uniform(random, -2, 2);
  return body;
}

// Two arms on the ground whose tips a loop joint joins, and a mechanism that floats; the loop is closed as the bodies are.
Model two_arms(std::uint64_t seed, bool soft_parameters = true) {
  Random random(seed);
  Model model({.gravity = {0, 0, -3}});
  BodyId a = ground, b = ground;
  for (int k = 0; k < 4; ++k) a = model.add(body_of(random, "a/" + std::to_string(k), a, k == 2 ? 0 : 2));
  for (int k = 0; k < 3; ++k)
    b = model.add(body_of(random, "b/" + std::to_string(k), b, k == 1 ? static_cast<int>(seed % 3) : 2));
  model.add({.name = "c/hull", .mass = 2, .inertia = diagonal(0.1), .joint = Free{}, .q = {2, 0, 0, 1, 0, 0, 0}});
  const Simulation open(model);
  const auto pose = [&](BodyId body) { return open.world().motions()[static_cast<std::size_t>(body.index)].pose; };
  LoopSpec pin{.name = "pin", .body = a, .to = b};
  if (seed % 4 == 0)
    pin.joint = Revolute{.axis = z_axis, .damping = 0.1, .stiffness = soft_parameters ? 2.0 : 0.0};
  else if (seed % 4 == 1)
    pin.joint = Ball{.damping = 0.05};
  else if (seed % 4 == 2)
    pin.joint = Helical{.axis = z_axis, .pitch = 0.1, .damping = 0.05};
  else
    pin.joint = Universal{.axis = x_axis, .axis2 = y_axis};
  pin.child_at = pose_of(random);
  pin.at = inverse(pose(b)) * (pose(a) * pin.child_at);
  model.add_loop(pin);
  return model;
}

// A gear between two wheels, and a rack that follows one of them.
Model gears() {
  Model model;
  const BodyId one =
      model.add({.name = "g/one", .mass = 1, .inertia = diagonal(0.02), .joint = Revolute{.axis = y_axis}, .v = 3.0});
  const BodyId two =
      model.add({.name = "g/two", .mass = 2, .com = {0.1, 0, 0}, .inertia = diagonal(0.05), .joint = Revolute{.axis = y_axis}});
  const BodyId rack =
      model.add({.name = "g/rack", .mass = 1, .inertia = diagonal(0.01), .joint = Prismatic{.axis = z_axis, .stiffness = 10.0}});
  model.add_coupling({.joint = model.inboard_joint(two), .follows = model.inboard_joint(one), .multiplier = -0.5});
  model.add_coupling(
      {.joint = model.inboard_joint(rack), .follows = model.inboard_joint(two), .multiplier = 0.1, .higher = {0.02, 0, 0}});
  return model;
}

// A hydraulic cylinder that turns a boom, and at last is too long.
Model crane(JointParameters parameters = {.drive = motion_drive(Signal::ramp(2, 1.5))}) {
  Model model;
  const auto part = [&](const char* name, BodyId parent, Vec3 at, double com, double q) {
    return model.add({.name = name,
                      .mass = 10,
                      .com = {com, 0, 0},
                      .inertia = diagonal(0.1, 1, 1),
                      .parent = parent,
                      .at = Pose{at, Quat{}},
                      .joint = Revolute{.axis = {0, -1, 0}},
                      .q = q});
  };
  const BodyId boom = part("crane/boom", ground, {}, 1, 0.35), barrel = part("crane/barrel", ground, {0, 0, -0.8}, 0.3, 0.9);
  const BodyId rod = part("crane/rod", boom, {1, 0, 0}, -0.3, 0.5);
  LoopSpec cylinder{.name = "cylinder", .body = rod, .to = barrel};
  cylinder.joint = Prismatic{.axis = x_axis};
  cylinder.joint.parameters = parameters;
  model.add_loop(cylinder);
  return model;
}

double difference(std::span<const double> a, std::span<const double> b) {
  REQUIRE(a.size() == b.size());
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!(std::fabs(a[i] - b[i]) <= worst)) worst = std::fabs(a[i] - b[i]);  // NaN is kept
  return worst;
}

void check_equal(const Batch& batch, int world, const Simulation& sim, double tolerance = 0) {
  const State state = batch.state(world), other = sim.world().state();
  REQUIRE(state.variables() == other.variables());
  CHECK(state.time() == other.time());
  CHECK(difference(state.q(), other.q()) <= tolerance);
  CHECK(difference(state.y(), other.y()) <= tolerance);
  REQUIRE(batch.tree(world).loops().size() == sim.world().loops().size());
  for (const Loop& loop : batch.tree(world).loops()) {  // the angles of a state that no step has reached yet are not kept
    const JointId id{sim.world().loops()[static_cast<std::size_t>(batch.tree(world).loops().place(loop.id()))]};
    const JointView view = sim.world().joint(id);
    CHECK(batch.joint_name(world, loop.id()) == view.name);
    std::vector<double> q(view.q.size()), v(view.v.size());
    batch.read_loop(std::vector<int>{world}, loop.id(), q.data(), v.data());
    CHECK(difference(q, view.q) <= 1e-12 + tolerance);
    const bool converted = state.variables() == Variables::momenta;
    CHECK(difference(v, view.v) <= (converted ? 1e-9 : 1e-12) + 1e3 * tolerance);
  }
}

// An action at random, which may be impossible.
Action action_of(Random& random) {
  const auto among = [&](std::vector<std::string> names) { return names[random() % names.size()]; };
  const std::string joint = among({"pin", "a/0", "a/1", "a/2", "a/3", "b/0", "b/1", "b/2", "grasp", "pin"});
  const std::string body = among({"a/0", "a/1", "a/2", "a/3", "b/0", "b/1", "b/2", "c/hull"});
  const std::string other = among({"a/0", "a/2", "a/3", "b/0", "b/2", "c/hull", "ground"});
  switch (random() % 8) {
    case 0:
    case 1: return break_joint(joint);
    case 2: return lock(joint);
    case 3: return unlock(joint);
    case 4: return weld(body, other);
    case 5: return attach(body, other, Ball{.damping = 0.1});
    case 6: return set_parameters(joint, {.damping = 0.3});
    default: return impulse(body, {0.3, 0.1, -0.2});
  }
}

}  // namespace

TEST_CASE("worlds with loops equal simulations, whatever changes at whatever instants, for any number of threads") {
  int happened = 0, refused = 0, loops_made = 0, loops_left = 0, opened = 0;
  for (std::uint64_t seed = 0; seed < 16; ++seed)
    for (const std::optional<Variables> variables :
         {std::optional<Variables>(), std::optional(Variables::velocities), std::optional(Variables::momenta)}) {
      CAPTURE(seed);
      const Model model = two_arms(seed);
      constexpr int worlds = 9, steps = 40;
      Batch batch(model, worlds, {.variables = variables, .threads = seed % 2 == 0 ? 1 : 3});
      CHECK(batch.variables(0) == variables.value_or(Variables::velocities));
      std::vector<Simulation> alone;
      std::vector<Random> random;
      std::vector<char> away(worlds), in_lanes(worlds, variables == Variables::momenta ? 0 : 1);  // lanes round otherwise
      for (int world = 0; world < worlds; ++world) {
        alone.emplace_back(model, Integration{.method = "rk4", .variables = variables, .step = h});
        random.emplace_back(1000 * seed + static_cast<std::uint64_t>(world));
        check_equal(batch, world, alone.back());
        const World& now = alone.back().world();
        std::vector<double> v(now.v().begin(), now.v().end());
        for (double& x : v) x *= uniform(random.back(), 0.5, 1.5);  // which the loop does not allow
        const State start = now.state();
        alone.back().set_state(0, start.q(), v, Variables::velocities);
        State given(batch.tree(world), Variables::velocities);
        given.assign(0, start.q(), v, batch.tree(world));
        given.set_turns(start.turns());
        if (variables != Variables::momenta || world % 2 == 0) {
          const int number[] = {world};
          batch.write(number, nullptr, start.q().data(), v.data(), Variables::velocities);
        } else {
          batch.set_state(world, given);
        }
        check_equal(batch, world, alone.back(), 1e-12);
        if (variables != Variables::velocities)
          batch.set_state(world, [&] {  // the last bits of momenta of velocities
            State same(batch.tree(world), now.state().variables());
            same.assign(0, now.state().q(), now.state().y(), batch.tree(world));
            same.set_turns(now.state().turns());
            return same;
          }());
        check_equal(batch, world, alone.back());
      }
      for (int step = 0; step < steps; ++step) {
        batch.step(h);
        for (int world = 0; world < worlds; ++world) {
          Simulation& sim = alone[static_cast<std::size_t>(world)];
          CAPTURE(world);
          CAPTURE(step);
          if (away[static_cast<std::size_t>(world)] != 0) continue;
          if (sim.run_until((step + 1) * h) != Status::ok) {
            CHECK(batch.diverged(world));
            away[static_cast<std::size_t>(world)] = 1, ++opened;
            continue;
          }
          CHECK_FALSE(batch.diverged(world));
          if (sim.world().loops().empty()) in_lanes[static_cast<std::size_t>(world)] = 1;
          const double tolerance = in_lanes[static_cast<std::size_t>(world)] != 0 ? 1e-9 : 0;
          check_equal(batch, world, sim, tolerance);
          if (random[static_cast<std::size_t>(world)]() % 8 != 0) continue;
          const Action action = action_of(random[static_cast<std::size_t>(world)]);
          CAPTURE(action.text());
          const std::string name = action->key() == std::string_view("weld") || action->key() == std::string_view("attach")
                                       ? "grasp" + std::to_string(step)
                                       : "event" + std::to_string(step);
          const std::string why = error_of([&] { static_cast<void>(sim.apply(action, name)); });
          CHECK(error_of([&] {
                  const Event event = batch.apply(world, action, name);
                  if (sim.events().empty()) return;
                  const Event& last = sim.events().back();
                  CHECK(event.time == last.time);
                  CHECK(event.topology.gone == last.topology.gone);
                  CHECK(event.mechanisms_after == last.mechanisms_after);
                  CHECK(std::fabs(event.lost - last.lost) <= 1e-12 * (1 + last.before.kinetic) + tolerance);
                }) == why);
          ++(why.empty() ? happened : refused);
          check_equal(batch, world, sim, tolerance);
          loops_made += sim.world().loops().size() > 1 ? 1 : 0;
          loops_left += sim.world().loops().empty() ? 1 : 0;
        }
      }
    }
  CHECK(happened > 500);
  CHECK(refused > 100);
  CHECK(loops_made > 50);
  CHECK(loops_left > 50);
  CHECK(opened < 30);
}

TEST_CASE("worlds with couplings equal simulations, and extra efforts act as those of the model") {
  const Model model = gears();
  const Action actions[] = {break_joint("g/rack"), lock("g/one"), set_parameters("g/two", {.damping = 0.5}), break_joint("g/one"),
                            impulse("g/two", {0, 0, 1}, {}, {0.2, 0, 0})};
  constexpr int worlds = 10;
  for (const int threads : {1, 2}) {
    Batch batch(model, worlds, {.threads = threads});
    std::vector<Simulation> alone;
    for (int world = 0; world < worlds; ++world) {
      Simulation& sim = alone.emplace_back(model, Integration{.method = "rk4", .step = h});
      const double effort = world < 5 ? 0.0 : 0.4 * world;
      if (effort == 0) continue;
      batch.set_effort(world, {0}, 0, effort);
      static_cast<void>(sim.apply(set_parameters("g/one", {.effort = effort}), "driven"));
    }
    for (int step = 0; step < 60; ++step) {
      batch.step(h);
      for (int world = 0; world < worlds; ++world) {
        CAPTURE(world);
        Simulation& sim = alone[static_cast<std::size_t>(world)];
        REQUIRE(sim.run_until((step + 1) * h) == Status::ok);
        check_equal(batch, world, sim, 1e-11);
        if (step != 10 + 3 * world) continue;
        static_cast<void>(sim.apply(actions[world % 5], "change"));
        batch.apply(world, actions[world % 5], "change");
        if (batch.tree(world).has_loops())
          CHECK(batch.tree(world).loops().links.size() == sim.world().tree().loops().links.size());
      }
    }
    CHECK(batch.groups() >= 5);
  }
}

TEST_CASE("extra efforts with loops: in either variables, and they end with their joint when a loop joint takes its place") {
  const Model model = two_arms(0);
  for (const Variables variables : {Variables::velocities, Variables::momenta}) {
    Batch batch(model, 2, {.variables = variables});
    Simulation sim(model, {.method = "rk4", .variables = variables, .step = h});
    JointParameters driven = model.joint_spec(model.joint("a/1")).parameters;
    driven.effort = 0.7;
    static_cast<void>(sim.apply(set_parameters("a/1", driven), "driven"));
    batch.set_effort(1, model.joint("a/1"), 0, 0.7);
    for (int step = 0; step < 30; ++step) batch.step(h);
    REQUIRE(sim.run_until(30 * h) == Status::ok);
    check_equal(batch, 1, sim, 1e-11);
    CHECK(difference(batch.state(0).q(), batch.state(1).q()) > 1e-6);
    static_cast<void>(sim.apply(break_joint("a/1"), "cut"));
    batch.apply(1, break_joint("a/1"), "cut");
    CHECK(batch.joint_name(1, {1}) == "pin");
    CHECK(batch.joint_name(1, {first_loop}).empty());
    for (int step = 0; step < 30; ++step) batch.step(h);
    REQUIRE(sim.run_until(60 * h) == Status::ok);
    check_equal(batch, 1, sim, 1e-9);
    CHECK(error_of([&] { batch.set_effort(0, {first_loop}, 0, 1); }).find("closes a loop") != std::string::npos);
  }
}

TEST_CASE("states that are written are brought to closed ones") {
  const Model model = two_arms(1);  // two revolute joints, a ball
  Batch batch(model, 4, {.threads = 2});
  Simulation sim(model, {.method = "rk4", .step = h});
  const std::vector<int> worlds{3, 1};
  const State start = sim.world().state();
  std::vector<double> q(start.q().begin(), start.q().end()), v(start.u().begin(), start.u().end());
  const auto nq = q.size(), nv = v.size();
  for (std::size_t i = 0; i < 2; ++i) q[i] += 0.01 * static_cast<double>(i + 1);  // angles of the first arm
  sim.set_state(0.25, q, v, Variables::velocities);
  std::vector<double> all_q = q, all_v = v;
  all_q.insert(all_q.end(), q.begin(), q.end()), all_v.insert(all_v.end(), v.begin(), v.end());
  const double time[] = {0.25, 0.25};
  batch.write(worlds, time, all_q.data(), all_v.data(), Variables::velocities);
  for (const int world : worlds) check_equal(batch, world, sim);
  CHECK(difference(batch.state(1).q(), q) > 1e-4);
  std::vector<double> p(2 * nv), read_q(2 * nq), read_v(2 * nv);
  batch.read(worlds, nullptr, read_q.data(), p.data(), read_v.data());
  CHECK(difference({p.data(), nv}, sim.world().p()) < 1e-12);
  batch.write(worlds, nullptr, nullptr, p.data(), Variables::momenta);
  CHECK(difference(batch.state(3).u(), sim.world().v()) < 1e-10);

  std::vector<double> thirteen(13 * 2);
  batch.motions(worlds, {3}, thirteen.data());
  CHECK(norm(Vec3{thirteen[0], thirteen[1], thirteen[2]} - sim.world().motions()[3].pose.position) < 1e-12);
}

TEST_CASE("worlds with equal loops are one group, whatever loops other worlds had before") {
  const Model model = two_arms(1);
  Batch batch(model, 5);
  for (int step = 0; step < 3; ++step) batch.step(h);
  for (int k = 0; k < 3; ++k) {  // world 0 makes and breaks loops first
    batch.apply(0, weld("a/3", "b/0"), "clasp");
    batch.apply(0, break_joint("clasp"));
  }
  CHECK(batch.groups() == 1);
  for (const int world : {4, 0, 2}) {
    batch.apply(world, attach("a/1", "b/1", Ball{}), "grasp" + std::to_string(world));
    CHECK(batch.joint_name(world, {first_loop + 1}) == "grasp" + std::to_string(world));
  }
  CHECK(batch.group(4) == batch.group(2));
  CHECK(batch.groups() == 2);
  batch.apply(1, break_joint("pin"));
  batch.apply(3, break_joint("pin"));
  CHECK(batch.group(1) == batch.group(3));
  CHECK(batch.variables(1) == Variables::velocities);
  CHECK(batch.joint_name(0, {first_loop}) == "pin");
}

TEST_CASE("a world whose loops cannot be closed stops, and says so; the others go on") {
  const Model model = crane();
  Batch batch(model, 3);
  Simulation sim(model, {.method = "rk4", .step = h});
  double last = 0;
  while (sim.run_until(last + h) == Status::ok) {
    batch.step(std::vector<double>{h, 0.5 * h, h});
    last += h;
    REQUIRE(last < 1);
    check_equal(batch, 0, sim, 1e-11);
  }
  CHECK(last > 0.05);
  const State before = batch.state(0);
  for (int k = 0; k < 3; ++k) batch.step(std::vector<double>{h, 0.5 * h, h});
  CHECK(batch.diverged(0));
  CHECK(batch.diverged(2));
  CHECK_FALSE(batch.diverged(1));
  CHECK(batch.time(0) == last);
  CHECK(batch.time(1) == 0.5 * (last + 3 * h));
  CHECK(difference(batch.state(0).q(), before.q()) == 0);
  CHECK(difference(batch.state(0).u(), before.u()) == 0);

  const int two[] = {1, 0};
  const double times[] = {0.01, 9};  // at which the cylinder is too long
  const State kept = batch.state(1);
  const std::string why = error_of([&] { batch.write(two, times, nullptr, nullptr, Variables::velocities); });
  CHECK(why.find("loop 'cylinder' of world 0") != std::string::npos);
  CHECK(why.find("can't be closed") != std::string::npos);
  CHECK(batch.time(1) == kept.time());
  CHECK(difference(batch.state(1).q(), kept.q()) == 0);
  CHECK(batch.diverged(0));
  const double early[] = {0.01, 0.01};
  batch.write(two, early, nullptr, nullptr, Variables::velocities);
  CHECK_FALSE(batch.diverged(0));
  batch.step(h);
  CHECK(batch.time(0) == 0.01 + h);
  double q = 0;
  batch.read_loop(two, {first_loop}, std::vector<double>(2).data(), nullptr);
  batch.read_loop(std::span(two, 1), {first_loop}, &q, nullptr);
  CHECK(std::fabs(q - (1.5 + 2 * (0.01 + h))) < 1e-12);
}

TEST_CASE("what batches with loops do not support is an error") {
  const auto error = [](const Model& model, std::optional<Variables> variables = {}) {
    return error_of([&] { const Batch batch(model, 1, {.variables = variables}); });
  };
  CHECK(error(crane()).empty());
  CHECK(error(crane(), Variables::momenta).empty());
  CHECK(error(crane({.limits = {.lower = 0.5, .upper = 2.5}})).empty());
  CHECK(error(crane({.limits = {.lower = 0.5, .upper = 2.5, .stiffness = 1e4}})).empty());
  CHECK(error(crane({.strength = {.force = 1e6}})).find("do not determine its reaction") != std::string::npos);
  Batch batch(crane({}), 2, {.variables = Variables::momenta});
  CHECK(error_of([&] { batch.apply(0, set_parameters("cylinder", {.limits = {.upper = 3}})); }).find("hard stops") !=
        std::string::npos);
  CHECK(batch.groups() == 1);
}

TEST_CASE("no bit of a world with loops depends on those beside it or on the number of threads") {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Model model = seed < 4 ? two_arms(seed) : seed == 4 ? crane() : gears();
    constexpr int worlds = 11;
    std::vector<Batch> all;
    for (const int threads : {1, 3}) all.emplace_back(model, worlds, BatchOptions{.threads = threads});
    Random random(seed);
    std::vector<std::vector<double>> starts;
    for (int world = 0; world < worlds; ++world) {
      const State start = all[0].state(world);
      std::vector<double>& u = starts.emplace_back(start.u().begin(), start.u().end());
      for (double& x : u) x = seed == 4 ? 0 : x + uniform(random, -1, 1);
      const int one[] = {world};
      for (Batch& batch : all) batch.write(one, nullptr, start.q().data(), u.data(), Variables::velocities);
    }
    for (int step = 0; step < 25; ++step)
      for (Batch& batch : all) batch.step(h);
    for (int world = 0; world < worlds; ++world) {
      Batch alone(model, 1);
      const int one[] = {0};
      alone.write(one, nullptr, alone.state(0).q().data(), starts[static_cast<std::size_t>(world)].data(), Variables::velocities);
      for (int step = 0; step < 25; ++step) alone.step(h);
      for (Batch& batch : all) {
        CHECK(difference(batch.state(world).q(), alone.state(0).q()) == 0);
        CHECK(difference(batch.state(world).u(), alone.state(0).u()) == 0);
        CHECK(batch.state(world).turns() == alone.state(0).turns());
      }
    }
  }
}

TEST_CASE("simulations with loops run in lanes, and those whose loops break or are made change over") {
  const Model model = two_arms(2);
  CHECK(Lockstep::fits(Simulation(model, {.method = "rk4", .step = h})));
  CHECK_FALSE(Lockstep::fits(Simulation(model, {.method = "rk4", .variables = Variables::momenta, .step = h})));
  constexpr int count = 8;
  std::vector<Simulation> together, alone;
  for (int i = 0; i < count; ++i)
    for (std::vector<Simulation>* all : {&together, &alone}) {
      Simulation& sim = all->emplace_back(model, Integration{.method = "rk4", .step = h});
      sim.at((5 + i) * h).then(break_joint("pin"));
      if (i % 2 == 0) sim.at((20 + i) * h).then(weld("a/3", "b/1"));
    }
  Lockstep lockstep;
  std::vector<LockstepRun> runs;
  for (Simulation& sim : together) runs.push_back({&sim, 40 * h});
  lockstep.run(runs);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    REQUIRE(runs[i].result == Status::ok);
    REQUIRE(alone[i].run_until(40 * h) == Status::ok);
    CHECK(together[i].events().size() == alone[i].events().size());
    CHECK(together[i].world().loops().size() == alone[i].world().loops().size());
    CHECK(std::ranges::equal(together[i].world().state().q(), alone[i].world().state().q()));
    CHECK(std::ranges::equal(together[i].world().state().y(), alone[i].world().state().y()));
  }
}

TEST_CASE("edits of topology/change.hpp make and break loops in worlds, which then have names") {
  const Model model = two_arms(3);
  for (const Variables variables : {Variables::momenta, Variables::velocities}) {
    Batch batch(model, 3, {.variables = variables, .threads = 2});
    batch.step(h);
    batch.apply(0, BreakLoop{{first_loop}});
    CHECK_FALSE(batch.tree(0).has_loops());
    CHECK(batch.variables(0) == variables);
    batch.edit(1, [&](Tree& tree, State& state, Workspace<double>& workspace) {
      const Simulation posed = [&] {
        Simulation sim(model, {.method = "rk4", .variables = variables, .step = h});
        REQUIRE(sim.run_until(h) == Status::ok);
        return sim;
      }();
      Loop loop;
      loop.body = 3, loop.to = 4;
      loop.joint.kind = Kind::ball;
      const auto pose = [&](int body) { return posed.world().motions()[static_cast<std::size_t>(body)].pose; };
      loop.joint.at = inverse(pose(4)) * pose(3);
      apply(MakeLoop{loop}, tree, state, workspace);
    });
    REQUIRE(batch.tree(1).loops().size() == 2);
    CHECK(batch.variables(1) == variables);
    CHECK(batch.joint_name(1, {first_loop + 1}) == "loop 1");
    for (int k = 0; k < 20; ++k) batch.step(h);
    for (int world = 0; world < 3; ++world) CHECK_FALSE(batch.diverged(world));
    batch.apply(1, break_joint("loop 1"));
    batch.apply(1, break_joint("pin"));
    batch.step(h);
    CHECK(batch.groups() == 2);
    CHECK(batch.group(0) == batch.group(1));
  }
}
