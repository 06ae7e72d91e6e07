// The forces at an instant at which contacts or cables begin to act, or anything else changes: joints stand on stops that only
// these press. All are weights and levers.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

constexpr double gravity = 9.81, seat_mass = 10, part_mass = 1;  // m/s², kg

struct Support {
  bool cable = false;  ///< the seat hangs by a hook, from a cable; or it stands with a leg on the floor
  double slack = 0;    ///< of the cable (m)
  JointSpec root = Free{};
  bool stop = true;  ///< the hook or leg stands at its stop; or it is welded to the seat
  bool locked = false;
};

// The seat is 0.5 m above the floor.
Model supported(const Support& how) {
  Model model({.gravity = {0, 0, -gravity}});
  BodySpec seat{.name = "seat", .mass = seat_mass, .inertia = diagonal(0.5), .joint = how.root};
  if (how.root.kind == Kind::free)
    seat.q = {0, 0, 0.5, 1, 0, 0, 0};
  else
    seat.at = {0, 0, 0.5};
  const BodyId above = model.add(seat);
  BodySpec part{.name = "part", .mass = part_mass, .inertia = diagonal(0.01), .parent = above, .joint = Weld{}};
  if (how.stop) part.joint = Prismatic{.axis = {0, 0, 1}, .limits = {.upper = 0}};
  part.at = {0, 0, how.cable ? 0.4 : -0.4};
  const BodyId id = model.add(part);
  if (how.cable) {
    model.add_cable({.name = "cable", .from = {ground, {0, 0, 1.9}}, .to = {id, {}}, .length = 1 + how.slack});
  } else {
    model.add_collider({.body = id, .solid = contact::box({0.2, 0.2, 0.2})});
    model.add_collider({.plane = true});
  }
  return model;
}

struct Forces {
  double between = 0, support = 0;  ///< N
};
Forces forces_in(const World& world) {
  Forces all{norm(world.reaction(world.model().joint("part")).force)};
  for (const ContactPoint& point : world.contacts()) all.support += point.force.z;
  if (world.springs() > 0) all.support += world.spring({0}).tension;
  return all;
}
constexpr double solved = 1e-4;  // by time stepping
void check_carried(const Forces& forces) {
  CHECK(forces.between == doctest::Approx(seat_mass * gravity).epsilon(solved));
  CHECK(forces.support == doctest::Approx((seat_mass + part_mass) * gravity).epsilon(solved));
}

std::optional<double> first_time(const Simulation& sim, const std::string& name) {
  for (const Event& event : sim.events())
    if (event.name == name) return event.time;
  return std::nullopt;
}

// Where the seat is carried, its whole weight goes through the joint of its leg.
void watch_load(Simulation& sim) {
  sim.when(reaction_force("part").exceeds(0.9 * seat_mass * gravity)).named("loaded");
  sim.when(reaction_force("part").below(0.9 * seat_mass * gravity)).named("unloaded");
}

constexpr const char* methods[] = {"dop853", "rk4", "stepping"};

}  // namespace

TEST_CASE("first forces: a run begins with those of stops that only a contact or a cable presses") {
  for (const char* method : methods)
    for (const bool cable : {false, true})
      for (const bool stop : {true, false}) {
        CAPTURE(std::string(method));
        CAPTURE(cable);
        CAPTURE(stop);
        Simulation sim(supported({.cable = cable, .stop = stop}), {.method = method, .step = 1e-3});
        watch_load(sim);
        std::vector<Forces> seen;
        sim.observe(0, [&](const World& world) {
          seen.push_back(forces_in(world));
          return true;
        });
        REQUIRE(sim.run_until(0));
        REQUIRE(seen.size() == 1);
        check_carried(forces_in(sim.world()));
        REQUIRE(sim.run_until(0.05));
        for (const Forces& forces : seen) check_carried(forces);
        CHECK(first_time(sim, "loaded") == 0);
        CHECK(first_time(sim, "unloaded").value_or(-1) == -1);
        CHECK(std::fabs(sim.energy().error) < 1e-9);
      }
}

