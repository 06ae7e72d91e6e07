// Invalid arguments of simulations and worlds. Invalid values are errors that say what is wrong; invalid handles, and calls that
// a simulation cannot serve in its present state, terminate the program with a message of what was expected.
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>
#include <tests/error_of.hpp>
#include <tests/misuse.hpp>

using namespace momentree;
using namespace momentree::test;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity(),
                 denormal = std::numeric_limits<double>::denorm_min();

// A pendulum of two links, and a floating body that carries another on a ball joint.
Model model(double mass = 1) {
  Model all;
  const auto add = [&](const char* name, BodyId parent, const JointSpec& joint) {
    return all.add({.name = name, .mass = mass, .com = {0.1, 0, 0}, .inertia = diagonal(0.1), .parent = parent, .joint = joint});
  };
  add("m/lower", add("m/upper", ground, Revolute{.axis = y_axis}), Revolute{.axis = y_axis});
  add("s/panel", add("s/hull", ground, Free{}), Ball{});
  return all;
}

void check_error(const char* what, const std::function<void()>& act) {
  const std::string said = error_of(act);
  CAPTURE(std::string(what));
  CAPTURE(said);
  CHECK(said.find(what) != std::string::npos);
}

}  // namespace

TEST_CASE("misuse: invalid times, periods and steps") {
  Simulation sim(model());
  REQUIRE(sim.run_until(0.01) == Status::ok);
  for (const double t : {no_number, inf, -inf, 0.0, -1.0}) check_error("cannot happen", [&] { static_cast<void>(sim.at(t)); });
  for (const double period : {no_number, inf, -inf, 0.0, -1.0}) {
    check_error("the period of an event can't be", [&] { static_cast<void>(sim.every(period, 1)); });
    if (period == 0) continue;
    check_error("the period of an observer can't be", [&] { sim.observe(period, [](const World&) { return true; }); });
  }
  for (const double period : {denormal, 1e-300, 1e-25}) {
    check_error("is shorter than the clock can resolve", [&] { static_cast<void>(sim.every(period, 1)); });
    check_error("is shorter than the clock can resolve", [&] { sim.observe(period, [](const World&) { return true; }); });
  }
  for (const double from : {no_number, inf, -1.0}) check_error("cannot happen", [&] { static_cast<void>(sim.every(1, from)); });
  static_cast<void>(sim.at(0.5).named("then"));
  for (const double delay : {no_number, inf, -1.0})
    check_error("the delay after an event", [&] { static_cast<void>(sim.after("then", delay)); });

  check_error("the time to run to is not a number", [&] { static_cast<void>(sim.run_until(no_number)); });
  check_error("nothing ends a run", [&] { static_cast<void>(sim.run_until(inf)); });
  for (const double dt : {no_number, -1.0, -inf}) check_error("a step can't be", [&] { static_cast<void>(sim.step(dt)); });
  check_error("nothing ends a run", [&] { static_cast<void>(sim.step(inf)); });
  for (const double dt : {denormal, 1e-30}) check_error("shorter than the clock", [&] { static_cast<void>(sim.step(dt)); });
  const double before = sim.time();
  CHECK(sim.run_until(0.005) == Status::ok);  // is past: nothing moves
  CHECK(sim.run_until(-inf) == Status::ok);
  CHECK(sim.step(0) == Status::ok);
  CHECK(sim.time() == before);
}

TEST_CASE("misuse: a run without end needs an observer or a watcher that ends it") {
  for (const bool steps : {false, true}) {
    for (const bool watches : {false, true}) {
      CAPTURE(steps);
      CAPTURE(watches);
      Simulation sim(model());
      if (watches)
        sim.watch([](double time) { return time < 0.0205; });
      else
        sim.observe(0, [](const World& world) { return world.time() < 0.0205; });
      CHECK((steps ? sim.step(inf) : sim.run_until(inf)) == Status::interrupted);
      CHECK(sim.time() == doctest::Approx(0.021));
    }
  }
}

