// A run that ends and one that starts from its final state are together identical to one continuous run, to the last bit.
#include <cmath>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <cli/restart_test_support.hpp>

using namespace momentree;
using momentree::cli::check_restarts;
using momentree::cli::read_restarted;
using momentree::cli::RestartedRun;
using momentree::io::Session;

namespace {

// A pendulum that swings past every kind of condition, and a chain whose joints are monitored one by one.
std::string swinging(const std::string& method) {
  return R"(format = 1
[[mechanism]]
name = "p"
[[mechanism.body]]
name = "bob"
mass = 1
com = [0, 0, -1]
inertia = 0.1
[mechanism.body.joint]
kind = "revolute"
axis = [0, 1, 0]
angle = 1
damping = 0.05
drive = { effort = { table = [[0, 0], [0.25, 1], [1.3, -1], [1.9, 0.5]] } }
[[mechanism]]
name = "c"
[mechanism.chain]
links = 3
length = 0.5
mass = 1
inertia = 0.05
axis = [0, 1, 0]
angle = 0.2
[[mechanism]]
name = "t"
[[mechanism.body]]
name = "trolley"
mass = 2
inertia = 0.1
[mechanism.body.joint]
kind = "prismatic"
axis = [1, 0, 0]
drive = { motion = { table = [[0, 0], [0.7, 0.4], [1.6, -0.3], [2.5, 0.2]] } }
[[mechanism.body]]
name = "swing"
mass = 1
com = [0, 0, -0.6]
inertia = 0.05
[mechanism.body.joint]
kind = "ball"
parent = "trolley"
friction = { coulomb = 0.02, speed = 0.1 }
strength = { force = 12.5 }
[[force]]
body = "c/3"
force = [{ sine = { amplitude = 3, frequency = 0.8 } }, 0, 0]
drag = { linear = 0.2, quadratic = 0.1 }
[[event]]
name = "again"
when = { position = "p/bob", below = 0.5 }
repeat = true
hysteresis = 1.2
set = { joint = "p/bob", damping = 0.06 }
[[event]]
name = "held"
when = { speed = "p/bob", below = -1 }
for = "150 ms"
impulse = { body = "c/1", torque = [0, 0.1, 0] }
[[event]]
name = "later"
after = { event = "again", delay = 0.33 }
impulse = { body = "p/bob", torque = [0, 0.05, 0] }
[[event]]
name = "once"
at = 0.3
impulse = { body = "p/bob", torque = [0, 0.01, 0] }
[[event]]
name = "then"
after = { event = "once", delay = 1.1 }
impulse = { body = "p/bob", torque = [0, 0.02, 0] }
[[event]]
name = "and then"
after = { event = "then", delay = 0.2 }
impulse = { body = "p/bob", torque = [0, 0.02, 0] }
[[event]]
name = "clock"
every = 0.25
from = 0.25
impulse = { body = "c/2", torque = [0, 0.02, 0] }
[[event]]
name = "watch"
when = { height = { body = "c/*", point = [0.5, 0, 0] }, below = -0.4 }
set = { joint = "c/*", damping = 0.4 }
[integrate]
until = 3
)" + method +
         "[output]\nevery = 0.125\n";
}

}  // namespace

TEST_CASE("a restart continues as the run would have: conditions, delays, periods, wildcards, and the steps of a method") {
  for (const char* method : {"method = \"rk4\"\nstep = 0.007\n", "method = \"dopri5\"\nrtol = 1e-7\n",
                             "method = \"dop853\"\nrtol = 1e-9\n", "method = \"midpoint\"\nstep = 0.02\n"}) {
    CAPTURE(method);
    check_restarts(read_restarted(swinging(method)), 3, {0.125, 0.25, 0.5, 0.625, 1.0, 1.375, 1.5, 2.125});
  }
}

TEST_CASE("actions that a run skips are also skipped by a run that continues from its state") {
  const std::string head = R"(format = 1
[integrate]
until = 0.6
[output]
every = 0.1
[[mechanism]]
name = "m"
[[mechanism.body]]
name = "a"
mass = 1
com = [0.5, 0, 0]
inertia = 0.01
[mechanism.body.joint]
kind = "revolute"
axis = [0, 1, 0]
v = 1
)";
  check_restarts(read_restarted(head + R"([[event]]
when = { position = "m/a", exceeds = 0.1 }
lock = "m/a"
[[event]]
at = 0.4
lock = "m/a"
)"),
                 0.6, {0.2, 0.4});
  check_restarts(read_restarted(head + R"([[event]]
every = 0.15
from = 0.15
free = "m/a"
)"),
                 0.6, {0.2, 0.5});
}

