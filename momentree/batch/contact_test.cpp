// Batches of worlds with contact and cables, which are stepped one by one: they have the bits of simulations, can be set, changed
// and driven as worlds in lanes, and tell what they touch.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/batch/batch.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/error_of.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81, h = 1e-3;

void add_floor(Model& model, double friction = 0.5) {
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = 0.3}});
}

BodySpec loose(std::string name, double z, double tilt = 0) {
  return {.name = std::move(name),
          .mass = 2,
          .inertia = diagonal(0.01, 0.012, 0.008),
          .joint = Free{},
          .q = {0, 0, z, std::cos(tilt), std::sin(tilt), 0, 0}};
}

// A ball, two boxes one of which lands on the other, and a chain of three links, above a floor.
Model dropped() {
  Model model;
  const BodyId ball = model.add(loose("ball", 0.4));
  model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  for (const double z : {0.25, 0.6}) {
    BodySpec box = loose(z < 0.5 ? "low" : "high", z, 0.1);
    box.q[0] = 1;
    model.add_collider({.body = model.add(std::move(box)), .solid = contact::box({0.2, 0.2, 0.2})});
  }
  BodyId last{};
  for (int i = 0; i < 3; ++i) {
    BodySpec link{.name = "chain/" + std::to_string(i), .mass = 0.5, .com = {0.1, 0, 0}, .inertia = diagonal(0.002)};
    if (i == 0) {
      link.joint = Free{};
      link.q = {2, 0, 0.15, 1, 0, 0, 0};
    } else {
      link.parent = last, link.at = {0.2, 0, 0};
      link.joint = Revolute{.axis = y_axis, .damping = 0.01};
    }
    last = model.add(std::move(link));
    model.add_collider({.body = last, .solid = contact::capsule(0.03, 0.1, {0.1, 0, 0})});
  }
  add_floor(model);
  return model;
}

// An arm that turns about y above the floor, with a ball at its end.
Model arm() {
  Model model;
  const BodyId rod = model.add({.name = "arm",
                                .mass = 2,
                                .com = {0.5, 0, 0},
                                .inertia = diagonal(0.01, 0.2, 0.2),
                                .at = {0, 0, 0.1},
                                .joint = Revolute{.axis = y_axis}});
  model.add_collider({.body = rod, .solid = contact::sphere(0.1, {1, 0, 0})});
  add_floor(model, 0);  // friction could carry a part of the load
  return model;
}

Model on_cable(double strength) {
  Model model;
  const BodyId load = model.add(loose("load", -0.5));
  Cable cable{.name = "tether", .length = 1.0};
  cable.to = {load, {}};
  cable.strength = strength;
  model.add_cable(cable);
  return model;
}

bool same_bits(const State& one, const State& other) {
  return one.time() == other.time() && one.variables() == other.variables() && std::ranges::equal(one.q(), other.q()) &&
         std::ranges::equal(one.y(), other.y());
}

// Another start of each world: higher, faster, and turned.
std::vector<double> start_of(const State& first, int world) {
  std::vector<double> q(first.q().begin(), first.q().end());
  oracle::Prng random(static_cast<std::uint64_t>(world) + 1);
  for (const std::size_t body : {0u, 7u, 14u, 21u}) q[body + 2] += random.uniform(0, 0.05);
  return q;
}

std::array<double, 3> force_on(const Batch& batch, int world, BodyId body) {
  const int one[] = {world};
  std::array<double, 3> force{};
  batch.contact_forces(one, body, force.data());
  return force;
}

}  // namespace

