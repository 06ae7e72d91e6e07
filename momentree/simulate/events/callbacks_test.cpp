// What a simulation's callbacks may do with it, what terminates the program, and how their exceptions propagate.
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>

#include <doctest/doctest.h>

#include <momentree/simulate/simulation.hpp>
#include <tests/misuse.hpp>

using namespace momentree;
using namespace momentree::test;

namespace {

Model model() {
  Model all;
  BodyId last = ground;
  for (const char* name : {"m/upper", "m/lower"})
    last = all.add({.name = name,
                    .mass = 1,
                    .com = {0.1, 0, 0},
                    .inertia = diagonal(0.1),
                    .parent = last,
                    .joint = Revolute{.axis = y_axis}});
  return all;
}

using Act = std::function<void(Simulation&, const World&)>;
struct Callback {
  const char* name;
  std::function<void(Simulation&, Act)> install;  ///< so that `act` is called in the next run
};
const std::vector<Callback> steady = {
    {"observe",
     [](Simulation& sim, Act act) {
       sim.observe(0, [&sim, act](const World& world) {
         act(sim, world);
         return true;
       });
     }},
    {"watch",
     [](Simulation& sim, Act act) {
       sim.watch([&sim, act](double) {
         act(sim, sim.world());
         return true;
       });
     }},
};
const std::vector<Callback> within = {
    {"measured",
     [](Simulation& sim, Act act) {
       static_cast<void>(sim.when(measured([&sim, act](const World& world) {
                                    act(sim, world);
                                    return -1.0;
                                  }).exceeds(0)));
     }},
    {"use_generated",
     [](Simulation& sim, Act act) {
       sim.use_generated([&sim, act](const Tree&, Variables, std::span<const int>) -> RatesFunction {
         act(sim, sim.world());
         return nullptr;
       });
     }},
};
const std::vector<Callback> functions = {
    {"drive",
     [](Simulation& sim, Act act) {
       sim.drive("m/lower", [&sim, act](const EvaluationContext& now) {
         if (now.time() > 0) act(sim, sim.world());
         return 0.0;
       });
     }},
    {"force",
     [](Simulation& sim, Act act) {
       sim.force("m/lower", [&sim, act](const EvaluationContext& now) {
         if (now.time() > 0) act(sim, sim.world());
         return Wrench{};
       });
     }},
};

// Functions that change a simulation.
struct Change {
  const char* name;
  Act act;
};
const std::vector<Change> changes = {
    {"run_until", [](Simulation& sim, const World&) { static_cast<void>(sim.run_until(1)); }},
    {"step", [](Simulation& sim, const World&) { static_cast<void>(sim.step(1)); }},
    {"apply", [](Simulation& sim, const World&) { sim.apply(break_joint("m/lower")); }},
    {"apply nothing", [](Simulation& sim, const World&) { sim.apply(std::span<const Action>()); }},
    {"try_apply", [](Simulation& sim, const World&) { static_cast<void>(sim.try_apply(break_joint("m/lower"))); }},
    {"set_gravity", [](Simulation& sim, const World&) { sim.set_gravity({}); }},
    {"use_generated", [](Simulation& sim, const World&) { sim.use_generated({}); }},
    {"observe", [](Simulation& sim, const World&) { sim.observe(0, {}); }},
    {"watch", [](Simulation& sim, const World&) { sim.watch({}); }},
    {"drive", [](Simulation& sim, const World&) { sim.drive("m/lower", {}); }},
    {"drive_all", [](Simulation& sim, const World&) { sim.drive_all("m/lower", {}); }},
    {"drive_all of none", [](Simulation& sim, const World&) { sim.drive_all({}); }},
    {"force", [](Simulation& sim, const World&) { sim.force("m/lower", {}); }},
    {"add", [](Simulation& sim, const World&) { sim.add({.name = "x", .mass = 1}); }},
    {"remove", [](Simulation& sim, const World&) { sim.remove({1}); }},
    {"dry_run", [](Simulation& sim, const World&) { static_cast<void>(sim.dry_run()); }},
    {"restore", [](Simulation& sim, const World&) { sim.restore(Simulation(model()).snapshot()); }},
    {"restore a document", [](Simulation& sim, const World&) { sim.restore(0, {}, {}); }},
    {"undo", [](Simulation& sim, const World&) { sim.undo(0); }},
    {"resume", [](Simulation& sim, const World&) { resume(sim, {}); }},
};
const std::vector<Change> moves = {
    {"move", [](Simulation& sim, const World&) { const Simulation other = std::move(sim); }},
    {"replace", [](Simulation& sim, const World&) { sim = Simulation(model()); }},
    {"move another into it",
     [](Simulation& sim, const World&) {
       Simulation other(model());
       other = std::move(sim);
     }},
};

void run(const Callback& callback, const Act& act) {
  Simulation sim(model());
  callback.install(sim, act);
  static_cast<void>(sim.run_until(0.01));
}

}  // namespace

