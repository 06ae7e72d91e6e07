// Time stepping through contacts: closed forms, order, energy, piles, and runs that fall back to it.
#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/run_state.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using oracle::Prng;

namespace {

const Event* find_step_event(const Simulation& sim, const std::string& name) {
  const auto found = std::find_if(sim.events().begin(), sim.events().end(), [&](const Event& e) { return e.name == name; });
  return found == sim.events().end() ? nullptr : &*found;
}

BodySpec free_body(std::string name, const Vec3& at, const Quat& turned = {}) {
  return {.name = std::move(name),
          .mass = 1,
          .inertia = diagonal(0.006),
          .joint = Free{},
          .q = {at.x, at.y, at.z, turned.w, turned.x, turned.y, turned.z}};
}

void add_floor(Model& model, double friction, double restitution) {
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = restitution}});
}

// Boxes above each other, slightly askew.
Model falling_boxes(int count, Prng& random) {
  Model model;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(-0.04, 0.04), y = random.uniform(-0.04, 0.04), tilt = random.uniform(-0.2, 0.2);
    const BodyId box =
        model.add(free_body("b" + std::to_string(i) + "/b", {x, y, 0.2 + 0.3 * i}, {std::cos(tilt), std::sin(tilt), 0, 0}));
    model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
  }
  add_floor(model, 0.5, random.chance(0.5) ? 0.3 : 0.0);
  return model;
}

Model falling_chain(int links) {
  Model model;
  BodyId last{};
  for (int i = 0; i < links; ++i) {
    BodySpec link{.name = "chain/" + std::to_string(i), .mass = 0.5, .com = {0, 0, -0.1}, .inertia = diagonal(0.002)};
    if (i == 0) {
      link.joint = Free{};
      link.q = {0, 0, 0.2 * links + 0.2, std::cos(0.1), std::sin(0.1), 0, 0};
    } else {
      link.parent = last, link.at = {0, 0, -0.2};
      link.joint = Ball{.damping = {0.01, 0.01, 0.01}};
    }
    last = model.add(std::move(link));
    model.add_collider({.body = last, .solid = contact::capsule(0.03, 0.14, {0, 0, -0.1})});
  }
  add_floor(model, 0.5, 0.2);
  return model;
}

}  // namespace

TEST_CASE("stepping: a ball bounces and comes to rest, and the energy balance closes") {
  Model model;
  const BodyId ball = model.add(free_body("ball/ball", {0, 0, 1.1}));
  model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  add_floor(model, 0, 0.8);
  Simulation sim(model, {.method = "stepping", .step = 1e-3});
  // The first bounce reaches e² of the height.
  const double t1 = std::sqrt(2 / 9.81);
  REQUIRE(sim.run_until(t1 + 0.8 * t1));
  CHECK(sim.world().motions()[0].pose.position.z == doctest::Approx(0.1 + 0.64).epsilon(1e-5));
  REQUIRE(sim.run_until(6));
  CHECK(std::fabs(sim.world().motions()[0].pose.position.z - 0.1) < 1e-6);
  CHECK(norm(sim.world().motions()[0].linear) < 1e-9);
  CHECK(std::fabs(sim.energy().error) < 1e-9);
  CHECK(sim.energy().lost_in_impacts == doctest::Approx(9.81).epsilon(1e-5));
  CHECK(sim.events().empty());
}

TEST_CASE("stepping: a block on an incline stays, or slides as Coulomb's law says") {
  for (const double angle : {0.2, 0.6}) {
    Model model({.gravity = {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)}});
    const BodyId block = model.add(free_body("block/block", {0, 0, 0.1}));
    model.add_collider({.body = block, .solid = contact::box({0.2, 0.2, 0.2})});
    add_floor(model, 0.4, 0);
    Simulation sim(model, {.method = "stepping", .step = 1e-3});
    REQUIRE(sim.run_until(1));
    const BodyMotion& end = sim.world().motions()[0];
    const double slides = std::max(0.0, 9.81 * (std::sin(angle) - 0.4 * std::cos(angle)));
    CHECK(end.linear.x == doctest::Approx(slides).epsilon(1e-6));
    CHECK(end.pose.position.x == doctest::Approx(0.5 * slides).epsilon(1e-3));
    CHECK(std::fabs(end.pose.position.z - 0.1) < 1e-9);
    CHECK(std::fabs(sim.energy().error) < 1e-6);
    // The evaluation of the state has the forces of contacts.
    CHECK(norm(sim.world().accelerations()[0].linear - Vec3{slides, 0, 0}) < 1e-6);
  }
}