TEST_CASE("a restart keeps couplings and the file's order at one instant") {
  check_restarts(read_restarted(R"(format = 1
[integrate]
step = 0.004
until = 1
[output]
every = 0.125
[[mechanism]]
name = "m"
root = "free"
[[mechanism.body]]
name = "b1"
mass = 5
inertia = [0.015, 0.011, 0.011]
[[mechanism.body]]
name = "b2"
mass = 0.5
inertia = [0.03, 0.02, 0.026]
[mechanism.body.joint]
name = "jb2"
kind = "weld"
parent = "b1"
child_at = { xyz = [0.17, 0.163, 0.281], rpy = [2.88, -1.81, -2.22] }
[[mechanism.body]]
name = "b3"
mass = 3
inertia = [0.192, 0.144, 0.12]
[mechanism.body.joint]
kind = "prismatic"
axis = [0.258, 0.399, 0.477]
parent = "b2"
at = { xyz = [-0.238, 0.153, 0.223] }
[[mechanism.body]]
name = "b4"
mass = 0.2
inertia = [0.0088, 0.0072, 0.008]
[mechanism.body.joint]
kind = "prismatic"
parent = "b3"
at = { xyz = [-0.451, 0.147, -0.383], rpy = [2.25, 1.06, -2.65] }
q = -0.55
[[coupling]]
joint = "m/b3"
follows = "m/b4"
multiplier = 0.532
stiffness = 3
[[event]]
name = "free"
at = 0.375
free = "m/jb2"
[[event]]
name = "late"
after = { event = "free", delay = 0.125 }
set = { joint = "m/b3", damping = 0.1 }
[[event]]
name = "known"
at = 0.5
set = { joint = "m/b3", damping = 0.2 }
)"),
                 1, {0.25, 0.375, 0.5, 0.75});
}

TEST_CASE("events that differ by rounding do not contradict one another after a restart") {
  check_restarts(read_restarted(R"(format = 1
[integrate]
until = 0.4
[[mechanism]]
name = "p"
[[mechanism.body]]
name = "bob"
mass = 1
inertia = 0.1
[mechanism.body.joint]
kind = "revolute"
v = 1
[[event]]
name = "first"
at = 0.1
set = { joint = "p/bob", damping = 0.1 }
[[event]]
name = "unlock"
after = { event = "first", delay = 0.20000000000000004 }
unlock = "p/bob"
[[event]]
name = "lock"
every = 0.1
from = 0.2
lock = "p/bob"
)"),  // the second of these is at 0.3, a rounding before the end of the delay
                 0.4, {0.13, 0.2});
}

TEST_CASE("rows and periodic events are at the decimal instants that a user writes, so that a run may stop and continue there") {
  const std::string text = R"(format = 1
[integrate]
until = 0.9
method = "METHOD"
[output]
every = 0.05
[[mechanism]]
name = "p"
[[mechanism.body]]
name = "bob"
mass = 1
com = [0, 0, -1]
inertia = 0.1
[mechanism.body.joint]
kind = "revolute"
axis = [0, 1, 0]
angle = 1
[[event]]
name = "kick"
every = 0.1
from = 0.1
impulse = { body = "p/bob", force = [0.1, 0, 0] }
)";  // 3 * 0.1, 3 * 0.05, 6 * 0.05 and 7 * 0.05 are a rounding after 0.3, 0.15, 0.3 and 0.35
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    CAPTURE(method);
    std::string with = text;
    with.replace(with.find("METHOD"), 6, method);
    check_restarts(read_restarted(with), 0.9, {0.15, 0.3, 0.35, 0.6, 0.7});
  }
}

