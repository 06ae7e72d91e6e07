// Bodies with a collision that are added to a running world, and bodies that others touch and that are removed.
#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;
using oracle::Prng;

namespace {

constexpr double g = 9.81;

BodySpec floating(std::string name, const Vec3& at, Values v = {}, double mass = 1) {
  return {.name = std::move(name),
          .mass = mass,
          .inertia = diagonal(0.006 * mass),
          .joint = Free{},
          .q = {at.x, at.y, at.z, 1, 0, 0, 0},
          .v = std::move(v)};
}

Model with_floor(const ContactLaw& law = {}) {
  Model model;
  model.add_collider({.plane = true});
  model.add_contact_rule({.law = law});
  return model;
}

contact::Solid cube(double side = 0.2) { return contact::box({side, side, side}); }

contact::Solid random_solid(Prng& random) {
  switch (random.integer(0, 4)) {
    case 0: return contact::sphere(random.uniform(0.05, 0.15));
    case 1: return contact::capsule(random.uniform(0.04, 0.1), random.uniform(0.05, 0.2));
    case 2: return contact::cylinder(random.uniform(0.05, 0.15), random.uniform(0.1, 0.3));
    case 3: {
      std::vector<Vec3> points;
      for (int i = 0; i < 10; ++i) points.push_back(random.vector(0.12));
      return contact::hull(points);
    }
    default: return contact::box({random.uniform(0.1, 0.3), random.uniform(0.1, 0.3), random.uniform(0.1, 0.3)});
  }
}

BodySpec random_body(const std::string& name, double low, double high, double fast, Prng& random) {
  BodySpec body = floating(name, {random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25), random.uniform(low, high)}, {},
                           random.uniform(0.5, 3));
  const Quat turned = random.rotation();
  body.q[3] = turned.w, body.q[4] = turned.x, body.q[5] = turned.y, body.q[6] = turned.z;
  for (int i = 0; i < 6; ++i) body.v.push_back(random.uniform(-fast, fast));
  return body;
}

std::vector<double> all_of(Numbers numbers) { return {numbers.begin(), numbers.end()}; }

long count(const Simulation& sim, const std::string& name) {
  return std::count_if(sim.events().begin(), sim.events().end(), [&](const Event& e) { return e.name == name; });
}

Vec3 at(const Simulation& sim, int body) { return sim.world().motions()[static_cast<std::size_t>(body)].pose.position; }
Vec3 velocity(const Simulation& sim, int body) { return sim.world().motions()[static_cast<std::size_t>(body)].linear; }

double largest_difference(const Simulation& a, const Simulation& b) {
  double most = 0;
  REQUIRE(a.world().state().q().size() == b.world().state().q().size());
  for (std::size_t i = 0; i < a.world().state().q().size(); ++i)
    most = std::max(most, std::fabs(a.world().state().q()[i] - b.world().state().q()[i]));
  for (std::size_t i = 0; i < a.world().v().size(); ++i) most = std::max(most, std::fabs(a.world().v()[i] - b.world().v()[i]));
  return most;
}

}  // namespace

TEST_CASE("added: a body behaves as if it had been there from the start, whatever its shape and the method") {
  Prng random(20261);
  int hits = 0, refused = 0;
  for (int k = 0; k < 240; ++k) {
    const std::string method = std::array{"rk4", "dopri5", "dop853", "stepping"}[static_cast<std::size_t>(k % 4)];
    const Integration how{.method = method, .step = method == "stepping" ? 1e-3 : 5e-3};
    Model model =
        with_floor({.friction = 0.3, .static_friction = 0.4, .restitution = random.chance(0.5) ? random.uniform(0, 0.9) : 0.0});
    const BodyId first = model.add(random_body("one/one", 0.4, 0.8, 1, random));
    model.add_collider({.body = first, .solid = random_solid(random)});
    Simulation sim(model, how);
    REQUIRE(sim.run_until(0.1));
    const contact::Solid solid = random_solid(random);
    std::vector<double> q = all_of(sim.world().state().q()), v = all_of(sim.world().v());
    BodySpec spec;
    for (;;) {  // where there is room; a try that is refused changes nothing
      spec = random_body("two/two", 0, 0.8, 2, random);
      const std::string error = error_of([&] { sim.add(spec, {solid}); });
      if (error.empty()) break;
      REQUIRE(error.find("overlap by ") != std::string::npos);
      REQUIRE(sim.world().model().size() == 1);
      ++refused;
    }
    const BodyId second = model.add(spec);
    model.add_collider({.body = second, .solid = solid});
    const BodySpec& complete = model[second];
    q.insert(q.end(), complete.q.begin(), complete.q.end());
    v.insert(v.end(), complete.v.begin(), complete.v.end());
    Simulation other(model, how);
    other.set_state(0.1, q, v, Variables::velocities);
    REQUIRE(sim.run_until(0.25));
    REQUIRE(other.run_until(0.25));
    CAPTURE(k);
    CHECK(largest_difference(sim, other) < 1e-12);
    hits += static_cast<int>(count(other, "impact"));
    const double scale = std::fabs(sim.energy().final) + std::fabs(sim.energy().work) + 1;
    CHECK(std::fabs(sim.energy().error - other.energy().error) < 1e-9 * scale);
    if (method != "rk4") CHECK(std::fabs(sim.energy().error) < 1e-6 * scale);  // its steps are long for bodies that roll quickly
  }
  CHECK(hits > 100);
  CHECK(refused > 50);
}