TEST_CASE("misuse: a time that can't resolve the steps is reported") {
  Simulation sim(model(), {.step = 1e-3});
  std::vector<JointStart> none;
  sim.restore(1e14, {}, none);  // where the clock's resolution is 0.016 s
  CHECK(sim.run_until(1e14 + 1) == Status::stalled);
  CHECK(sim.result().reason.find("too short to move the clock") != std::string::npos);
  check_error("is shorter than the clock can resolve", [&] { static_cast<void>(sim.every(1e-3, 1e14)); });
  check_error("is shorter than the clock can resolve", [&] { sim.observe(1e-3, [](const World&) { return true; }); });
  sim.restore(0, {}, none);  // from a state from which it can continue
  CHECK(sim.run_until(0.01) == Status::ok);
  CHECK(sim.result().reason.empty());
}

TEST_CASE("misuse: integration options") {
  const auto with = [](Integration how) { return [how] { Simulation(model(), how); }; };
  check_error("unknown integration method 'rk5'; did you mean 'rk4'?", with({.method = "rk5"}));
  for (const double x : {no_number, inf, 0.0, -1.0}) {
    check_error("the step must be a positive time", with({.step = x}));
    check_error("the event tolerance must be a positive time", with({.event_tolerance = x}));
    check_error("rtol, atol and max_step must be positive", with({.rtol = x}));
    check_error("rtol, atol and max_step must be positive", with({.atol = x}));
    if (x != inf) check_error("rtol, atol and max_step must be positive", with({.max_step = x}));
  }
  // Finer than the clock: located as precisely as the clock allows.
  Simulation sim(model(), {.event_tolerance = denormal});
  static_cast<void>(sim.when(speed_of("m/upper").exceeds(0.1)).then(break_joint("m/lower")));
  CHECK(sim.run_until(0.2) == Status::ok);
  CHECK(sim.events().size() == 1);
}

TEST_CASE("misuse: conditions that are never or always true") {
  Simulation sim(model());
  const auto refuses = [&](const char* what, const Condition& condition) {
    check_error(what, [&] { static_cast<void>(sim.when(condition)); });
  };
  for (const double x : {no_number, inf, -inf}) {
    refuses("the threshold must be finite", reaction_force("m/upper").exceeds(x));
    refuses("the threshold must be finite", position_of("m/upper").below(x));
  }
  for (const double x : {0.0, -1.0}) {
    refuses("never negative", reaction_force("m/upper").exceeds(x));
    refuses("never negative", reaction_torque("m/upper").below(x));
    refuses("never negative", reaction_impulse("m/upper").exceeds(x));
    refuses("never negative", distance_between("m/lower", "s/hull").below(x));
    refuses("never negative", kinetic_energy_of("m").exceeds(x));
  }
  refuses("the duration of a condition", speed_of("m/upper").exceeds(1).lasting(-1));
  refuses("the duration of a condition", speed_of("m/upper").exceeds(1).lasting(no_number));
  refuses("the duration of a condition", speed_of("m/upper").exceeds(1).lasting(inf));
  refuses("the hysteresis must be finite", speed_of("m/upper").exceeds(1).repeated(no_number));
  refuses("there is no joint 'm/uper'; did you mean 'm/upper'?", speed_of("m/uper").exceeds(1));
  refuses("there is no body 'x'", height_of("x").below(1));
  refuses("there is no mechanism 'mm'; did you mean 'm'?", kinetic_energy_of("mm").exceeds(1));
  refuses("joint 's/panel' is ball and has 3 degrees of freedom", speed_of("s/panel").exceeds(1));
  refuses("joint 's/hull' is free and has 6 degrees of freedom", position_of("s/hull").exceeds(1));
  check_error("needs a function", [] { static_cast<void>(measured({})); });
  check_error("a reaction has no component 'fw'", [] { static_cast<void>(reaction("m/upper", "fw")); });

  static_cast<void>(sim.when(kinetic_energy_of("s/panel").exceeds(1)));  // the mechanism's name if the body breaks off
  static_cast<void>(sim.at(0.1).then(change_joint("s/panel", JointSpec(Revolute{}))));
  static_cast<void>(sim.when(speed_of("s/panel").exceeds(1)));  // by then
  CHECK(sim.run_until(0.2) == Status::ok);
  check_stopped("no quantity", "a measure has a quantity", [] { Measure(nullptr); });
  check_stopped("a condition on nothing", "a condition has a quantity", [] { Condition(nullptr, 1, true); });
  check_stopped("no action", "an action does something", [] { Action(std::shared_ptr<const ActionBase>()); });
}