TEST_CASE("a periodic event that would be refused after the end is no reason to refuse a restart") {
  const std::string text = R"(format = 1
[integrate]
until = 0.25
[output]
every = 0.125
[[mechanism]]
name = "a"
root = "free"
[[mechanism.body]]
name = "a"
mass = 1
inertia = 0.01
[[mechanism]]
name = "b"
root = "free"
pose = { xyz = [1, 0, 0] }
[[mechanism.body]]
name = "b"
mass = 1
inertia = 0.01
[[event]]
name = "w"
every = 0.23
from = 0.1
weld = { body = "b/b", to = "a/a" }
)";
  check_restarts(read_restarted(text), 0.25, {0.125});
  const io::test::TemporaryFolder folder;  // one that is due is refused at its instant, as in the direct run
  io::Scenario longer = read_restarted(text);
  longer.until = 0.5;
  const RestartedRun first(longer, "", 0.25);
  io::write_text_file(folder / "state.json", io::state_json(first.session.simulation().world(), first.session.armed(), {}));
  Session second(longer, momentree::cli::documents_of(folder / "state.json", longer.model));
  static_cast<void>(second.schedule());
  CHECK(second.run() == Status::refused);
  CHECK(second.simulation().time() == 0.33);
}

TEST_CASE("a document reads back to the same text after the ground has become the parent of another body") {
  check_restarts(read_restarted(R"(format = 1
[integrate]
until = 0.5
[output]
every = 0.125
[[mechanism]]
name = "m"
root = "free"
[[mechanism.body]]
name = "a"
mass = 1
inertia = 0.01
[[mechanism.body]]
name = "b"
mass = 1
inertia = 0.01
joint = { kind = "revolute", name = "j", parent = "a" }
[[event]]
at = 0.1
weld = { body = "m/b" }
[[event]]
at = 0.2
break = "m/j"
[[event]]
at = 0.3
set = { joint = "m/a", damping = 0.1 }
)"),
                 0.5, {0.125, 0.25, 0.375, 0.5});
}

TEST_CASE("a restart keeps a cable taut next to a coupling's spring") {
  for (const char* method : {"rk4", "dopri5", "dop853"}) {
    CAPTURE(method);
    check_restarts(read_restarted(R"(format = 1
[[mechanism]]
name = "m0"
[[mechanism.body]]
name = "b0"
mass = 1
inertia = [0.01, 0.02, 0.012]
[[mechanism]]
name = "m1"
[[mechanism.body]]
name = "b0"
mass = 0.4
inertia = 0.005
[[mechanism.body]]
name = "b1"
mass = 0.7
inertia = 0.004
joint = { kind = "prismatic", name = "j1", parent = "b0" }
[[mechanism.body]]
name = "b3"
mass = 3
inertia = [0.01, 0.011, 0.012]
joint = { kind = "revolute", parent = "b1" }
[[coupling]]
joint = "m1/j1"
follows = "m1/b3"
stiffness = 9
[[cable]]
name = "C0"
from = { body = "m1/b3" }
to = { body = "m0/b0", point = [0.03, -0.05, -0.03] }
[integrate]
method = ")" + std::string(method) +
                                  R"("
until = 0.5
[output]
every = 0.06
)"),
                   0.5, {0.12, 0.18, 0.3});
  }
}

TEST_CASE("every file in scenarios/ continues with the same bits") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(MOMENTREE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    CAPTURE(entry.path());
    const io::ReadResult result = io::read_scenario(entry.path().string(), {"output.every=0.1"});
    REQUIRE(result.scenario);
    check_restarts(*result.scenario, 0.6, {0.3}), ++files;
  }
  CHECK(files > 40);
}

TEST_CASE("the events of a document must fit the scenario") {
  const io::Scenario scenario = read_restarted(swinging("step = 0.01\n"));
  const io::test::TemporaryFolder folder;
  const std::string file = folder / "state.json";
  const auto refused = [&](const std::string& armed) {
    io::write_text_file(file, "{\"armed\": " + armed + "}");
    return io::test::error_of([&] { const Session session(scenario, momentree::cli::documents_of(file, scenario.model)); });
  };
  CHECK(refused(R"({"agai": {"fired": 1}})").find("names an unknown event 'agai'; did you mean 'again'?") != std::string::npos);
  CHECK(refused(R"({"watch": {"fired": 1, "each": [{"fired": 1}]}})")
            .find("`armed` has 1 entries for event 'watch', which has 3 matches") != std::string::npos);
  CHECK(refused(R"({"again": {"fired": 1, "resting": 1}})").find("resting: expected true or false, found a number") !=
        std::string::npos);
  CHECK(refused(R"({"again": {"fired": 1, "looked": []}})").find("looked: expected one or two entries") != std::string::npos);
}