TEST_CASE("no callback changes its simulation") {
  for (const auto* all : {&steady, &within, &functions})
    for (const Callback& callback : *all)
      for (const Change& change : changes)
        check_stopped(std::string(change.name) + " in " + callback.name, "callbacks do not change their simulation",
                      [&] { run(callback, change.act); });
}

TEST_CASE("no callback moves or destroys its simulation") {
  for (const auto* all : {&steady, &within, &functions})
    for (const Callback& callback : *all) {
      for (const Change& move : moves)
        check_stopped(std::string(move.name) + " in " + callback.name, "callbacks do not move their simulation",
                      [&] { run(callback, move.act); });
      check_stopped(std::string("destroy in ") + callback.name, "callbacks do not destroy their simulation", [&] {
        auto sim = std::make_optional<Simulation>(model());
        callback.install(*sim, [&sim](Simulation&, const World&) { sim.reset(); });
        static_cast<void>(sim->run_until(0.01));
      });
    }
}

TEST_CASE("observers and watchers read, take snapshots and branches") {
  for (const Callback& callback : steady) {
    CAPTURE(std::string(callback.name));
    Simulation sim(model());
    int calls = 0;
    std::optional<SimulationSnapshot> last;
    std::optional<Simulation> branch;
    callback.install(sim, [&](Simulation& self, const World& world) {
      ++calls;
      CHECK(&world == &self.world());
      CHECK(self.time() == world.time());
      CHECK(world.joint({0}).q.size() == 1);
      CHECK(world.joint_forces({0}).effort.size() == 1);
      CHECK(world.motions().size() == 2);
      CHECK(std::isfinite(self.energy().error));
      CHECK_FALSE(self.can_undo(0));
      last = self.snapshot();
      if (calls == 5) branch = self.branch();
    });
    CHECK(sim.run_until(0.01) == Status::ok);
    CHECK(calls >= 10);
    CHECK(sim.run_until(0.02) == Status::ok);
    REQUIRE(branch.has_value());
    CHECK(branch->run_until(0.02) == Status::ok);
    CHECK(branch->world().joint({1}).q[0] == sim.world().joint({1}).q[0]);
    sim.restore(*last);
    CHECK(sim.time() == 0.02);
  }
}

TEST_CASE("observers and watchers can schedule events") {
  for (const Callback& callback : steady) {
    CAPTURE(std::string(callback.name));
    Simulation sim(model());
    sim.keep_history();
    int calls = 0;
    callback.install(sim, [&](Simulation& self, const World& world) {
      if (++calls != 3) return;
      self.at(world.time()).then(lock("m/lower")).named("now");
      self.after("now", 0.0015).then(unlock("m/lower"));
      self.every(0.004, world.time() + 0.0005).then(impulse("m/upper", {0, 0, 1}));
      self.when(speed_of("m/upper").exceeds(0.06)).then(break_joint("m/lower"));
    });
    CHECK(sim.run_until(0.01) == Status::ok);
    REQUIRE(sim.events().size() >= 5);
    const double then = sim.events()[0].time;
    CHECK(sim.events()[0].name == "now");
    CHECK(then <= 0.0031);
    CHECK(sim.events()[1].time == doctest::Approx(then + 0.0005));
    CHECK(sim.events()[2].time == doctest::Approx(then + 0.0015));
    CHECK(sim.can_undo(0));
  }
}