TEST_CASE("misuse: actions with invalid joints, impulses or placements") {
  Simulation sim(model());
  const auto refuses = [&](const char* what, const Action& action) {
    CAPTURE(what);
    CHECK(sim.try_apply(action) == Status::refused);
    CHECK(sim.result().reason.find(what) != std::string::npos);
    check_error(what, [&] { sim.apply(action); });
    CHECK(sim.events().empty());
  };
  for (const double x : {no_number, inf}) {
    refuses("must be finite", impulse("m/lower", {x, 0, 0}));
    refuses("must be finite", impulse("m/lower", {}, {0, x, 0}));
    refuses("must be finite", impulse("m/lower", {1, 0, 0}, {}, {0, 0, x}));
    refuses("damping: must be finite", set_parameters("m/upper", {.damping = x}));
    refuses("at: the placement must be finite", attach("s/hull", "m/lower", Revolute{}, Pose{{x, 0, 0}, {}}));
    refuses("axis: must be finite", attach("s/hull", "m/lower", Revolute{.axis = {x, 0, 0}}));
    refuses("axis: must be finite", change_joint("m/upper", JointSpec(Prismatic{.axis = {0, x, 0}})));
  }
  refuses("quaternion", attach("s/hull", "m/lower", Revolute{}, Pose{{}, {0, 0, 0, 0}}));
  for (const int i : {-1, 1, 31, 32, 1 << 30}) {
    refuses("has no degree of freedom", lock("m/upper", {i}));
    refuses("has no degree of freedom", unlock("m/upper", {i}));
  }
  check_error("gravity must be finite", [&] { sim.set_gravity({0, no_number, 0}); });
  CHECK(sim.world().model().gravity() == Vec3{0, 0, -9.81});
}

TEST_CASE("misuse: actions can't be added to a past event; an event without actions is valid") {
  Simulation sim(model());
  auto past = sim.at(0.1).named("past");
  REQUIRE(sim.run_until(0.2) == Status::ok);
  check_error("event 'past' has already happened", [&] { past.then(break_joint("m/lower")); });
  REQUIRE(sim.events().size() == 1);
  const Event& event = sim.events()[0];
  CHECK(event.actions.empty());
  CHECK(event.before.potential == event.after.potential);
  CHECK(event.before.potential != 0);
  CHECK(event.mechanisms_after == std::vector<std::string>{"m", "s"});
}

TEST_CASE("misuse: queries about things that the world does not have") {
  const World world(model());
  const char* const no_joint = "the joint is in this world";
  for (const int b : {-1, 4, 1 << 30}) {
    CAPTURE(b);
    const BodyId body{b};
    const Misuse all[] = {
        {"joint", no_joint, [&] { static_cast<void>(world.joint({body.index})); }},
        {"joint_forces", no_joint, [&] { static_cast<void>(world.joint_forces({body.index})); }},
        {"reaction", no_joint, [&] { static_cast<void>(world.reaction({body.index})); }},
        {"one_freedom", no_joint, [&] { static_cast<void>(world.single_dof({body.index})); }},
        {"joint_name", "a joint of that number", [&] { static_cast<void>(world.joint_name({body.index})); }},
        {"mechanism_name", "a joint of that number", [&] { static_cast<void>(world.mechanism_name(body)); }},
    };
    for (const Misuse& misuse : all) check_stopped(misuse);
    CHECK_FALSE(world.alive(body));
  }
  check_stopped("a coordinate that the joint has not", "an index below size()",
                [&] { static_cast<void>(world.joint({0}).q[1]); });
  check_stopped("an effort that the joint has not", "an index below size()",
                [&] { static_cast<void>(world.joint_forces({0}).effort[1]); });
  CHECK(world.find_joint("nothing") == -1);
}

