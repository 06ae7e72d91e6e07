// A run that is saved after any of its steps and continued in another simulation has the states, events and counts of the
// uninterrupted run, to the last bit.
#include <momentree/simulate/run_state.hpp>

#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/kinds.hpp>

using namespace momentree;

namespace {

struct Setup {
  Model model;
  std::function<void(Simulation&)> schedule;
  double until = 0.3;
};

void append(std::string& text, double x) {
  char bits[sizeof x];
  std::memcpy(bits, &x, sizeof x);
  text.append(bits, sizeof bits);
}

// Everything at the end of a run, with the times and states at which it was observed.
struct End {
  std::string state, events, counts, observed;
  long steps = 0;
  friend bool operator==(const End&, const End&) = default;
};

class Run {
 public:
  Run(const Setup& setup, const Integration& how) : setup_(setup), how_(how) { begin(); }

  // Saved after each of these numbers of steps.
  End through(const std::vector<long>& saved_after) {
    std::size_t next = 0;
    for (;;) {
      bool stop = false;
      simulation_->watch([&](double) {
        ++end_.steps;
        stop = next < saved_after.size() && end_.steps == saved_after[next];
        if (stop) saved_ = std::make_unique<RunState>(simulation_->run_state());
        return !stop;
      });
      const RunResult result = simulation_->run_until(setup_.until);
      if (!stop) {
        finish(result);
        return end_;
      }
      ++next;
      begin();
      simulation_->continue_from(*saved_);
    }
  }

 private:
  void begin() {
    simulation_ = std::make_unique<Simulation>(setup_.model, how_);
    setup_.schedule(*simulation_);
    simulation_->observe(0.0125, [this](const World& world) {
      append(end_.observed, world.time());
      for (const auto& motion : world.motions()) append(end_.observed, motion.pose.position.x);
      return true;
    });
  }
  void finish(const RunResult& result) {
    const WorldSnapshot last = simulation_->world().snapshot();
    append(end_.state, last.engine.time);
    for (const auto* numbers : {&last.engine.q, &last.engine.y})
      for (const double x : *numbers) append(end_.state, x);
    for (int j = 0; j < simulation_->world().tree().bodies(); ++j) end_.state += simulation_->world().joint_name({j});
    for (const Event& event : simulation_->events()) {
      end_.events += event.name;
      for (const std::string& action : event.action_texts()) end_.events += " " + action;
      for (const double x : {event.time, event.after.kinetic, event.lost, event.work, event.hardest_linear})
        append(end_.events, x);
    }
    const RunStatistics& s = simulation_->statistics();
    for (const long count : {s.steps, s.changes, s.evaluations[0], s.evaluations[1], static_cast<long>(result.status)})
      end_.counts += std::to_string(count) + " ";
    const EnergyBalance e = simulation_->energy();
    for (const double x : {e.initial, e.final, e.dissipated, e.work, e.lost_in_impacts, e.released, e.error, e.largest_kinetic})
      append(end_.counts, x);
    for (const MissedEvent& missed : simulation_->missed())
      for (const double x : {missed.time, missed.nearest, missed.nearest_time, missed.held}) append(end_.counts, x);
  }

  const Setup& setup_;
  Integration how_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<RunState> saved_;
  End end_;
};

// Saved once, after each step or after some of them, and several times in one run.
void check(const Setup& setup, std::vector<std::string> methods = {"rk4", "dop853"}, std::size_t least_events = 1) {
  for (const std::string& method : methods) {
    CAPTURE(method);
    const Integration how{.method = method, .step = 2e-3, .rtol = 1e-7, .atol = 1e-9};
    const End whole = Run(setup, how).through({});
    Simulation plain(setup.model, how);
    setup.schedule(plain);
    const RunResult result = plain.run_until(setup.until);
    REQUIRE_MESSAGE(result.status == Status::ok, result.reason);
    REQUIRE(plain.events().size() >= least_events);
    REQUIRE(whole.steps > 4);
    const long apart = std::max(1L, whole.steps / 40);
    std::vector<long> all;
    for (long step = 1; step < whole.steps; step += apart) {
      CAPTURE(step);
      all.push_back(step);
      const End continued = Run(setup, how).through({step});
      CHECK(continued.state == whole.state);
      CHECK(continued.events == whole.events);
      CHECK(continued.observed == whole.observed);
      CHECK(continued.counts == whole.counts);
    }
    CHECK(Run(setup, how).through(all) == whole);
  }
}

// A chain with a free body beside it.
Model chain(const JointParameters& first = {}, const JointParameters& third = {}) {
  Model model({.gravity = {0, -9.81, 0}});
  BodyId last = ground;
  for (int k = 1; k <= 4; ++k) {
    JointSpec joint = k == 2 ? JointSpec(Ball{.damping = 1e-3}) : JointSpec(Revolute{.axis = {0, 0.1, 1}, .damping = 1e-3});
    if (k == 1) joint.parameters = first;
    if (k == 3) joint.parameters = third;
    BodySpec body{.name = "chain/" + std::to_string(k),
                  .mass = 0.1,
                  .com = {0.05, 0, 0.01},
                  .inertia = diagonal(8.3e-5, 9e-5, 7e-5),
                  .parent = last,
                  .at = {k == 1 ? 0.0 : 0.1, 0, 0},
                  .joint = joint};
    if (k != 2) body.q = 0.3, body.v = -0.5;
    last = model.add(body);
  }
  model.add({.name = "ball",
             .mass = 0.2,
             .inertia = diagonal(1e-4, 2e-4, 3e-4),
             .joint = Free{},
             .q = {0.3, 0.2, 0, 1, 0, 0, 0},
             .v = {0.5, 1, 0, 1, 2, 3}});
  return model;
}

}  // namespace