TEST_CASE("callbacks between two steps read the given state, and schedule nothing") {
  for (const Callback& callback : within) {
    const auto stops = [&](const char* how, const char* expected, const Act& act) {
      check_stopped(std::string(how) + " in " + callback.name, expected, [&] { run(callback, act); });
    };
    const char* const schedules = "only those of observe() and watch() schedule events";
    stops("at", schedules, [](Simulation& sim, const World&) { static_cast<void>(sim.at(1)); });
    stops("every", schedules, [](Simulation& sim, const World&) { static_cast<void>(sim.every(1, 1)); });
    stops("after", schedules, [](Simulation& sim, const World&) { static_cast<void>(sim.after("#1")); });
    stops("when", schedules, [](Simulation& sim, const World&) { static_cast<void>(sim.when(speed_of("m/upper").exceeds(1))); });
    stops("keep_history", schedules, [](Simulation& sim, const World&) { sim.keep_history(); });
    const char* const between = "only those of observe() and watch() are called between two steps";
    stops("snapshot", between, [](Simulation& sim, const World&) { static_cast<void>(sim.snapshot()); });
    stops("branch", between, [](Simulation& sim, const World&) { static_cast<void>(sim.branch()); });
    check_fine(callback.name, [&] {
      run(callback, [](Simulation&, const World& world) { static_cast<void>(world.joint({0}).q[0] + world.time()); });
    });
  }
  check_stopped("then() of a handle in measured", "only those of observe() and watch() schedule events", [] {
    Simulation sim(model());
    auto event = sim.at(1);
    static_cast<void>(sim.when(measured([&](const World&) {
                                 event.then(break_joint("m/lower"));
                                 return -1.0;
                               }).exceeds(0)));
    static_cast<void>(sim.run_until(0.01));
  });
}

TEST_CASE("functions that drive a joint or act on a body read the given moment, not the world") {
  const char* const expected = "a function called by an evaluation reads only the EvaluationContext that it is given";
  for (const Callback& callback : functions) {
    const auto stops = [&](const char* how, const Act& act) {
      check_stopped(std::string(how) + " in " + callback.name, expected, [&] { run(callback, act); });
    };
    stops("time", [](Simulation& sim, const World&) { static_cast<void>(sim.time()); });
    stops("world().time", [](Simulation&, const World& world) { static_cast<void>(world.time()); });
    stops("world().state", [](Simulation&, const World& world) { static_cast<void>(world.state()); });
    stops("world().joint", [](Simulation&, const World& world) { static_cast<void>(world.joint({0})); });
    stops("world().motions", [](Simulation&, const World& world) { static_cast<void>(world.motions()); });
    stops("world().reaction", [](Simulation&, const World& world) { static_cast<void>(world.reaction({0})); });
    stops("world().totals", [](Simulation&, const World& world) { static_cast<void>(world.totals()); });
    stops("energy", [](Simulation& sim, const World&) { static_cast<void>(sim.energy()); });
    check_stopped(std::string("snapshot in ") + callback.name, "between two steps",
                  [&] { run(callback, [](Simulation& sim, const World&) { static_cast<void>(sim.snapshot()); }); });
    // Also without a step: an evaluation calls them, too.
    check_stopped(std::string("apply, evaluated from outside, in ") + callback.name, "callbacks do not change their simulation",
                  [&] {
                    Simulation sim(model());
                    bool armed = false;
                    callback.install(sim, [&](Simulation& self, const World&) {
                      if (armed) self.apply(break_joint("m/lower"));
                    });
                    static_cast<void>(sim.run_until(0.001));
                    armed = true;
                    sim.apply(impulse("m/upper", {1, 0, 0}));
                  });
  }
  const auto asks = [](const std::function<void(const EvaluationContext&)>& what) {
    return [what] {
      Simulation sim(model());
      sim.drive("m/lower", [what](const EvaluationContext& now) {
        what(now);
        return 0.0;
      });
    };
  };
  check_fine("what a moment has", asks([](const EvaluationContext& now) {
               static_cast<void>(now.q({0})[0] + now.v({1})[0] + now.motion({1}).angular.x + now.motion(ground).linear.x);
             }));
  for (const int b : {-1, 2, 99}) {
    check_stopped("q of no joint", "the tree has a joint of that number",
                  asks([b](const EvaluationContext& now) { now.q({b}); }));
    check_stopped("v of no joint", "the tree has a joint of that number",
                  asks([b](const EvaluationContext& now) { now.v({b}); }));
    if (b > 0)
      check_stopped("motion of no body", "a body of that number", asks([b](const EvaluationContext& now) { now.motion({b}); }));
  }
  check_stopped("a coordinate that there is not", "an index below size()",
                asks([](const EvaluationContext& now) { now.q({0})[1]; }));
  CHECK_FALSE(std::is_copy_constructible_v<EvaluationContext>);
}