TEST_CASE("added: a box that exactly touches the floor rests there from that instant on") {
  for (const char* method : {"rk4", "dopri5", "dop853", "stepping"}) {
    Model model = with_floor();
    const BodyId ball = model.add(floating("ball/ball", {2, 0, 5}));
    model.add_collider({.body = ball, .solid = contact::sphere(0.1)});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.2));
    const BodyId box = sim.add(floating("box/box", {0, 0, 0.1}, {}, 2), {cube()});
    const bool located = std::string(method) != "stepping";
    if (located) {
      CHECK(count(sim, "rest") == 1);
      Vec3 force{};
      for (const ContactPoint& point : sim.world().contacts()) force += point.force;
      CHECK(norm(force - Vec3{0, 0, 2 * g}) < 1e-10);
    }
    REQUIRE(sim.run_until(0.5));
    CHECK(norm(at(sim, box.index) - Vec3{0, 0, 0.1}) < 1e-9);
    CHECK(norm(velocity(sim, box.index)) < 1e-9);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
    Vec3 force{};
    for (const ContactPoint& point : sim.world().contacts()) force += point.force;
    CHECK(norm(force - Vec3{0, 0, 2 * g}) < 1e-6);
  }
}

TEST_CASE("added: a body that arrives with a velocity hits what it touches at that instant, by Newton's law") {
  for (const double e : {0.0, 0.5, 1.0}) {
    Model model({.gravity = {0, 0, 0}});
    const BodyId one = model.add(floating("a/a", {0, 0, 0}, {0.5, 0, 0, 0, 0, 0}, 3));
    model.add_collider({.body = one, .solid = contact::sphere(0.1)});
    model.add_contact_rule({.law = {.friction = 0, .static_friction = 0, .restitution = e}});
    Simulation sim(model, {.method = "dop853"});
    REQUIRE(sim.run_until(1));
    const BodyId other = sim.add(floating("b/b", {0.7, 0, 0}, {-2, 0, 0, 0, 0, 0}), {contact::sphere(0.1)});
    REQUIRE(count(sim, "add") == 1);
    REQUIRE(count(sim, "impact") == 1);
    const Event& impact = sim.events().back();
    const double impulse = 0.75 * (1 + e) * 2.5, lost = 0.5 * 0.75 * (1 - e * e) * 6.25;
    CHECK(impact.time == 1.0);
    CHECK(norm(impact.contact.impulse) == doctest::Approx(impulse));
    CHECK(impact.lost == doctest::Approx(lost));
    CHECK(velocity(sim, one.index).x == doctest::Approx(0.5 - impulse / 3));
    CHECK(velocity(sim, other.index).x == doctest::Approx(-2 + impulse));
    REQUIRE(sim.run_until(2));
    CHECK(norm(3 * velocity(sim, 0) + velocity(sim, 1) - Vec3{-0.5, 0, 0}) < 1e-12);
    CHECK(sim.energy().lost_in_impacts == doctest::Approx(lost));
    CHECK(sim.energy().work == doctest::Approx(2));  // that of the body that came in
    CHECK(std::fabs(sim.energy().error) < 1e-12);
  }
}

