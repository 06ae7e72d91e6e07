// Inextensible cables: they become taut by an impact, hold, become slack and break.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>
#include <tests/oracle/prng.hpp>

using namespace momentree;

namespace {

constexpr double g = 9.81, length = 1.5, mass = 2;

// A load on a cable below the origin, at an angle (rad) from the vertical, or that far below the origin if it is slack.
Model hanging(double angle, Cable cable, Values v = {}, double distance = length) {
  Model model;
  const BodyId load = model.add({.name = "load",
                                 .mass = mass,
                                 .inertia = diagonal(0.1),
                                 .joint = Free{},
                                 .q = {distance * std::sin(angle), 0, -distance * std::cos(angle), 1, 0, 0, 0},
                                 .v = std::move(v)});
  cable.to = {load, {}};
  if (!cable.length) cable.length = length;
  model.add_cable(cable);
  return model;
}

Integration precise(std::string method = "dop853") {
  return {.method = std::move(method), .step = 1e-3, .rtol = 1e-11, .atol = 1e-12};
}

const Event* first(const Simulation& sim, const std::string& name) {
  const auto found = std::find_if(sim.events().begin(), sim.events().end(), [&](const Event& e) { return e.name == name; });
  return found == sim.events().end() ? nullptr : &*found;
}

Vec3 place(const Simulation& sim) { return sim.world().motions()[0].pose.position; }

// A body in space that moves and turns.
BodySpec floating(const std::string& name, oracle::Prng& random, double x) {
  const auto some = [&] { return random.uniform(-1, 1); };
  const double turn = random.uniform(0, 3);
  return {.name = name,
          .mass = random.uniform(0.5, 3),
          .com = {0.1 * some(), 0.1 * some(), 0.1 * some()},
          .inertia = diagonal(random.uniform(0.1, 0.3)),
          .joint = Free{},
          .q = {x, 0.1 * some(), 0.1 * some(), std::cos(turn), 0, std::sin(turn), 0},
          .v = {some(), some(), some(), some(), some(), some()}};
}

}  // namespace

TEST_CASE("cable: a load falls until it is taut and bounces at the instants of the closed form") {
  for (const char* method : {"rk4", "dopri5", "dop853"})
    for (const double e : {0.0, 0.4}) {
      Simulation sim(hanging(0, {.name = "tether", .restitution = e}, {}, 0.25), precise(method));
      REQUIRE(sim.run_until(4));
      double time = std::sqrt(2 * (length - 0.25) / g), speed = g * time;
      for (std::size_t k = 0; k < (e > 0 ? 5u : 1u); ++k) {
        const Event& taut = sim.events()[k];
        REQUIRE(taut.name == "taut tether");
        CHECK(taut.contact.cable == "tether");
        CHECK(std::fabs(taut.time - time) < 1e-9);
        CHECK(taut.contact.impulse.z == doctest::Approx(mass * (1 + e) * speed).epsilon(1e-8));
        CHECK(taut.lost == doctest::Approx(0.5 * mass * (1 - e * e) * speed * speed).epsilon(1e-7));
        speed *= e, time += 2 * speed / g;
      }
      CHECK(sim.world().spring({0}).tension == doctest::Approx(mass * g).epsilon(1e-10));
      CHECK(std::fabs(sim.world().spring({0}).length - length) < 1e-13);
      CHECK(std::fabs(sim.energy().error) < 1e-9);
      CHECK(sim.world().contacts().empty());  // bodies do not touch
    }
}

TEST_CASE("cable: while it is taut, a load is a pendulum; its tension follows the closed form") {
  const double start = 1.1;
  Simulation sim(hanging(start, {.name = "tether"}), precise());
  Model rigid;
  rigid.add(
      {.name = "rod", .mass = mass, .com = {0, 0, -length}, .inertia = {}, .joint = Revolute{.axis = {0, 1, 0}}, .q = {-start}});
  Simulation pendulum(rigid, precise());
  for (const double t : {0.3, 0.9, 2.7}) {
    REQUIRE(sim.run_until(t));
    REQUIRE(pendulum.run_until(t));
    const double angle = -pendulum.world().joint({0}).q[0];
    CHECK(norm(place(sim) - Vec3{length * std::sin(angle), 0, -length * std::cos(angle)}) < 1e-9);
    const SpringView tether = sim.world().spring({0});
    CHECK(tether.tension == doctest::Approx(mass * g * (3 * std::cos(angle) - 2 * std::cos(start))).epsilon(1e-9));
    CHECK(std::fabs(tether.length - length) < 1e-13);
    CHECK(tether.inextensible);
  }
}