TEST_CASE("exceptions of observers, watchers and measured quantities end the run, which can be continued") {
  Simulation whole(model());
  whole.at(0.0123).then(lock("m/lower"));
  REQUIRE(whole.run_until(0.05) == Status::ok);
  for (const auto* all : {&steady, &within})
    for (const Callback& callback : *all) {
      CAPTURE(std::string(callback.name));
      Simulation sim(model());
      sim.at(0.0123).then(lock("m/lower"));
      int calls = 0;
      callback.install(sim, [&](Simulation&, const World&) {
        if (++calls == 7 || (&callback == &within[1] && calls == 2)) throw std::runtime_error("enough");
      });
      CHECK_THROWS_AS(static_cast<void>(sim.run_until(0.05)), std::runtime_error);
      CHECK(sim.time() < 0.05);
      const double then = sim.time();
      CHECK(std::fabs(sim.energy().error) < 1e-9);
      CHECK(sim.run_until(0.05) == Status::ok);  // the interrupted run leaves nothing behind
      CHECK(sim.time() > then);
      CHECK(sim.time() == 0.05);
      CHECK(sim.events().size() == 1);
      CHECK(sim.world().joint({0}).q[0] == doctest::Approx(whole.world().joint({0}).q[0]).epsilon(1e-12));
      CHECK(std::fabs(sim.energy().error) < 1e-9);
      sim.apply(break_joint("m/lower"));
    }
}

TEST_CASE("a measured quantity that throws while its crossing is located leaves the state at the start of the step") {
  for (const char* method : {"rk4", "dopri5"}) {
    CAPTURE(method);
    Simulation sim(model(), {.method = method, .step = 0.01});
    bool throws = true;
    double seen = 0;
    sim.when(measured([&](const World& world) {
               seen = world.joint({0}).q[0];
               if (throws && seen > 1e-4) throw std::runtime_error("enough");
               return seen;
             }).exceeds(0.2))
        .then(break_joint("m/lower"));
    CHECK_THROWS_AS(static_cast<void>(sim.run_until(1)), std::runtime_error);
    CHECK(sim.world().joint({0}).q[0] < seen);
    CHECK(sim.world().joint({0}).q[0] <= 1e-4);
    throws = false;
    CHECK(sim.run_until(1) == Status::ok);
    CHECK(sim.events().size() == 1);
    CHECK(std::fabs(sim.energy().error) < 1e-5);
  }
}

TEST_CASE("a measured quantity that threw is measured again at the same state") {
  Simulation sim(model());
  bool throws = true;
  sim.when(measured([&throws](const World& world) {
             if (throws) throw std::runtime_error("enough");
             return world.time() < 0.001 ? 1.0 : 0.0;
           }).exceeds(0.5))
      .then(lock("m/lower"));
  CHECK_THROWS_AS(static_cast<void>(sim.run_until(0.01)), std::runtime_error);
  REQUIRE(sim.time() == 0);
  throws = false;
  CHECK(sim.run_until(0.01) == Status::ok);
  REQUIRE(sim.events().size() == 1);
  CHECK(sim.events()[0].time == 0);
}

TEST_CASE("a measured quantity may be infinite or not a number") {
  const double inf = std::numeric_limits<double>::infinity();
  for (const char* method : {"rk4", "dopri5", "dop853"})
    for (const double beyond : {inf, std::numeric_limits<double>::quiet_NaN()})
      for (const double before : {-inf, 0.0, std::numeric_limits<double>::quiet_NaN()}) {
        CAPTURE(std::string(method));
        CAPTURE(beyond);
        CAPTURE(before);
        Simulation sim(model(), {.method = method, .step = 0.01});
        sim.when(measured([=](const World& world) { return world.joint({0}).q[0] > 0.01 ? beyond : before; }).exceeds(1))
            .then(lock("m/lower"));
        CHECK(sim.run_until(0.2) == Status::ok);
        if (beyond == inf) {
          REQUIRE(sim.events().size() == 1);
          CHECK(sim.world().joint({0}).q[0] > 0.01);
        }
      }
}