TEST_CASE("misuse: a state of another world") {
  const auto restored = [](double time, const Forest& forest, std::vector<JointStart> joints) {
    return [=] { World(model()).restore(time, forest, joints); };
  };
  Forest few, loop, holds;
  few.places.resize(2);
  loop.places = {{1, 0, false}, {0, 1, false}, {-1, 2, false}, {2, 3, false}};
  holds.active_limits = {{0, 3, 1}};
  check_fine("of this one", restored(1, {}, {{{0}, 0.5, {}, {}}}));
  const Misuse all[] = {
      {"a time that is not a number", "a finite time", restored(no_number, {}, {})},
      {"a joint that it has not", "the joint is in this world", restored(0, {}, {{{9}, 1, {}, {}}})},
      {"too many coordinates", "as many numbers as the joint has", restored(0, {}, {{{0}, {1, 2}, {}, {}}})},
      {"too few velocities", "as many numbers as the joint has", restored(0, {}, {{{3}, {}, {1, 2}, {}}})},
      {"other bodies", "compiled from the same model", restored(0, few, {})},
      {"a loop", "every body is joined to the ground", restored(0, loop, {})},
      {"a stop of a freedom that it has not", "a degree of freedom of the joint", restored(0, holds, {})},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}

TEST_CASE("misuse: handles of a destroyed or other simulation") {
  const Misuse all[] = {
      {"a moved-from simulation", "has not been moved from",
       [] {
         Simulation sim(model());
         const Simulation moved = std::move(sim);
         static_cast<void>(sim.time());
       }},
      {"a run of a moved-from simulation", "has not been moved from",
       [] {
         Simulation sim(model());
         const Simulation moved = std::move(sim);
         static_cast<void>(sim.run_until(1));
       }},
      {"a handle of a simulation that is gone", "still exists",
       [] {
         auto sim = std::make_optional<Simulation>(model());
         auto handle = sim->at(1);
         sim.reset();
         handle.then(break_joint("m/upper"));
       }},
      {"a handle of a simulation that became another", "still exists",
       [] {
         Simulation sim(model());
         auto handle = sim.at(1);
         sim = Simulation(model());
         handle.named("x");
       }},
      {"a snapshot of another model", "compiled from the same model",
       [] { Simulation(model()).restore(Simulation(model(2)).snapshot()); }},
      {"resumed with more events than there are", "at most as many events as are scheduled",
       [] {
         Simulation sim(model());
         resume(sim, std::vector<EventStatus>(3));
       }},
      {"resumed with a step that is no number", "a StepMemory returned by step_memory()",
       [] {
         Simulation sim(model(), {.method = "dopri5"});
         resume(sim, {}, {.next_step = no_number});
       }},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}

TEST_CASE("handles stay valid when their simulation is moved or its gravity changes") {
  Simulation sim(model());
  auto event = sim.at(0.01);
  const World* const world = &sim.world();
  sim.set_gravity({0, 0, -1});
  CHECK(&sim.world() == world);
  event.named("cut");
  Simulation moved = std::move(sim);
  event.then(break_joint("m/lower"));
  std::optional<Simulation> again = std::move(moved);
  REQUIRE(again->run_until(0.02) == Status::ok);
  REQUIRE(again->events().size() == 1);
  CHECK(again->events()[0].name == "cut");
  CHECK(again->events()[0].action_texts() == std::vector<std::string>{"break m/lower"});
  CHECK(again->world().model().gravity() == Vec3{0, 0, -1});
  const Event pushed = again->apply(impulse("m/upper", {1, 0, 0}));  // a value: later events do not change it
  for (int i = 0; i < 100; ++i) again->apply(impulse("m/upper", {1, 0, 0}));
  CHECK(pushed.action_texts() == std::vector<std::string>{"impulse m/upper"});
}