TEST_CASE("stepping: a sliding ball ends up rolling at 5/7 of its speed") {
  Model model;
  BodySpec body = free_body("ball/ball", {0, 0, 0.1});
  body.inertia = diagonal(0.4 * 0.01), body.v = {1, 0, 0, 0, 0, 0};
  const BodyId ball = model.add(std::move(body));
  model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
  add_floor(model, 0.3, 0);
  Simulation sim(model, {.method = "stepping", .step = 1e-3});
  REQUIRE(sim.run_until(1));
  CHECK(sim.world().motions()[0].linear.x == doctest::Approx(5.0 / 7).epsilon(1e-6));
}

TEST_CASE("stepping: a thrown ball with its mass aside ends where located contacts bring it, with order 1") {
  const auto end = [](const char* method, double step) {
    Model model;
    BodySpec body = free_body("box/box", {0, 0, 0.6});
    body.v = {1, 0, 0, 0.5, 1, -0.3};
    const BodyId box = model.add(std::move(body));
    model.add_collider({.body = box, .solid = contact::sphere(0.1, {0.03, 0, 0})});
    add_floor(model, 0.4, 0.3);
    Simulation sim(model, {.method = method, .step = step});
    REQUIRE(sim.run_until(0.6));
    return sim.world().motions()[0].pose.position;
  };
  const Vec3 exact = end("dop853", 1e-3);
  const double coarse = norm(end("stepping", 1e-3) - exact), fine = norm(end("stepping", 1e-4) - exact);
  CHECK(coarse < 2e-2);
  CHECK(fine < 0.3 * coarse);
}

TEST_CASE("stepping: boxes that fall on each other come to rest, never gain energy, and stay apart") {
  Prng random(7);
  for (int k = 0; k < 12; ++k) {
    Simulation sim(falling_boxes(2 + k % 5, random), {.method = "stepping", .step = 1e-3});
    const Totals at_start = sim.world().totals();
    const double energy = at_start.kinetic + at_start.potential;
    for (double t = 0.05; t < 2.5; t += 0.05) {
      REQUIRE(sim.run_until(t));
      const EnergyBalance balance = sim.energy();
      CHECK(balance.final <= energy + 0.02 * balance.largest_kinetic);
      CHECK(std::fabs(balance.error) < 0.03 * balance.largest_kinetic);
      for (const BodyMotion& body : sim.world().motions()) CHECK(body.pose.position.z > 0.095);
    }
    CAPTURE(k);
    REQUIRE(sim.run_until(6));
    const auto resting = sim.world().motions();
    REQUIRE(sim.run_until(7));
    for (std::size_t i = 0; i < resting.size(); ++i)
      CHECK(norm(sim.world().motions()[i].pose.position - resting[i].pose.position) < 1e-9);
  }
}

TEST_CASE("stepping: short steps do not change the forces of a body at rest") {
  Prng random(4);
  for (int k = 0; k < 20; ++k) {
    Model model;
    const BodyId box = model.add(free_body("box/b", {0, 0, 0.3}));
    model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
    add_floor(model, 0.5, 0);
    Simulation sim(model, {.method = "stepping", .step = 1e-3});
    REQUIRE(sim.run_until(1).status == Status::ok);
    const double frame = k == 0               ? 1.0 / 144
                         : random.chance(0.5) ? random.uniform(2e-4, 2e-2)
                                              : 3e-3 + random.uniform(-1, 1) * 1e-12;
    for (int i = 1; i < 100; ++i) {
      REQUIRE(sim.run_until(1 + i * frame).status == Status::ok);
      Vec3 on_floor{};
      for (const ContactPoint& contact : sim.world().contacts()) on_floor += contact.force;
      CHECK(norm(on_floor - Vec3{0, 0, 9.81}) < 1e-6);
    }
  }
}

TEST_CASE("stepping: momentum is exact without outer forces") {
  Prng random(8);
  for (int k = 0; k < 20; ++k) {
    Model model({.gravity = {}});
    for (int i = 0; i < 6; ++i) {
      BodySpec body = free_body("b" + std::to_string(i) + "/b", {0.35 * i, random.uniform(-0.05, 0.05), 0}, random.rotation());
      const Vec3 spin = random.vector(2), linear = {random.uniform(-1, 1) - 0.5 * i, 0, 0};
      const Vec3 own = transpose_times(rotation_matrix(Quat{body.q[3], body.q[4], body.q[5], body.q[6]}), linear);
      body.v = {own.x, own.y, own.z, spin.x, spin.y, spin.z};
      const BodyId id = model.add(std::move(body));
      model.add_collider({.body = id, .solid = contact::box({0.2, 0.15, 0.18})});
    }
    model.add_contact_rule({.law = {.friction = 0.4, .static_friction = 0.4, .restitution = 0.5}});
    Simulation sim(model, {.method = "stepping", .step = 1e-3});
    const Totals before = sim.world().totals();
    REQUIRE(sim.run_until(0.5));
    const Totals after = sim.world().totals();
    CHECK(norm(after.linear - before.linear) < 1e-9);    // of rk4
    CHECK(norm(after.angular - before.angular) < 2e-3);  // overlaps are removed at both ends of the normal, to the depth
    CHECK(after.kinetic <= before.kinetic + 1e-12);
    CHECK(sim.energy().lost_in_impacts > 0);
  }
}