TEST_CASE("cable: thrown upwards a load leaves its circle where the tension ends, and is caught") {
  for (const char* method : {"rk4", "dop853"}) {
    const double square = 4.2 * g * length;  // between 2 and 5 gL: the circle is not completed
    Simulation sim(hanging(0, {.name = "tether"}, {std::sqrt(square), 0, 0, 0, 0, 0}), precise(method));
    REQUIRE(sim.run_until(3));
    const Event* const slack = first(sim, "slack tether");
    REQUIRE(slack != nullptr);
    const double cosine = (square - 2 * g * length) / (3 * g * length);  // of its angle from the upward vertical
    CHECK(slack->contact.normal.z == doctest::Approx(-cosine).epsilon(1e-8));
    // On the parabola from there, the distance is the length again after 4 v_z/g for any such point of a circle.
    const double speed = std::sqrt(g * length * cosine), climb = speed * std::sqrt(1 - cosine * cosine);
    const auto taut =
        std::find_if(sim.events().begin() + 1, sim.events().end(), [](const Event& e) { return e.name == "taut tether"; });
    REQUIRE(taut != sim.events().end());
    CHECK(taut->time - slack->time == doctest::Approx(4 * climb / g).epsilon(1e-7));
    CHECK(taut->lost > 0);
    CHECK(std::fabs(sim.energy().error) < 1e-7);
  }
}

TEST_CASE("cable: it parts at its strength, at the instant") {
  const double start = 1.1, strength = 30;
  Simulation sim(hanging(start, {.name = "tether", .strength = strength}), precise());
  REQUIRE(sim.run_until(2));
  const Event* const parts = first(sim, "strength of tether");
  REQUIRE(parts != nullptr);
  // T = m g (3 cos a − 2 cos a₀), and v² = 2 g L (cos a − cos a₀).
  const double cosine = (strength / (mass * g) + 2 * std::cos(start)) / 3;
  CHECK(parts->before.kinetic == doctest::Approx(mass * g * length * (cosine - std::cos(start))).epsilon(1e-8));
  CHECK(parts->after.kinetic == doctest::Approx(parts->before.kinetic).epsilon(1e-14));
  CHECK(sim.world().spring({0}).broken);
  CHECK(sim.world().spring({0}).tension == 0);
  CHECK(first(sim, "slack tether") == nullptr);  // it is gone
  CHECK(std::fabs(sim.energy().error) < 1e-8);
}

TEST_CASE("cable: tethered bodies in space keep their momenta, gain no energy and are never too far apart") {
  oracle::Prng random(7);
  int impacts = 0;
  for (int k = 0; k < 60; ++k) {
    Model model({.gravity = {}});
    const BodyId a = model.add(floating("a/a", random, 0)), b = model.add(floating("b/b", random, 1));
    const BodyId tip =
        model.add({.name = "b/tip", .mass = 0.4, .inertia = diagonal(0.02), .parent = b, .at = {0.4, 0, 0}, .joint = Ball{}});
    const double e = k % 2 == 0 ? 0 : random.uniform(0, 1);
    model.add_cable({.name = "tether", .from = {a, {0.2, 0.1, 0}}, .to = {tip, {0.3, 0, 0}}, .length = 2.5, .restitution = e});
    Simulation sim(model, {.method = "dopri5", .rtol = 1e-10, .atol = 1e-11});
    const Totals start = sim.world().totals();
    REQUIRE(sim.run_until(4));
    const Totals end = sim.world().totals();
    CHECK(norm(end.linear - start.linear) < 1e-9);
    CHECK(norm(end.angular - start.angular) < 1e-8);
    CHECK(end.kinetic < start.kinetic + 1e-8);
    for (const Event& event : sim.events()) {
      if (event.name != "taut tether") continue;
      ++impacts;
      CHECK(event.lost > -1e-12);
      CHECK(norm(event.after.linear - event.before.linear) < 1e-12);
      CHECK(norm(event.after.angular - event.before.angular) < 1e-12);
    }
    CHECK(sim.world().spring({0}).length < 2.5 + 1e-9);
  }
  CHECK(impacts > 60);
}