TEST_CASE("worlds with contact have the bits of simulations, for any number of threads") {
  const Model model = dropped();
  constexpr int worlds = 5;
  for (const char* method : {"stepping", "rk4"}) {
    CAPTURE(method);
    std::vector<Simulation> sims;
    std::vector<std::vector<double>> starts;
    for (int world = 0; world < worlds; ++world) {
      Simulation& sim = sims.emplace_back(model, Integration{.method = method, .step = h});
      const State& first = sim.world().state();
      starts.push_back(start_of(first, world));
      sim.set_state(0, starts.back(), std::vector<double>(first.y().size()), Variables::velocities);
    }
    constexpr int steps = 60;
    for (Simulation& sim : sims)
      for (int k = 0; k < steps; ++k) REQUIRE(sim.run_until(sim.time() + 5 * h));
    for (const int threads : {1, 2}) {
      Batch batch(model, worlds, {.threads = threads, .contact_method = method, .step = h});
      CHECK(batch.lanes() == 1);
      CHECK(batch.variables() == Variables::velocities);
      for (int world = 0; world < worlds; ++world) {
        const int one[] = {world};
        batch.write(one, nullptr, starts[static_cast<std::size_t>(world)].data(), nullptr);
      }
      for (int k = 0; k < steps; ++k) batch.step(5 * h);
      CHECK(batch.groups() == 1);
      for (int world = 0; world < worlds; ++world) {
        CAPTURE(world);
        const Simulation& sim = sims[static_cast<std::size_t>(world)];
        REQUIRE_FALSE(batch.diverged(world));
        CHECK(same_bits(batch.state(world), sim.world().state()));
        const std::vector<ContactPoint> points = batch.contacts(world), others = sim.world().contacts();
        REQUIRE(points.size() == others.size());
        for (std::size_t i = 0; i < points.size(); ++i) CHECK(points[i].force == others[i].force);
      }
    }
  }
}

TEST_CASE("a world whose state is set goes on as one that starts there") {
  const Model model = dropped();
  for (const char* method : {"stepping", "rk4"}) {
    CAPTURE(method);
    const BatchOptions options{.threads = 2, .contact_method = method, .step = h};
    Batch used(model, 3, options), fresh(model, 3, options);
    const State start = used.state(0);
    for (int k = 0; k < 40; ++k) used.step(0.01);
    const std::vector<int> two{0, 1};
    const std::vector<double> times(2), v(2 * start.y().size(), 0.1);
    std::vector<double> q;
    for (const int world : two) {
      const std::vector<double> row = start_of(start, world);
      q.insert(q.end(), row.begin(), row.end());
    }
    for (Batch* batch : {&used, &fresh}) batch->write(two, times.data(), q.data(), v.data(), Variables::velocities);
    used.set_state(2, start);
    CHECK(used.contacts(0).empty());
    CHECK(force_on(used, 0, {0})[2] == 0);
    for (int k = 0; k < 40; ++k)
      for (Batch* batch : {&used, &fresh}) batch->step(0.01);
    for (int world = 0; world < 3; ++world) {
      CAPTURE(world);
      REQUIRE_FALSE(used.diverged(world));
      CHECK(same_bits(used.state(world), fresh.state(world)));
      CHECK(used.contacts(world).size() == fresh.contacts(world).size());
    }
  }
}

TEST_CASE("actions in a world with contact are those of its simulation, and it joins the group of its new topology") {
  const Model model = dropped();
  for (const char* method : {"stepping", "rk4"}) {
    CAPTURE(method);
    Batch batch(model, 4, {.threads = 2, .contact_method = method, .step = h});
    Simulation sim(model, {.method = method, .step = h});
    for (int k = 0; k < 50; ++k) {
      batch.step(0.01);
      REQUIRE(sim.run_until(sim.time() + 0.01));
    }
    const Event event = batch.apply(2, break_joint("chain/1"), "cut"), other = sim.apply(break_joint("chain/1"), "cut");
    CHECK(event.name == "cut");
    CHECK(event.after.kinetic == other.after.kinetic);
    CHECK(batch.groups() == 2);
    CHECK(batch.group(2) == 1);
    CHECK(batch.joint_name(2, {4}) == sim.world().joint_name({4}));
    batch.step(0.01);
    REQUIRE(sim.run_until(sim.time() + 0.01));
    CHECK(same_bits(batch.state(2), sim.world().state()));
    // Changes of topology/change.hpp know no contacts; the next step finds them.
    batch.apply(0, Break{{4}});
    CHECK(batch.groups() == 2);
    batch.step(0.01);
    CHECK(batch.group(0) == batch.group(2));
    CHECK_FALSE(batch.contacts(0).empty());
    CHECK(batch.joint_name(0, {4}) == batch.joint_name(2, {4}));
    const std::vector<int> all{0, 2};
    std::vector<double> q(2 * static_cast<std::size_t>(batch.nq(0)));
    batch.read(all, nullptr, q.data(), nullptr, nullptr);
    CHECK(error_of([&] { batch.apply(1, break_joint("nothing")); }).find("'nothing'") != std::string::npos);
    CHECK(batch.apply(1, lock("chain/1")).name == "#1");
    batch.apply(2, Remove{{0}});
    CHECK(std::isnan(force_on(batch, 2, {0})[2]));
    batch.step(0.01);
    for (int world = 0; world < 4; ++world) CHECK_FALSE(batch.diverged(world));
  }
}