TEST_CASE("stepping: runs in which contacts are too many or change too often go on, and say so") {
  for (const char* method : {"rk4", "dopri5"}) {
    Simulation sim(falling_chain(6), {.method = method, .step = 1e-3});
    const RunResult run = sim.run_until(1.6);
    INFO(run.reason);
    REQUIRE(run);
    CHECK(sim.world().time() == 1.6);
    CHECK(std::fabs(sim.energy().error) < 0.02 * sim.energy().largest_kinetic);
  }
  Model many;  // one body with nine feet
  const BodyId table = many.add(free_body("table/b", {0, 0, 0.1 + 0.3}));
  for (int i = 0; i < 9; ++i) many.add_collider({.body = table, .solid = contact::box({0.2, 0.2, 0.2}, {0.3 * i, 0, 0})});
  add_floor(many, 0.5, 0);
  Simulation sim(many, {.method = "rk4", .step = 1e-3});
  REQUIRE(sim.run_until(0.6));
  const Event* const began = find_step_event(sim, "stepping");
  REQUIRE(began != nullptr);
  CHECK(began->reason.find("points touch at once") != std::string::npos);
  CHECK(std::fabs(began->time - std::sqrt(2 * 0.3 / 9.81)) < 1e-9);
}

TEST_CASE("stepping: forces act from the start, where contacts were located before, and after other forces") {
  constexpr double weight = 9.81;
  for (const auto& [method, feet] : {std::pair("stepping", 1), std::pair("stepping", 9), std::pair("dop853", 9)}) {
    CAPTURE(method);
    Model model;  // it slides, and has a body on it; too many points to be located
    BodySpec spec = free_body("table/b", {0, 0, 0.1});
    spec.v = {1, 0, 0, 0, 0, 0};
    const BodyId table = model.add(std::move(spec));
    for (int i = 0; i < feet; ++i)
      model.add_collider({.body = table, .solid = contact::box({0.2, 0.2, 0.2}, {0.3 * (i - feet / 2), 0, 0})});
    model.add({.name = "table/rider", .mass = 1, .inertia = diagonal(0.006), .parent = table});
    model.add_collider({.body = model.add(free_body("stone/b", {0, 5, 9})), .solid = contact::sphere(0.1)});
    add_floor(model, 0.3, 0);
    Simulation sim(model, {.method = method, .step = 1e-3});
    sim.when(contact_force_between("table", "ground").below(1.99 * weight)).named("unloaded");
    sim.when(reaction_force("table/rider").below(0.99 * weight)).named("floats");
    sim.when(slip_between("table", "ground").below(0.5)).named("slow");
    const auto only_stepping = [](const Event& event) { return event.name == "stepping"; };
    REQUIRE(sim.run_until(0));
    CHECK(std::ranges::all_of(sim.events(), only_stepping));
    Vec3 sum{};
    for (const ContactPoint& point : sim.world().contacts()) {
      sum += point.force;
      CHECK(norm(point.slip - Vec3{1, 0, 0}) < 1e-12);
    }
    CHECK(norm(sum - 2 * weight * Vec3{-0.3, 0, 1}) < 1e-2 * weight);
    REQUIRE(sim.run_until(0.1));
    sim.set_gravity({0, 0, -weight});  // forces are found anew
    REQUIRE(sim.run_until(0.1));
    CHECK(std::ranges::all_of(sim.events(), only_stepping));
    REQUIRE(sim.run_until(0.2));
    const Event* const slow = find_step_event(sim, "slow");
    REQUIRE(slow != nullptr);
    CHECK(std::fabs(slow->time - 0.5 / (0.3 * weight)) < 1e-3);
    CHECK(find_step_event(sim, "unloaded") == nullptr);
    CHECK(find_step_event(sim, "floats") == nullptr);
  }
}