TEST_CASE("cable: a crate on four cables shares its weight without any that pushes; one is cut") {
  Model model;
  const BodyId crate =
      model.add({.name = "crate", .mass = 20, .inertia = diagonal(1), .joint = Free{}, .q = {0.07, 0, -1, 1, 0, 0, 0}});
  for (const double x : {-0.3, 0.3})
    for (const double y : {-0.3, 0.3})
      model.add_cable({.name = "leg " + std::to_string(model.springs().size()), .to = {crate, {x, y, 0}}});
  Simulation sim(model, precise());
  const auto lift = [&] {
    double force = 0;
    for (int s = 0; s < 4; ++s) {
      const SpringView leg = sim.world().spring({s});
      CHECK(leg.tension > -1e-9);
      CHECK(leg.length < *model.springs()[static_cast<std::size_t>(s)].rest + 1e-9);
      force += leg.tension * (leg.place_of_from.z - leg.place_of_to.z) / leg.length;
    }
    return force;
  };
  const double a = sim.world().accelerations()[0].linear.z;
  CHECK(lift() == doctest::Approx(20 * (g + a)).epsilon(1e-9));
  sim.at(0.5).then(break_spring("leg 0"));
  REQUIRE(sim.run_until(1.5));
  lift();
  CHECK(sim.world().spring({0}).broken);
  CHECK(std::fabs(sim.energy().error) < 1e-6);
}

TEST_CASE("cable: stepped in time it ends near where the located one does") {
  const Model model = hanging(1.1, {.name = "tether", .restitution = 0.3}, {0, 0.4, 0, 0, 0, 0}, 1.2);
  Simulation located(model, precise()), stepped(model, {.method = "stepping", .step = 1e-4});
  REQUIRE(located.run_until(1));
  REQUIRE(stepped.run_until(1));
  CHECK(norm(place(located) - place(stepped)) < 5e-3);
  CHECK(stepped.world().spring({0}).tension == doctest::Approx(located.world().spring({0}).tension).epsilon(0.02));
  CHECK(std::fabs(stepped.energy().error) < 1e-6);
}

TEST_CASE("cable: stepped in time, a tension is along the cable, and causes the accelerations") {
  Model model;
  const BodyId load = model.add({.name = "load",
                                 .mass = mass,
                                 .inertia = diagonal(0.1),
                                 .joint = Free{},
                                 .q = {1, 0.2, -1, 1, 0, 0, 0},
                                 .v = {0, 1, 0, 0, 0, 0}});
  model.add_cable({.name = "tether", .to = {load, {0.1, 0.2, 0.3}}});
  Simulation sim(model, {.method = "stepping", .step = 2e-3});
  int taut = 0;
  for (int k = 1; k <= 20; ++k) {
    REQUIRE(sim.run_until(0.05 * k));
    const SpringView tether = sim.world().spring({0});
    taut += tether.tension > 0 ? 1 : 0;
    const Vec3 pull = (tether.tension / tether.length) * (tether.place_of_from - tether.place_of_to);
    const BodyAcceleration a = sim.world().accelerations()[0];
    const BodyMotion& motion = sim.world().motions()[0];
    CHECK(norm(mass * (a.linear - Vec3{0, 0, -g}) - pull) < 1e-12 * mass * g);
    CHECK(norm(0.1 * a.angular - cross(tether.place_of_to - motion.pose.position, pull)) < 1e-12 * mass * g);
  }
  CHECK(taut > 15);
}

TEST_CASE("cable: stepped in time, one that is cut, parts or becomes longer exerts no force from that instant on") {
  const auto falls_freely = [](Simulation& sim, double tension) {
    CHECK(sim.world().spring({0}).tension == 0);
    const BodyAcceleration a = sim.world().accelerations()[0];
    CHECK(norm(a.linear - Vec3{0, 0, -g}) < 1e-12);
    CHECK(norm(a.angular) < 1e-12);
    CHECK(step_memory(sim).stepping.points.empty());
    CHECK(tension == doctest::Approx(mass * g).epsilon(1e-6));
  };
  const double cut = 0.0123;
  for (const bool longer : {false, true}) {
    Simulation sim(hanging(0, {.name = "tether"}), {.method = "stepping", .step = 1e-3});
    REQUIRE(sim.run_until(0.01));
    const double before = sim.world().spring({0}).tension;
    sim.at(cut).then(longer ? set_parameters("tether", {.rest = 2}) : break_spring("tether"));
    REQUIRE(sim.run_until(cut));
    falls_freely(sim, before);
    REQUIRE(sim.run_until(cut + 0.1));
    CHECK(place(sim).z == doctest::Approx(-length - 0.5 * g * 0.01).epsilon(1e-9));
  }
  Simulation sim(hanging(0, {.name = "tether", .strength = 30}), {.method = "stepping", .step = 1e-3});
  REQUIRE(sim.run_until(0.01));
  const double before = sim.world().spring({0}).tension;
  sim.at(cut).then(set_parameters("tether", {.strength = {.force = 10}}));
  REQUIRE(sim.run_until(cut));
  REQUIRE(first(sim, "strength of tether") != nullptr);
  falls_freely(sim, before);
}