TEST_CASE("a continued run equals the uninterrupted one: every integration method") {
  check({chain(), [](Simulation& sim) { sim.at(0.1).then(break_joint("chain/3")); }}, integration_methods());
}

TEST_CASE("a continued run equals the uninterrupted one: changes of the topology") {
  check({chain(),
         [](Simulation& sim) {
           expect_joints(sim, {"grip", "hold"});
           sim.at(0.03).then(lock("chain/2"));
           sim.at(0.06).then(break_joint("chain/3")).then(unlock("chain/2"));
           sim.at(0.09).then(weld("ball", "chain/1")).named("grip");
           sim.at(0.11).then(change_joint("chain/2", Revolute{.axis = {0, 0, 1}}));
           sim.at(0.13).then(reroot("chain/4"));
           sim.at(0.15).then(attach("chain/4", "chain/2", Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}})).named("hold");
           sim.at(0.18).then(break_joint("grip"));
           sim.at(0.2).then(impulse("ball", {0.01, 0.02, 0}, {1e-4, 0, 0}));
           sim.at(0.22).then(free_joint("chain/1"));
           sim.at(0.24).then(set_parameters("hold", {.damping = 2e-3, .stiffness = {}}));
         }},
        integration_methods(), 10);
}

TEST_CASE("a continued run equals the uninterrupted one: events that follow, repeat, wait and last") {
  check({chain(),
         [](Simulation& sim) {
           sim.at(0.05).then(lock("chain/4")).named("first");
           sim.after("first", 0.0333).then(unlock("chain/4")).named("second");
           sim.after("second").then(impulse("ball", {0, 0.01, 0}));
           sim.every(0.041, 0.02).then(impulse("ball", {0.001, 0, 0})).named("tick");
           sim.after("tick", 0.013).then(impulse("ball", {0, 0, 0.001}));
           sim.when(height_of("chain/4").below(-0.1).repeated(0.01)).then(impulse("chain/4", {0, 0.02, 0})).named("low");
           sim.when(height_of("ball").below(0.2).lasting(0.02)).then(lock("chain/1")).named("lasted");
           sim.when(speed_of("chain/1").exceeds(4)).then(break_joint("chain/4")).named("fast");
           sim.when(reaction_force("chain/1").exceeds(1e6)).then(break_joint("chain/1"));  // never
         }},
        {"rk4", "dop853", "damped"}, 12);
}

TEST_CASE("a continued run equals the uninterrupted one: strengths and stops") {
  JointParameters strong{.damping = 1e-3};
  strong.strength.force = 4.5;
  JointParameters stopped{.damping = 1e-3};
  stopped.limits = {.lower = -0.1, .upper = 0.5, .restitution = 0.5};
  check({chain(stopped, strong), [](Simulation& sim) { sim.after("strength of chain/3", 0.02).then(lock("chain/4")); }, 0.6},
        {"rk4", "dop853", "damped"}, 3);
}

TEST_CASE("a continued run equals the uninterrupted one: drives, motions and forces") {
  JointParameters moves, drives{.damping = 1e-3};
  moves.drive = motion_drive(Signal::sine(0.05, 12.5, 1.2, 0.1));
  drives.drive = effort_drive({Signal::table({{0, 0}, {0.07, 0.01}, {0.19, -0.02}})});
  JointParameters from_here;
  from_here.drive = motion_drive(Signal::ramp_from_here(0.7));
  check({chain(moves, drives),
         [from_here](Simulation& sim) {
           sim.drive("chain/4", [](const EvaluationContext& c) { return 1e-3 * std::sin(20 * c.time()); });
           sim.force("ball", [](const EvaluationContext&) { return Wrench{{0, 1, 0}, {0, 0, 1e-4}}; });
           sim.at(0.08).then(lock("chain/1"));
           sim.at(0.16).then(unlock("chain/1"));
           sim.at(0.2).then(break_joint("chain/4"));
           sim.at(0.22).then(set_parameters("chain/3", from_here));
         }},
        integration_methods(), 4);
}

TEST_CASE("a state outside of a run continues as the simulation itself does") {
  const Setup setup{chain(), [](Simulation& sim) { sim.every(0.05).then(impulse("ball", {0.01, 0, 0})); }};
  Simulation one(setup.model, {.method = "dop853"}), other(setup.model, {.method = "dop853"});
  setup.schedule(one), setup.schedule(other);
  REQUIRE(one.run_until(0.123) == Status::ok);
  other.continue_from(one.run_state());
  REQUIRE(one.run_until(0.3) == Status::ok);
  REQUIRE(other.run_until(0.3) == Status::ok);
  CHECK(one.world().snapshot().engine.q == other.world().snapshot().engine.q);
  CHECK(one.world().snapshot().engine.y == other.world().snapshot().engine.y);
  CHECK(one.statistics().evaluations[1] == other.statistics().evaluations[1]);
  CHECK(one.events().size() == other.events().size());
}