TEST_CASE("stepping: contacts are located again once nothing hits anything") {
  Model model;  // a table with nine feet, which breaks into one with five and one with four
  const BodyId left = model.add(free_body("table/left", {0, 0, 0.1 + 0.3}));
  const BodyId right =
      model.add({.name = "table/right", .mass = 1, .inertia = diagonal(0.006), .parent = left, .at = {{1.5, 0, 0}}});
  for (int i = 0; i < 9; ++i)
    model.add_collider({.body = i < 5 ? left : right, .solid = contact::box({0.2, 0.2, 0.2}, {0.3 * (i < 5 ? i : i - 5), 0, 0})});
  add_floor(model, 0.5, 0);
  Simulation sim(model, {.method = "rk4", .step = 1e-3});
  sim.at(0.8).then(break_joint("table/right"));
  REQUIRE(sim.run_until(3));
  const Event* const began = find_step_event(sim, "stepping");
  REQUIRE(began != nullptr);
  CHECK(std::fabs(began->time - std::sqrt(2 * 0.3 / 9.81)) < 1e-9);
  const Event* const ended = find_step_event(sim, "resume");
  REQUIRE(ended != nullptr);
  CHECK(ended->time >= 0.8);
  CHECK(sim.world().contacts().size() >= 6);
}

TEST_CASE("stepping: a run that is restored, or continued from its state, goes on to the bit") {
  Prng random(10);
  const Model model = falling_boxes(4, random);
  const auto make = [&] { return Simulation(model, {.method = "stepping", .step = 1e-3}); };
  const auto same = [](const Simulation& a, const Simulation& b) {
    return std::equal(a.world().state().q().begin(), a.world().state().q().end(), b.world().state().q().begin()) &&
           std::equal(a.world().state().u().begin(), a.world().state().u().end(), b.world().state().u().begin()) &&
           a.energy().error == b.energy().error;
  };
  Simulation through = make();
  REQUIRE(through.run_until(0.5));
  REQUIRE(through.run_until(0.9));
  Simulation restored = make();
  REQUIRE(restored.run_until(0.5));
  const SimulationSnapshot snapshot = restored.snapshot();
  const RunState state = restored.run_state();
  REQUIRE(restored.run_until(0.7));
  restored.restore(snapshot);
  REQUIRE(restored.run_until(0.9));
  CHECK(same(restored, through));
  Simulation continued = make();
  continued.continue_from(state);
  REQUIRE(continued.run_until(0.9));
  CHECK(same(continued, through));
}

TEST_CASE("stepping: closed loops stay closed, and drives that press are in the energy balance") {
  Model model;
  const BodyId frame = model.add({.name = "m/frame",
                                  .mass = 1,
                                  .inertia = diagonal(0.01),
                                  .joint = Free{},
                                  .q = {0, 0, 0.8, std::cos(0.2), std::sin(0.2), 0, 0}});
  const BodyId one = model.add({.name = "m/one",
                                .mass = 0.5,
                                .com = {0, 0, -0.2},
                                .inertia = diagonal(0.005),
                                .parent = frame,
                                .at = {-0.2, 0, 0},
                                .joint = Revolute{{0, 1, 0}},
                                .q = {0.2}});
  const BodyId two = model.add({.name = "m/two",
                                .mass = 0.5,
                                .com = {0, 0, -0.2},
                                .inertia = diagonal(0.005),
                                .parent = frame,
                                .at = {0.2, 0, 0},
                                .joint = Revolute{{0, 1, 0}},
                                .q = {0.2}});
  const BodyId bar = model.add({.name = "m/bar",
                                .mass = 0.5,
                                .com = {0.2, 0, 0},
                                .inertia = diagonal(0.005),
                                .parent = one,
                                .at = {0, 0, -0.4},
                                .joint = Revolute{{0, 1, 0}},
                                .q = {-0.2}});
  LoopSpec loop;
  loop.name = "m/close", loop.body = bar, loop.to = two;
  loop.at.position = {0, 0, -0.4}, loop.child_at.position = {0.4, 0, 0};
  loop.joint = Revolute{{0, 1, 0}};
  model.add_loop(loop);
  model.add_collider(
      {.body = bar, .solid = contact::capsule(0.03, 0.3, {{0.2, 0, 0}, {0.7071067811865476, 0, 0.7071067811865476, 0}})});
  model.add_collider({.body = frame, .solid = contact::box({0.4, 0.1, 0.06})});
  add_floor(model, 0.5, 0.2);
  Simulation sim(model, {.method = "stepping", .step = 1e-3});
  const RunResult run = sim.run_until(1.5);
  INFO(run.reason);
  REQUIRE(run);
  CHECK(sim.world().totals().loops.residual < 1e-9);
  const EnergyBalance balance = sim.energy();
  CHECK(balance.lost_in_impacts > 0.1);
  CHECK(std::fabs(balance.error) < 0.02 * balance.largest_kinetic);
}