TEST_CASE("first forces: a stop of a loop joint that only a contact presses carries from the start") {
  for (const char* method : methods) {
    CAPTURE(std::string(method));
    Model model({.gravity = {0, 0, -gravity}});
    const auto floating = [&](const char* name, double mass, double height) {
      return model.add({.name = name, .mass = mass, .inertia = diagonal(0.1), .joint = Free{}, .q = {0, 0, height, 1, 0, 0, 0}});
    };
    const BodyId seat = floating("seat", seat_mass, 0.5), leg = floating("leg", part_mass, 0.1);
    model.add_loop({.name = "slide",
                    .body = leg,
                    .to = seat,
                    .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.upper = 0}},
                    .at = {0, 0, -0.4}});
    model.add_collider({.body = leg, .solid = contact::box({0.2, 0.2, 0.2})});
    model.add_collider({.plane = true});
    Simulation sim(model, {.method = method, .step = 1e-3});
    constexpr double weight = (seat_mass + part_mass) * gravity;
    sim.when(contact_force_between("leg", "ground").exceeds(0.9 * weight)).named("loaded");
    sim.when(contact_force_between("leg", "ground").below(0.9 * weight)).named("unloaded");
    REQUIRE(sim.run_until(0.05));
    CHECK(first_time(sim, "loaded") == 0);
    CHECK_FALSE(first_time(sim, "unloaded"));
  }
}

TEST_CASE("first forces: a strength does not feel the fall of a beam whose end stands on a leg") {
  // Without the leg the hinge would carry the weight but for what its centre falls with.
  constexpr double a = 0.6, moment = 20, mass = 10, leg = 0.1;
  constexpr double held = mass * gravity * (1 - a);                             // the leg carries the rest, and itself
  constexpr double fallen = mass * gravity * moment / (moment + mass * a * a);  // at least
  static_assert(fallen > 1.5 * held);
  for (const char* method : methods)
    for (const bool cable : {false, true}) {
      CAPTURE(std::string(method));
      CAPTURE(cable);
      Model model({.gravity = {0, 0, -gravity}});
      Revolute hinge{.axis = {0, 1, 0}, .strength = {.force = 1.2 * held}};
      const BodyId beam = model.add({.name = "beam",
                                     .mass = mass,
                                     .com = {a, 0, 0},
                                     .inertia = diagonal(0.1, moment, moment),
                                     .at = {0, 0, 1},
                                     .joint = hinge});
      const BodyId end = model.add({.name = "end",
                                    .mass = leg,
                                    .inertia = diagonal(0.001),
                                    .parent = beam,
                                    .at = {1, 0, 0},
                                    .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.upper = 0}}});
      if (cable) {
        model.add_cable({.name = "cable", .from = {ground, {1, 0, 3}}, .to = {end, {}}});
      } else {
        model.add_collider({.body = end, .solid = contact::sphere(0.05, {0, 0, -0.95})});
        model.add_collider({.plane = true});
        model.add_contact_rule({.law = {.friction = 0, .static_friction = 0}});
      }
      Simulation sim(model, {.method = method, .step = 1e-3});
      REQUIRE(sim.run_until(0.02));
      CHECK_FALSE(first_time(sim, "strength of beam"));
      CHECK(norm(sim.world().reaction(model.joint("beam")).force) == doctest::Approx(held).epsilon(solved));
    }
}