TEST_CASE("added: an overlap names the pair and the depth, and changes nothing") {
  for (const char* method : {"rk4", "dop853", "stepping"}) {
    Model model = with_floor({.friction = 0.3, .static_friction = 0.3, .restitution = 0.5});
    const BodyId box = model.add(floating("box/box", {0, 0, 0.15}));
    model.add_collider({.body = box, .solid = cube()});
    Simulation sim(model, {.method = method, .step = 1e-3}), other(model, {.method = method, .step = 1e-3});
    for (Simulation* each : {&sim, &other}) REQUIRE(each->run_until(0.1));
    const std::string into_floor = error_of([&] { sim.add(floating("new/new", {1, 0, 0.09}), {cube()}); });
    CHECK(into_floor.find("'new/new' and 'ground' overlap by 0.01") != std::string::npos);
    const Vec3 middle = at(sim, 0);
    const std::string into_box = error_of([&] { sim.add(floating("new/new", middle + Vec3{0.15, 0, 0.02}), {cube()}); });
    CHECK(into_box.find("'box/box' and 'new/new' overlap by 0.05") != std::string::npos);
    CHECK(error_of([&] { sim.add(floating("new/new", {1, 0, 1}), {contact::Solid{}}); }) != "");
    CHECK(sim.world().model().size() == 1);
    CHECK(sim.world().model().colliders().size() == 2);
    CHECK(sim.events().size() == other.events().size());
    for (Simulation* each : {&sim, &other}) REQUIRE(each->run_until(0.5));
    CHECK(largest_difference(sim, other) == 0);
    CHECK(sim.energy().error == other.energy().error);
  }
  Model pendulum;
  pendulum.add({.name = "p/p", .mass = 1, .com = {1, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{.axis = {0, 1, 0}}});
  Simulation sim(pendulum, {.method = "midpoint"}), other(pendulum, {.method = "midpoint"});
  for (Simulation* each : {&sim, &other}) REQUIRE(each->run_until(0.1));
  CHECK(error_of([&] {
          sim.add(floating("new/new", {0, 5, 0}), {cube()});
        }).find("does not support contact") != std::string::npos);
  for (Simulation* each : {&sim, &other}) REQUIRE(each->run_until(0.2));
  CHECK(largest_difference(sim, other) == 0);
}

TEST_CASE("added: with resolve, what overlaps is pushed apart, and the energy of that is work") {
  for (const char* method : {"rk4", "dopri5", "stepping"}) {
    Model model = with_floor();
    for (const double x : {0.0, 3.0}) {
      const BodyId box = model.add(floating(x > 0 ? "far/far" : "box/box", {x, 0, 0.1}, {}, 4));
      model.add_collider({.body = box, .solid = cube()});
    }
    Simulation sim(model, {.method = method, .step = 1e-3, .resolve = true});
    REQUIRE(sim.run_until(0.1));
    const BodyId added = sim.add(floating("new/new", {0.18, 0, 0.1}), {cube()});
    // By the masses: the light box moves four times as far.
    CHECK(at(sim, 0).x == doctest::Approx(-0.02 / 5).epsilon(1e-6));
    CHECK(at(sim, added.index).x == doctest::Approx(0.18 + 4 * 0.02 / 5).epsilon(1e-6));
    CHECK(std::fabs(at(sim, added.index).x - at(sim, 0).x - 0.2) < 1e-12);
    CHECK(count(sim, "lift") == 0);
    REQUIRE(sim.run_until(0.4));
    CHECK(norm(at(sim, 1) - Vec3{3, 0, 0.1}) < 1e-9);
    CHECK(std::fabs(sim.energy().error) < 1e-9);
    const std::string held = error_of([&] {
      sim.add(
          {.name = "wall/wall", .mass = 1, .inertia = diagonal(1), .at = {3.15, 0, 0.1}, .joint = Prismatic{.axis = {1, 0, 0}}},
          {contact::box({0.2, 0.2, 5})});
    });
    CHECK(held.find("'wall/wall' and 'ground'") != std::string::npos);
    REQUIRE(sim.run_until(0.5));
    CHECK(norm(at(sim, 1) - Vec3{3, 0, 0.1}) < 1e-9);
  }
}

TEST_CASE("added: snapshots, branches and undo have the bodies with what they touch") {
  for (const char* method : {"rk4", "dop853", "stepping"}) {
    Model model = with_floor({.friction = 0.4, .static_friction = 0.4, .restitution = 0.4});
    const BodyId box = model.add(floating("box/box", {0, 0, 0.1}));
    model.add_collider({.body = box, .solid = cube()});
    Simulation sim(model, {.method = method, .step = 1e-3});
    sim.keep_history();
    REQUIRE(sim.run_until(0.1));
    const SimulationSnapshot early = sim.snapshot();
    sim.add(floating("ball/ball", {0.02, 0.01, 0.5}, {0, 0, -1, 3, 0, 0}), {contact::sphere(0.1)});
    const SimulationSnapshot added = sim.snapshot();
    REQUIRE(sim.run_until(0.3));
    const SimulationSnapshot late = sim.snapshot();
    Simulation branch = sim.branch();
    REQUIRE(sim.run_until(0.6));
    const std::vector<double> q = all_of(sim.world().state().q());
    REQUIRE(branch.run_until(0.6));
    CHECK(all_of(branch.world().state().q()) == q);

    sim.restore(early);
    CHECK(sim.world().model().colliders().size() == 2);
    // Another body takes the same number, with another solid.
    sim.add(floating("rod/rod", {0.3, 0, 0.3}), {contact::capsule(0.05, 0.3)});
    REQUIRE(sim.run_until(0.5));
    CHECK(std::fabs(at(sim, 1).z - 0.2) < 1e-3);  // the capsule stands on its cap, and would be lower as a sphere

    for (const SimulationSnapshot* from : {&late, &added}) {
      sim.restore(*from);
      REQUIRE(sim.run_until(0.3));
      REQUIRE(sim.run_until(0.6));
      CHECK(all_of(sim.world().state().q()) == q);
    }
    const auto add = std::find_if(sim.events().begin(), sim.events().end(), [](const Event& e) { return e.name == "add"; });
    REQUIRE(add != sim.events().end());
  }
}

TEST_CASE("added: what is joined to a body at rest is carried at once, and touches for it") {
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    Model model = with_floor();
    const BodyId box = model.add(floating("box/box", {0, 0, 0.1}, {}, 2));
    model.add_collider({.body = box, .solid = cube()});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.1));
    // It reaches beyond the box, and would tip it over if its foot did not stand on the floor.
    const BodyId arm = sim.add({.name = "box/arm",
                                .mass = 3,
                                .com = {0.3, 0, 0},
                                .inertia = diagonal(0.1),
                                .parent = box,
                                .at = {0.1, 0, 0},
                                .joint = Weld{}},
                               {contact::box({0.02, 0.02, 0.2}, {{0.5, 0, 0}, {}})});
    const auto force = [&](BodyId body) {
      double sum = 0;
      for (const ContactPoint& point : sim.world().contacts())
        if (point.one == body) sum += point.force.z;
      return sum;
    };
    CHECK(std::fabs(force(box) + force(arm) - 5 * g) < 1e-9);
    CHECK(force(arm) > 0);
    REQUIRE(sim.run_until(0.5));
    CHECK(norm(at(sim, box.index) - Vec3{0, 0, 0.1}) < 1e-9);
    sim.remove(arm);
    CHECK(std::fabs(force(box) - 2 * g) < 1e-9);
    sim.add({.name = "box/mast",
             .mass = 3,
             .com = {0.3, 0, 0},
             .inertia = diagonal(0.1),
             .parent = box,
             .at = {0.1, 0, 0},
             .joint = Weld{}});
    REQUIRE(sim.run_until(1));
    CHECK(at(sim, 2).z < 0.09);  // without a foot it tips over
  }
}