TEST_CASE("cable: stepped in time, the impulse by which one becomes taut parts nothing, as where it is located") {
  for (const char* method : {"dop853", "stepping"}) {
    CAPTURE(method);
    Simulation sim(hanging(0, {.name = "tether", .strength = 1.5 * mass * g}, {}, length - 0.5),
                   {.method = method, .step = 1e-3});
    REQUIRE(sim.run_until(1));
    CHECK(first(sim, "strength of tether") == nullptr);
    CHECK(sim.energy().lost_in_impacts == doctest::Approx(mass * g * 0.5).epsilon(1e-3));
    CHECK(sim.world().spring({0}).tension == doctest::Approx(mass * g).epsilon(1e-4));
  }
}

TEST_CASE("cable: a state of a run continues with the same bits") {
  Simulation sim(hanging(1.1, {.name = "tether"}), precise("rk4"));
  REQUIRE(sim.run_until(0.4));
  const SimulationSnapshot half = sim.snapshot();
  REQUIRE(sim.run_until(0.8));
  const Vec3 there = place(sim);
  sim.restore(half);
  REQUIRE(sim.run_until(0.8));
  CHECK(place(sim) == there);
}

TEST_CASE("cable: a longer one lets go, a shorter one is refused") {
  Simulation sim(hanging(0, {.name = "tether"}), precise());
  REQUIRE(sim.run_until(0.1));
  CHECK(error_of([&] {
          sim.apply(set_parameters("tether", {.rest = 1}));
        }).find("rest: the ends of the cable are 1.5 m apart, farther than 1 m") != std::string::npos);
  Simulation later = sim.branch();  // where its ends will be then is not known before
  later.at(1).then(set_parameters("tether", {.rest = 1}));
  CHECK(later.dry_run().issues.empty());
  sim.apply(set_parameters("tether", {.rest = 2}));
  CHECK(sim.world().spring({0}).tension == 0);
  REQUIRE(sim.run_until(2));
  CHECK(std::fabs(place(sim).z + 2) < 1e-12);
}

TEST_CASE("cable: mistakes") {
  CHECK(error_of([] { hanging(0, {.name = "tether", .restitution = 1.5}); }).find("restitution: must be from 0 to 1") !=
        std::string::npos);
  CHECK(error_of([] { hanging(0, {.name = "tether", .length = 0}); }).find("length: must be positive") != std::string::npos);
  CHECK(error_of([] { hanging(0, {.name = "tether", .strength = -1}); }).find("strength: must be positive") != std::string::npos);
  Simulation sim(hanging(0, {.name = "tether"}, {}, 1.8), precise());
  const RunResult run = sim.run_until(0.1);
  CHECK(!run);
  CHECK(run.reason.find("cable 'tether' are farther apart than its length by 0.3 m") != std::string::npos);
}

// Each flight takes 2 v/g. Those that steps can't follow end at once, where the cable would become taut for ever.
TEST_CASE("cables: elastic bounces go on for as long as steps can follow them") {
  for (const char* method : {"rk4", "dop853"})
    for (const double restitution : {1.0, 0.9999})
      for (const double flight : {1e-3, 1e-4, 4e-6}) {
        CAPTURE(method);
        CAPTURE(restitution);
        CAPTURE(flight);
        const double v = 0.5 * g * flight;
        Simulation sim(hanging(0, {.name = "tether", .restitution = restitution}, {0, 0, -v, 0, 0, 0}), precise(method));
        REQUIRE(sim.run_until(0.0205) == Status::ok);
        const auto hits = std::count_if(sim.events().begin(), sim.events().end(),
                                        [](const Event& e) { return e.name.find("taut") == 0 && norm(e.contact.impulse) > 0; });
        const double lost = sim.energy().lost_in_impacts, brought = 0.5 * mass * v * v;
        if (flight > 1e-5 && restitution == 1) {
          CHECK(hits == static_cast<long>(0.0205 / flight) + 1);
          CHECK(std::fabs(lost) < 1e-9 * brought);
        }
        if (flight < 1e-5) {
          CHECK(hits <= 2);
          CHECK(lost == doctest::Approx(brought).epsilon(1e-6));
        }
        CHECK(std::fabs(place(sim).z + length) < 0.25 * v * flight + 1e-9);
      }
}