TEST_CASE("a cable that parts in a step moves the world to another group") {
  for (const char* method : {"stepping", "rk4"}) {
    CAPTURE(method);
    const Model model = on_cable(1.5 * 2 * g);
    Batch batch(model, 3, {.threads = 2, .contact_method = method, .step = h});
    State fast = batch.state(1);
    {
      const State::Edit edit = fast.edit();
      edit.q[2] = -1, edit.u[0] = 4;  // it swings: the cable carries more than its strength
    }
    batch.set_state(1, fast);
    batch.step(0.002);
    CHECK(batch.groups() == 2);
    CHECK(batch.group(1) == 1);
    const std::span<const Event> events = batch.events(1);
    CHECK(std::any_of(events.begin(), events.end(), [](const Event& e) { return e.name == "strength of tether"; }));
    CHECK(batch.events(0).empty());
    Simulation sim(model, {.method = method, .step = h});
    sim.set_state(0, fast.q(), fast.u(), Variables::velocities);
    REQUIRE(sim.run_until(0.002));
    CHECK(same_bits(batch.state(1), sim.world().state()));
    // It falls from then on.
    const double z = batch.state(1).q()[2], vz = batch.state(1).u()[2];
    for (int k = 0; k < 10; ++k) batch.step(0.01);
    CHECK(batch.state(1).q()[2] == doctest::Approx(z + vz * 0.1 - 0.5 * g * 0.01).epsilon(1e-9));
    CHECK(batch.events(1).empty());
    batch.edit(1, [&](Tree& tree, State& state, Workspace<double>&) { tree = batch.tree(0), state = batch.state(0); });
    CHECK(batch.groups() == 1);
  }
}

TEST_CASE("extra efforts and contact forces balance weight") {
  const Model model = arm();
  for (const char* method : {"stepping", "rk4"}) {
    CAPTURE(method);
    Batch batch(model, 4, {.threads = 2, .contact_method = method, .step = h});
    const std::vector<int> worlds{0, 1, 2, 3};
    const std::vector<double> efforts{0, -3, 3, -2 * g * 0.5};  // N m about y: negative ones lift the arm
    batch.set_efforts(worlds, efforts.data());
    for (int k = 0; k < 30; ++k) batch.step(0.01);
    std::vector<double> forces(12);
    batch.contact_forces(worlds, {0}, forces.data());
    for (std::size_t world = 0; world < 4; ++world) {
      CAPTURE(world);
      const double expected = 2 * g * 0.5 + efforts[world];  // at a lever arm of 1 m
      CHECK(forces[3 * world + 2] == doctest::Approx(expected).epsilon(1e-6).scale(1));
      CHECK(force_on(batch, static_cast<int>(world), ground)[2] == -forces[3 * world + 2]);
      CHECK(std::fabs(batch.state(static_cast<int>(world)).q()[0]) < 1e-9);
    }
    // Efforts change between steps, and are without effect along a locked DoF.
    batch.set_effort(0, {0}, 0, -3);
    batch.step(0.01);
    batch.contact_forces(worlds, {0}, forces.data());
    CHECK(forces[2] == doctest::Approx(2 * g * 0.5 - 3).epsilon(1e-6));
    batch.apply(0, lock("arm"));
    batch.set_effort(0, {0}, 0, -1e3);
    batch.step(0.01);
    CHECK(std::fabs(batch.state(0).q()[0]) < 1e-9);
    // As a driven simulation, to the last bit.
    Simulation sim(model, {.method = method, .step = h});
    sim.drive("arm", [](const EvaluationContext&) { return -12.0; });
    Batch driven(model, 1, {.contact_method = method, .step = h});
    driven.set_effort(0, {0}, 0, -12);
    for (int k = 0; k < 20; ++k) {
      driven.step(0.01);
      REQUIRE(sim.run_until(sim.time() + 0.01));
    }
    CHECK(sim.world().joint({0}).q[0] < -0.01);
    CHECK(same_bits(driven.state(0), sim.world().state()));
  }
}