TEST_CASE("added: contact rules apply by name, and those without names to all") {
  Model model = with_floor({.friction = 0, .static_friction = 0, .restitution = 0});
  const BodyId crate = model.add(floating("crate/1", {0, 0, 0.1}));
  model.add_collider({.body = crate, .solid = cube()});
  model.add_contact_rule(
      {.other = {ground}, .law = {.friction = 0.5, .static_friction = 0.5, .restitution = 0}, .one_name = "crate/*"});
  model.add_contact_rule({.other = {ground}, .law = {.off = true}, .one_name = "ghost"});
  Simulation sim(model, {.method = "dop853"});
  REQUIRE(sim.run_until(0.1));
  const Values slides{1, 0, 0, 0, 0, 0};
  const BodyId rough = sim.add(floating("crate/2", {0, 1, 0.1}, slides), {cube()});
  const BodyId smooth = sim.add(floating("slab/1", {0, 2, 0.1}, slides), {cube()});
  const BodyId ghost = sim.add(floating("ghost/1", {0, 3, 0.1}, slides), {cube()});
  const SimulationSnapshot before = sim.snapshot();
  for (int again = 0; again < 2; ++again) {
    REQUIRE(sim.run_until(0.6));
    CHECK(at(sim, rough.index).x == doctest::Approx(1 / (2 * 0.5 * g)));
    CHECK(at(sim, smooth.index).x == doctest::Approx(0.5));
    CHECK(at(sim, ghost.index).z == doctest::Approx(0.1 - 0.5 * g * 0.25));
    sim.restore(before);
  }
  // A body and its parent pass through each other, as in a model.
  sim.add({.name = "crate/3", .mass = 1, .inertia = diagonal(0.1), .parent = crate, .at = {0, 0, 0.1}, .joint = Ball{}},
          {contact::sphere(0.08)});
  static_cast<void>(sim.when(touching("crate", "floor")));
  static_cast<void>(sim.when(touching("slab/1", "crate/3")));
  CHECK(error_of([&] { static_cast<void>(sim.when(touching("ghost/1", "floor"))); }).find("pass through each other") !=
        std::string::npos);
  CHECK(sim.run_until(0.6));
}