TEST_CASE("first forces: what an event lets down on a stop is carried at that instant") {
  const Prismatic column{.axis = {0, 0, 1}};
  for (const char* method : methods)
    for (const bool cable : {false, true})
      for (const double time : {0.0, 0.1})
        for (const bool outside : {false, true}) {
          CAPTURE(std::string(method));
          CAPTURE(cable);
          CAPTURE(time);
          CAPTURE(outside);
          for (const bool breaks : {false, true}) {
            CAPTURE(breaks);
            Simulation sim(supported({.cable = cable, .root = breaks ? JointSpec(Weld{}) : JointSpec(column)}),
                           {.method = method, .step = 1e-3});
            if (!breaks) static_cast<void>(sim.apply(lock("seat")));
            const Action let_down = breaks ? break_joint("seat") : unlock("seat");
            if (!outside) sim.at(time).then(let_down);
            REQUIRE(sim.run_until(time));
            if (outside) {
              CHECK(forces_in(sim.world()).support == doctest::Approx(part_mass * gravity).epsilon(solved));
              static_cast<void>(sim.apply(let_down));
            }
            check_carried(forces_in(sim.world()));
            watch_load(sim);
            REQUIRE(sim.run_until(time + 0.05));
            CHECK(first_time(sim, "loaded") == time);
            CHECK(first_time(sim, "unloaded").value_or(-1) == -1);
          }
        }
}

TEST_CASE("first forces: what a lock lays on the floor is carried at that instant") {
  for (const char* method : methods)
    for (const double time : {0.0, 0.05}) {
      CAPTURE(std::string(method));
      CAPTURE(time);
      // A slider falls freely in a box that stands on the floor, until it is locked at rest.
      Model model({.gravity = {0, 0, -gravity}});
      const BodyId box =
          model.add({.name = "box", .mass = part_mass, .inertia = diagonal(0.1), .joint = Free{}, .q = {0, 0, 0.1, 1, 0, 0, 0}});
      model.add({.name = "slider",
                 .mass = seat_mass,
                 .inertia = diagonal(0.1),
                 .parent = box,
                 .joint = Prismatic{.axis = {0, 0, 1}},
                 .v = {gravity * time},
                 .joint_name = "part"});
      model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
      model.add_collider({.plane = true});
      Simulation sim(model, {.method = method, .step = 1e-3});
      sim.at(time).then(lock("part"));
      std::vector<Forces> seen;
      std::vector<double> times;
      sim.observe(0, [&](const World& world) {
        seen.push_back(forces_in(world)), times.push_back(world.time());
        return true;
      });
      watch_load(sim);
      REQUIRE(sim.run_until(time + 0.02));
      for (std::size_t k = 0; k < seen.size(); ++k)
        if (times[k] >= time)
          check_carried(seen[k]);
        else
          CHECK(seen[k].support == doctest::Approx(part_mass * gravity).epsilon(solved));
      CHECK(first_time(sim, "loaded") == time);
    }
}

TEST_CASE("first forces: a body that is added below a joint at its stop carries it at once") {
  for (const char* method : methods) {
    CAPTURE(std::string(method));
    Simulation sim(supported({.root = Prismatic{.axis = {0, 0, 1}}}), {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.05));
    sim.remove(sim.world().model().body("part"));
    sim.add({.name = "leg",
             .mass = part_mass,
             .inertia = diagonal(0.01),
             .parent = sim.world().model().body("seat"),
             .at = {0, 0, -0.4},
             .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.upper = 0}}},
            {contact::box({0.2, 0.2, 0.2})});
    double support = 0;
    for (const ContactPoint& point : sim.world().contacts()) support += point.force.z;
    CHECK(support == doctest::Approx((seat_mass + part_mass) * gravity).epsilon(solved));
    sim.when(contact_force_between("leg", "ground").below(0.9 * seat_mass * gravity)).named("unloaded");
    REQUIRE(sim.run_until(0.1));
    CHECK(first_time(sim, "unloaded").value_or(-1) == -1);
  }
}