namespace {

// Bodies that slide, roll, bounce until they rest, hang on a cable, and land on each other.
std::string touching(const std::string& method) {
  const auto body = [](const std::string& name, const std::string& place, const std::string& velocity, const std::string& shape) {
    return "[[mechanism]]\nname = \"" + name + "\"\nroot = \"free\"\npose = { " + place + " }\nstate = { velocity = { " +
           velocity + " } }\n[[mechanism.body]]\nname = \"" + name +
           "\"\nmass = 1\ninertia = [0.01, 0.012, 0.014]\ncollision = { " + shape + " }\n";
  };
  return "format = 1\n[world]\nfloor = { friction = 0.3, restitution = 0.4 }\n" +
         body("slider", "xyz = [0, 3, 0.1]", "linear = [2, 0.3, 0], angular = [0, 0, 1]", "box = [0.4, 0.3, 0.2]") +
         body("wheel", "xyz = [0, -3, 0.2], rpy = [1.5707963267948966, 0, 0]", "linear = [1, 0, 0]",
              "cylinder = { radius = 0.2, length = 0.1 }") +
         body("ball", "xyz = [0, 6, 0.3]", "linear = [1, 0, 0], angular = [3, 2, 1]", "sphere = 0.1") +
         body("bob", "xyz = [0.5, -6, 2]", "linear = [0, 1, 0]", "sphere = 0.1") +
         body("lower", "xyz = [0, 0, 0.1]", "linear = [0, 0, 0]", "box = [0.4, 0.4, 0.2]") +
         body("upper", "xyz = [0.1, 0, 0.4]", "angular = [0, 0.5, 0.2]", "box = [0.4, 0.3, 0.2]") +
         "[[cable]]\nname = \"tether\"\nfrom = { body = \"ground\", point = [0, -6, 3] }\n"
         "to = { body = \"bob/bob\" }\nlength = 1.2\n"
         "[[event]]\nname = \"kick\"\nwhen = { contact_force = [\"upper\", \"lower\"], exceeds = 15 }\n"
         "impulse = { body = \"slider/slider\", force = [0, 0.2, 0] }\n[integrate]\nuntil = 2\n" +
         method + "[output]\nevery = 0.125\n";
}

}  // namespace

TEST_CASE("a restart continues with the contacts of the run: closed ones, bounces that end, taut cables, time stepping") {
  for (const char* method : {"method = \"rk4\"\nstep = 0.002\n", "method = \"dopri5\"\nrtol = 1e-7\n", "method = \"dop853\"\n",
                             "method = \"stepping\"\nstep = 0.004\n"}) {
    CAPTURE(method);
    check_restarts(read_restarted(touching(method)), 2, {0.125, 0.375, 0.5, 0.75, 1.125, 1.5});
  }
}

TEST_CASE("a document of a run through contacts that ended before its first step reads back the same") {
  const io::Scenario scenario = read_restarted(R"(format = 1
[world]
floor = true
[[mechanism]]
name = "m"
root = "free"
pose = { xyz = [0, 0, 0.1] }
[[mechanism.body]]
name = "ball"
mass = 1
inertia = 0.01
collision = { sphere = 0.1 }
[integrate]
method = "stepping"
step = 1e-3
until = 1
)");
  Session ended(scenario, {});
  REQUIRE(ended.simulation().run_until(0) == Status::ok);
  const auto document = [](const Session& of) {
    return io::state_json(of.simulation().world(), of.armed(), step_memory(of.simulation()));
  };
  const io::test::TemporaryFolder folder;
  const std::string file = folder / "state.json";
  io::write_text_file(file, document(ended));
  Session again(scenario, momentree::cli::documents_of(file, scenario.model));
  CHECK(document(again) == document(ended));
  // With other forces, contacts are found anew.
  const io::Scenario lighter = [&] {
    io::Scenario other = scenario;
    other.model.set_gravity({0, 0, -1});
    return other;
  }();
  Session other(lighter, momentree::cli::documents_of(file, lighter.model));
  CHECK(norm(other.simulation().world().accelerations()[0].linear) < 1e-12);
}