TEST_CASE("added: the first solids of a world, and a method that steps through them where it must") {
  Model model({.gravity = {0, 0, 0}});
  model.add(floating("point/point", {0, 9, 0}, {1, 0, 0, 0, 0, 0}));
  for (const char* method : {"rk4", "dopri5"}) {
    Simulation sim(model, {.method = method});
    REQUIRE(sim.run_until(0.5));
    const SimulationSnapshot before = sim.snapshot();
    const BodyId one = sim.add(floating("a/a", {0, 0, 0}, {1, 0, 0, 0, 0, 0}), {contact::sphere(0.1)});
    const BodyId other = sim.add(floating("b/b", {1.2, 0, 0}), {contact::sphere(0.1)});
    REQUIRE(sim.run_until(2));
    REQUIRE(count(sim, "impact") == 1);
    CHECK(std::fabs(sim.events().back().time - 1.5) < 1e-9);
    CHECK(velocity(sim, one.index).x == doctest::Approx(0.5));
    CHECK(velocity(sim, other.index).x == doctest::Approx(0.5));
    CHECK(at(sim, 0).x == doctest::Approx(2));
    sim.restore(before);
    CHECK_FALSE(sim.world().model().has_contact());
    REQUIRE(sim.run_until(2));
    CHECK(at(sim, 0).x == doctest::Approx(2));
  }
  // A table with nine feet, whose 36 corners are more than the points that are located.
  Simulation pile(with_floor(), {.method = "rk4", .step = 1e-3});
  std::vector<contact::Solid> feet;
  for (int i = 0; i < 9; ++i) feet.push_back(contact::box({0.2, 0.2, 0.2}, {0.5 * (i - 4), 0, 0}));
  pile.add(floating("c/c", {0, 0, 0.1}), feet);
  CHECK(count(pile, "stepping") == 1);
  REQUIRE(pile.run_until(0.05));
  double force = 0;
  for (const ContactPoint& point : pile.world().contacts()) force += point.force.z;
  CHECK(force == doctest::Approx(g));
  pile.add(floating("d/d", {0, 0, 1}), {cube()});  // forces stay until the next step
  force = 0;
  for (const ContactPoint& point : pile.world().contacts()) force += point.force.z;
  CHECK(force == doctest::Approx(g));
  REQUIRE(pile.run_until(1));
  CHECK(std::fabs(at(pile, 1).z - 0.3) < 1e-3);
}

TEST_CASE("removed: what lay on a body falls, and what lies elsewhere stays") {
  for (const char* method : {"rk4", "dop853", "stepping"}) {
    Model model = with_floor();
    for (const char* name : {"lower/b", "upper/b", "far/b"}) {
      const std::string which = name;
      const BodyId box = model.add(floating(which, {which == "far/b" ? 2.0 : 0.0, 0, which == "upper/b" ? 0.3 : 0.1}));
      model.add_collider({.body = box, .solid = cube()});
    }
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.1));
    const SimulationSnapshot stacked = sim.snapshot();
    sim.remove({0});
    for (const ContactPoint& point : sim.world().contacts()) CHECK((point.one.index == 2 && point.other == ground));
    REQUIRE(sim.run_until(0.2));
    CHECK(std::fabs(at(sim, 1).z - (0.3 - 0.5 * g * 0.01)) < 1e-9);
    CHECK(std::fabs(at(sim, 2).z - 0.1) < 1e-9);
    REQUIRE(sim.run_until(0.5));
    CHECK(std::fabs(at(sim, 1).z - 0.1) < 1e-5);
    CHECK(std::fabs(sim.energy().error) < 1e-6);
    sim.restore(stacked);
    REQUIRE(sim.run_until(0.5));
    CHECK(std::fabs(at(sim, 1).z - 0.3) < 1e-9);
    // What takes its place touches what was on it.
    sim.remove({0});
    sim.add(floating("lower/again", {0, 0, 0.1}), {cube()});
    REQUIRE(sim.run_until(0.6));
    CHECK(std::fabs(at(sim, 1).z - 0.3) < 1e-9);
  }
}