TEST_CASE("first forces: a seat on three parts, legs on the floor or hooks on cables, weighs on them as levers say, or tips") {
  std::mt19937 random(5);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution<>(from, to)(random); };
  int tipped = 0;
  for (int k = 0; k < 60; ++k) {
    CAPTURE(k);
    const std::string method = methods[k % 3];
    const Vec3 com{uniform(-0.4, 0.4), uniform(-0.4, 0.4), 0};
    Model model({.gravity = {0, 0, -gravity}});
    const BodyId seat = model.add({.name = "seat",
                                   .mass = seat_mass,
                                   .com = com,
                                   .inertia = diagonal(1.5, 1.8, 2),
                                   .joint = Free{},
                                   .q = {0, 0, 0.5, 1, 0, 0, 0}});
    std::vector<Vec3> places;
    for (int i = 0; i < 3; ++i) {
      const double angle = (i + uniform(-0.2, 0.2)) * 2 * std::numbers::pi / 3;
      const bool cable = random() % 2 == 0;
      places.push_back({0.5 * std::cos(angle), 0.5 * std::sin(angle), cable ? 0.4 : -0.4});
      const std::string number = std::to_string(i);
      const BodyId part = model.add({.name = "part" + number,
                                     .mass = part_mass,
                                     .inertia = diagonal(0.01),
                                     .parent = seat,
                                     .at = places.back(),
                                     .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.upper = 0}}});
      if (cable)
        model.add_cable({.name = "cable" + number, .from = {ground, places.back() + Vec3{0, 0, 1.5}}, .to = {part, {}}});
      else
        model.add_collider({.body = part, .solid = contact::sphere(0.1)});
    }
    model.add_collider({.plane = true});
    model.add_contact_rule({.law = {.friction = 0, .static_friction = 0}});
    Simulation sim(model, {.method = method, .step = 1e-3, .rtol = 1e-10, .atol = 1e-12});
    const auto loads = [&] {
      std::vector<double> all;
      for (int i = 0; i < 3; ++i) all.push_back(norm(sim.world().reaction(model.joint("part" + std::to_string(i))).force));
      return all;
    };
    REQUIRE(sim.run_until(0));
    const std::vector<double> first = loads();
    // Barycentric coordinates of the centre of mass.
    const auto area = [](const Vec3& a, const Vec3& b, const Vec3& c) {
      return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    };
    const double all = area(places[0], places[1], places[2]);
    const double part[] = {area(com, places[1], places[2]) / all, area(places[0], com, places[2]) / all,
                           area(places[0], places[1], com) / all};
    if (std::min({part[0], part[1], part[2]}) > 0) {
      for (std::size_t i = 0; i < 3; ++i)
        CHECK(std::fabs(first[i] - part[i] * seat_mass * gravity) < solved * seat_mass * gravity);
      continue;
    }
    ++tipped;
    const std::size_t events = sim.events().size();
    REQUIRE(sim.run_until(1e-5));
    CHECK(sim.events().size() == events);
    const std::vector<double> then = loads();
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::fabs(first[i] - then[i]) < 1e-3 * seat_mass * gravity);
  }
  CHECK(tipped > 10);
}

// Where the method itself would locate contacts, their forces act only at the ends of steps: within these a stop holds nothing.
TEST_CASE("first forces: a stop that only stepped contacts press does not shorten the steps of another method") {
  for (const char* method : {"dop853", "rk4"}) {
    CAPTURE(std::string(method));
    Model model = supported({});
    for (int k = 1; k < 9; ++k)  // more points than are located
      model.add_collider({.body = model.body("part"), .solid = contact::box({0.2 - 0.01 * k, 0.2, 0.2})});
    model.add(
        {.name = "pendulum", .mass = 1, .com = {0.1, 0, 0}, .inertia = diagonal(0.1), .at = {3, 0, 2}, .joint = Revolute{}});
    Simulation sim(model, {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(0.02));
    CHECK(first_time(sim, "stepping") == 0);
    CHECK(sim.statistics().steps < 100);
    check_carried(forces_in(sim.world()));
  }
}