TEST_CASE("stepping: max_step limits the motion between impulses, not these") {
  const Model model = falling_chain(12);  // which swings fast enough that long steps lose its energy
  const auto error_in_flight = [&](double step, double max_step) {
    Simulation sim(model, {.method = "stepping", .step = step, .max_step = max_step});
    std::vector<double> q(sim.world().state().q().begin(), sim.world().state().q().end()), v;
    q[2] += 100;
    for (int i = 0; i < sim.world().tree().nv(); ++i) v.push_back(4 * std::sin(i));
    sim.set_state(0, q, v, Variables::velocities);
    REQUIRE(sim.run_until(0.5));
    CHECK(sim.statistics().steps == std::lround(0.5 / step));
    return std::fabs(sim.energy().error);
  };
  const double whole = error_in_flight(0.01, HUGE_VAL), parts = error_in_flight(0.01, 0.001),
               same = error_in_flight(0.001, HUGE_VAL);
  CHECK(parts < 0.01 * whole);
  CHECK(parts == doctest::Approx(same).epsilon(0.01));
  // Bodies that lie on the floor stay there, and impulses are those of the whole step.
  Prng random(5);
  Simulation pile(falling_boxes(3, random), {.method = "stepping", .step = 2e-3, .max_step = 5e-4});
  REQUIRE(pile.run_until(2));
  CHECK(std::fabs(pile.energy().error) < 1e-3);
  CHECK(pile.world().totals().kinetic < 1e-3);
}

TEST_CASE("stepping: a body that passes through another one within a step is named with a remedy that helps") {
  for (const double aside : {0.0, 0.7})
    for (const double speed : {3e5, 300.0}) {
      const auto run = [&](const char* method, double step) {
        Model model({.gravity = {}});
        BodySpec bullet = free_body("bullet", {-5, aside, 0});
        bullet.v = {speed, 0, 0, 0, 0, 0};
        model.add_collider({.body = model.add(bullet), .solid = contact::sphere(0.005)});
        model.add_collider({.body = model.add(free_body("plate", {})), .solid = contact::box({0.001, 1, 1})});
        Simulation sim(model, {.method = method, .step = step});
        REQUIRE(sim.run_until(speed > 1e3 ? 2e-3 : 0.03));
        return sim.warnings();
      };
      CAPTURE(aside);
      CAPTURE(speed);
      const std::vector<std::string> warnings = run("stepping", 1e-3);
      REQUIRE(warnings.size() == (aside == 0 && speed == 3e5 ? 1 : 0));
      if (warnings.empty()) continue;
      CHECK(warnings[0].find("'bullet' passed through 'plate' at t = ") == 0);
      const std::string before = "use steps of at most ";
      const double step = std::stod(warnings[0].substr(warnings[0].find(before) + before.size()));
      CHECK(run("stepping", step).empty());
      CHECK(run("dop853", 1e-3).empty());
    }
}

// Nothing moves, so that no force does work and no damper dissipates.
TEST_CASE("stepping: what presses a resting body does no work, and its damper dissipates nothing") {
  for (const double effort : {0.0, -50.0})
    for (const double stiffness : {0.0, 200.0}) {
      CAPTURE(effort);
      CAPTURE(stiffness);
      Model model;
      const BodyId box = model.add({.name = "box",
                                    .mass = 1,
                                    .inertia = diagonal(0.006),
                                    .joint = Prismatic{.damping = 80, .stiffness = stiffness, .rest = -1},
                                    .q = 0.1});
      model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
      add_floor(model, 0.5, 1);
      Simulation sim(model, {.method = "stepping", .step = 1e-3});
      sim.drive("box", [effort](const EvaluationContext&) { return effort; });
      REQUIRE(sim.run_until(0.5) == Status::ok);
      const EnergyBalance energy = sim.energy();
      const double press = 9.81 - effort + stiffness * 1.1, fall = 0.5 * press * 1e-6;  // in a step
      CHECK(std::fabs(sim.world().joint({0}).q[0] - 0.1) < 2 * fall);
      CHECK(std::fabs(energy.work) < 0.02 * (500 * 50 * fall) + 1e-9);
      CHECK(std::fabs(energy.dissipated) < 0.1 * press * fall * 500);
      CHECK(std::fabs(energy.lost_in_impacts) < 0.1 * press * fall * 500);
      CHECK(std::fabs(energy.error) < 1e-4 * press * fall * 500);
    }
}