TEST_CASE("the forces of contacts at rest are the weight, and events are those of the last step") {
  Model model;
  const BodyId box = model.add(loose("box", 0.1));
  model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
  const BodyId high = model.add(loose("high", 0.5));
  model.add_collider({.body = high, .solid = contact::sphere(0.1)});
  model.add_contact_rule({.one = {box}, .other = {high}, .law = {.off = true}});
  add_floor(model);
  Batch batch(model, 2, {.contact_method = "rk4", .step = h});
  CHECK(force_on(batch, 0, box)[2] == doctest::Approx(2 * g).epsilon(1e-9));  // also before the first step
  batch.step(0.01);
  batch.set_state(0, batch.state(0));
  CHECK(force_on(batch, 0, box)[2] == doctest::Approx(2 * g).epsilon(1e-9));
  CHECK(force_on(batch, 0, high)[2] == 0);
  CHECK(batch.contacts(1).size() == 4);
  bool hit = false;
  for (int k = 0; k < 100 && !hit; ++k) {
    batch.step(0.01);
    const std::span<const Event> events = batch.events(1);
    for (const Event& event : events) CHECK(event.time >= batch.time(1) - 0.0101);
    hit = std::any_of(events.begin(), events.end(), [](const Event& e) { return e.name == "impact"; });
  }
  CHECK(hit);
  batch.step(std::vector<double>{0.02, 0});
  CHECK(batch.time(0) == doctest::Approx(batch.time(1) + 0.02));
}

TEST_CASE("batches with contact: errors, and worlds that can't go on") {
  const Model model = dropped();
  Model deep;
  deep.add_collider({.body = deep.add(loose("sunk", 0.05)), .solid = contact::sphere(0.1)});
  add_floor(deep);
  CHECK(error_of([&] { const Batch batch(deep, 2); }).find("'sunk' and 'ground' overlap by 0.05 m") != std::string::npos);
  const std::string unknown = error_of([&] { const Batch batch(model, 2, {.contact_method = "euler"}); });
  CHECK(unknown.find("'euler'") != std::string::npos);
  CHECK(unknown.find("\"stepping\"") != std::string::npos);
  CHECK(error_of([&] { const Batch batch(model, 2, {.step = 0}); }).find("step") != std::string::npos);
  for (const char* method : {"stepping", "rk4"}) {
    CAPTURE(method);
    Batch batch(model, 2, {.contact_method = method, .step = h});
    const State start = batch.state(0);
    State sunk = start;
    sunk.edit().q[2] = 0.05;
    batch.set_state(0, sunk);
    batch.step(0.01);
    CHECK(batch.diverged(0));
    CHECK(batch.message(0).find("'ball' and 'ground' overlap by 0.05 m") != std::string::npos);
    CHECK(same_bits(batch.state(0), sunk));
    CHECK_FALSE(batch.diverged(1));
    CHECK(batch.message(1).empty());
    batch.step(0.01);
    CHECK(batch.time(0) == 0);
    batch.set_state(0, start);
    CHECK(batch.message(0).empty());
    batch.step(0.01);
    batch.step(0.01);
    CHECK(batch.time(0) == 0.02);
    CHECK(error_of([&] {
            batch.edit(0, [](Tree& tree, State& state, Workspace<double>& workspace) {
              static_cast<void>(workspace);
              tree.edit().add({.name = "more", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
              state = State(tree, Variables::velocities);
            });
          }).find("can't be added") != std::string::npos);
  }
}
