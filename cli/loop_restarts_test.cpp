// Runs that stop and continue where loops are not closed exactly or are locked, and where a cable is pulled apart.
#include <string>

#include <doctest/doctest.h>

#include <cli/restart_test_support.hpp>

using namespace momentree;
using momentree::cli::check_restarts;
using momentree::cli::read_restarted;

namespace {

std::string integrated(const std::string& method, double until) {
  return "[integrate]\nmethod = \"" + method + "\"\nstep = 2e-3\nuntil = " + std::to_string(until) + "\n[output]\nevery = 0.02\n";
}

}  // namespace

TEST_CASE("restarts: a four-bar whose hinges are not quite parallel goes on with the same bits") {
  const std::string four_bar = R"(format = 1
[[mechanism]]
name = "bar"
roots = 2
[[mechanism.body]]
name = "crank"
mass = 3
inertia = [0.006, 0.012, 0.006]
joint = { kind = "revolute", axis = [0, 1, 0], drive = { effort = 2 }, angle = "-60 deg" }
[[mechanism.body]]
name = "rod"
mass = 0.7
com = [0.19, 0, 0]
inertia = [4e-5, 1.1e-2, 1.1e-2]
joint = { kind = "revolute", parent = "crank", axis = [0, 1, 0], at = { xyz = [0.12, 0, 0] } }
[[mechanism.body]]
name = "rocker"
mass = 0.8
com = [0.125, 0, 0]
inertia = [1e-4, 4.5e-3, 4.5e-3]
joint = { kind = "revolute", axis = [0, 1, 0], at = { xyz = [0.4, 0, 0] } }
[[loop]]
name = "pin"
kind = "revolute"
axis = [2e-9, 1, 0]
body = "bar/rod"
to = "bar/rocker"
at = { xyz = [0.25, 1e-9, 0] }
child_at = { xyz = [0.38, 0, 0] }
)";
  for (const char* method : {"dopri5", "rk4", "stepping"}) {
    CAPTURE(method);
    check_restarts(read_restarted(four_bar + integrated(method, 0.3)), 0.3, {0.02, 0.1, 0.22, 0.24});
  }
}

TEST_CASE("restarts: a chain that is clamped in a singular position goes on with the same bits") {
  const std::string chain = R"(format = 1
[[mechanism]]
name = "m"
[mechanism.chain]
links = 3
length = 0.315
mass = 0.15
inertia = 0.01
axis = [0.244, -0.348, -0.437]
drive = { effort = { table = [[0.1, -0.839], [0.15, -0.105], [0.4, -2.7]] } }
[[event]]
at = 0
weld = { body = "m/3", to = "ground" }
)";
  for (const char* method : {"midpoint", "rk4", "stepping", "dopri5"}) {
    CAPTURE(method);
    check_restarts(read_restarted(chain + integrated(method, 0.1)), 0.1, {0.02, 0.04, 0.06, 0.08});
  }
}

TEST_CASE("restarts: a loop joint that is locked where the state was set, and unlocked later, keeps its bits") {
  const io::Scenario scenario = read_restarted(R"(format = 1
[world]
gravity = [1, 2, -3]
[[mechanism]]
name = "m"
root = "free"
state = { velocity = { angular = [0.8, 2.5, 2.6] } }
[[mechanism.body]]
name = "nut"
mass = 0.5
com = [0.1, -0.2, 0.05]
inertia = [0.01, 0.02, 0.015]
[[loop]]
name = "thread"
body = "m/nut"
to = "ground"
kind = "helical"
axis = [0.288, 0.915, 0.975]
pitch = -0.0611
at = { xyz = [0.201, 0.266, 0.0734] }
)" + integrated("rk4", 1));
  io::Session turned(scenario, {}), first(scenario, {});
  REQUIRE(turned.simulation().run_until(0.1) == Status::ok);
  const World& there = turned.simulation().world();
  first.simulation().set_state(0, there.state().q(), there.state().u(), Variables::velocities);
  first.simulation().apply(std::vector<Action>{lock("thread")});
  REQUIRE(first.simulation().run_until(0.2) == Status::ok);
  const io::test::TemporaryFolder folder;
  const std::string file = folder / "state.json";
  io::write_text_file(file, io::state_json(first.simulation().world(), first.armed(), step_memory(first.simulation())));
  io::Session second(scenario, cli::documents_of(file, scenario.model));
  for (io::Session* each : {&first, &second}) each->simulation().apply(std::vector<Action>{unlock("thread")});
  const auto place = [](const io::Session& session) {
    const World& world = session.simulation().world();
    return world.joint(world.model().joint("thread")).q[0];
  };
  CHECK(place(first) == place(second));
}

TEST_CASE("restarts: stops that act deeper, where they hardly hold a loop, go on doing so") {
  const std::string slider_crank = R"(format = 1
[world]
gravity = [0, 0, 0]
[[mechanism]]
name = "m"
roots = 2
[[mechanism.body]]
name = "crank"
mass = 1
com = [0.15, 0, 0]
inertia = 0.01
joint = { kind = "revolute", axis = [0, 0, 1], q = 2, v = 2 }
[[mechanism.body]]
name = "rod"
mass = 1
com = [0.35, 0, 0]
inertia = 0.02
joint = { kind = "revolute", parent = "crank", axis = [0, 0, 1], at = { xyz = [0.3, 0, 0] }, q = -2.4003046193207145 }
[[mechanism.body]]
name = "slider"
mass = 0.5
inertia = 1e-3
joint = { kind = "prismatic", axis = [1, 0, 0] }
[[loop]]
name = "pin"
body = "m/rod"
to = "m/slider"
kind = "revolute"
axis = [0, 0, 1]
child_at = { xyz = [0.7, 0, 0] }
[[event]]
when = { position = "m/crank", exceeds = 3.1406 }
set = { joint = "m/slider", limits = { upper = 0.4 } }
)";
  for (const char* method : {"rk4", "midpoint"}) {
    CAPTURE(method);
    const std::string run =
        std::string("[integrate]\nmethod = \"") + method + "\"\nstep = 1e-4\nuntil = 0.4585\n[output]\nevery = 1e-4\n";
    const io::Scenario scenario = read_restarted(slider_crank + run);
    check_restarts(scenario, 0.4585, {0.4575, 0.4576, 0.4577, 0.458, 0.4581});
    cli::RestartedRun rests(scenario, "", 0.458);
    CHECK(rests.state().find("\"deeper\"") != std::string::npos);
  }
}

TEST_CASE("a restart goes on where a prescribed motion has pulled a cable apart") {
  for (const char* method : {"stepping", "rk4"}) {
    CAPTURE(method);
    check_restarts(read_restarted(R"(format = 1
[[mechanism]]
name = "m"
[[mechanism.body]]
name = "slider"
mass = 1
inertia = 0.01
[mechanism.body.joint]
kind = "prismatic"
axis = [1, 0, 0]
drive = { motion = { rate = 1, offset = 0.09 } }
[[cable]]
name = "tether"
from = { body = "ground" }
to = { body = "m/slider" }
length = 0.1
[output]
every = 0.01
[integrate]
step = 1e-3
until = 0.04
method = ")" + std::string(method) +
                                  "\"\n"),
                   0.04, {0.02, 0.03});
  }
}