TEST_CASE("cables: one that a prescribed motion stretches is a warning, and asking for warnings changes nothing") {
  const auto make = [] {
    Model model({.gravity = {0, 0, -9.81}});
    const BodyId slider = model.add({.name = "slider",
                                     .mass = 1,
                                     .inertia = diagonal(0.1),
                                     .joint = Prismatic{.axis = {1, 0, 0}, .drive = motion_drive(Signal::ramp(1, 0))}});
    model.add({.name = "bob",
               .mass = 1,
               .com = {0, 0, -0.3},
               .inertia = diagonal(0.1),
               .parent = slider,
               .joint = Revolute{.axis = {0, 1, 0}},
               .q = 0.4});
    model.add_cable({.name = "tether", .from = {ground, {}}, .to = {slider, {}}, .length = 0.5});
    return Simulation(model, {.method = "dopri5"});
  };
  Simulation asked = make(), left = make();
  REQUIRE(asked.run_until(0.3));
  CHECK(asked.warnings().empty());
  REQUIRE(asked.run_until(0.8));
  REQUIRE(left.run_until(0.3));
  REQUIRE(left.run_until(0.8));
  REQUIRE(asked.warnings().size() == 1);
  CHECK(asked.warnings()[0].find("cable 'tether' are farther apart than its length by up to 0.3 m") != std::string::npos);
  CHECK(std::equal(asked.world().state().q().begin(), asked.world().state().q().end(), left.world().state().q().begin()));
  CHECK(std::equal(asked.world().state().u().begin(), asked.world().state().u().end(), left.world().state().u().begin()));
}

TEST_CASE("cables: the least reactions of a redundant loop that a taut cable loads are those of its rotated copy") {
  // Two bars, pinned to the ground and to each other by parallel hinges, and a load that hangs out of their plane.
  const auto reactions = [](const Quat& turn) {
    const Mat3 R = rotation_matrix(turn);
    const Vec3 gravity{1, 2, -9}, end{0.3, 0, 0.1}, pin{0.7, 0, -0.2};
    Model model({.gravity = R * gravity});
    const Revolute hinge{.axis = {0, 1, 0}};
    const BodyId one = model.add({.name = "one", .mass = 1, .inertia = diagonal(0.01), .at = {{}, turn}, .joint = hinge});
    const BodyId other =
        model.add({.name = "other", .mass = 2, .inertia = diagonal(0.02), .parent = one, .at = {end, {}}, .joint = hinge});
    model.add_loop({.name = "pin", .body = other, .joint = hinge, .at = {R * pin, turn}, .child_at = {pin - end, {}}});
    const Vec3 below = R * (end + 0.5 / norm(gravity) * gravity);
    const BodyId load = model.add({.name = "load",
                                   .mass = 3,
                                   .inertia = diagonal(0.1),
                                   .joint = Free{},
                                   .q = {below.x, below.y, below.z, turn.w, turn.x, turn.y, turn.z}});
    model.add_cable({.name = "rope", .from = {one, end}, .to = {load, {}}, .length = 0.5});
    Simulation sim(model, precise());
    REQUIRE(sim.run_until(0.05));
    CHECK(std::fabs(sim.world().spring({0}).tension) == doctest::Approx(3 * norm(gravity)).epsilon(1e-9));
    std::vector<double> all;
    for (const char* name : {"one", "other", "pin"}) {
      const Wrench found = sim.world().reaction(model.joint(name));
      for (const double x : {found.force.x, found.force.y, found.force.z, found.torque.x, found.torque.y, found.torque.z})
        all.push_back(x);
    }
    return all;
  };
  oracle::Prng random(12);
  const std::vector<double> upright = reactions({});
  for (int k = 0; k < 10; ++k) {
    const std::vector<double> turned = reactions(random.rotation());
    for (std::size_t i = 0; i < upright.size(); ++i) CHECK(std::fabs(turned[i] - upright[i]) < 1e-7);
  }
}
