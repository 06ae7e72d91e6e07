// Drives, friction, soft stops, strengths, forces on bodies and wildcards in conditions, as read from scenarios.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/scenario/events/schedule.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/actions/set.hpp>
#include <tests/bad_input.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;

namespace {

Scenario read(const std::string& text) {
  ReadResult result = read_scenario_text(text, "s.toml");
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return std::move(*result.scenario);
}

JointParameters joint(const std::string& keys, const char* kind = "revolute") {
  return read(one_body + "[mechanism.body.joint]\nkind = \"" + kind + "\"\n" + keys).model[BodyId{0}].joint.parameters;
}

std::vector<std::string> texts(const ScenarioEvent& event) {
  std::vector<std::string> all;
  for (const Action& action : event.actions) all.push_back(action.text());
  return all;
}

}  // namespace

TEST_CASE("an effort is constant, or changes with time") {
  CHECK(joint("drive = { effort = \"2 N m\" }\n").effort == Values{2});
  CHECK(!joint("drive = { effort = 2 }\n").drive);
  const JointParameters p = joint("drive = { effort = { table = [[0, \"2 N m\"], [\"500 ms\", 4]] } }\n");
  CHECK(p.effort.empty());
  REQUIRE(p.drive);
  CHECK(p.drive->effort == std::vector<Signal>{Signal::table({{0, 2}, {0.5, 4}})});
  const JointParameters q =
      joint("drive = { effort = { sine = { amplitude = 2, frequency = \"0.5 Hz\", phase = \"90 deg\", offset = 1 } } }\n");
  CHECK(q.drive->effort[0] == Signal::sine(2, 0.5, std::acos(-1.0) / 2, 1));
  const JointParameters c =
      joint("drive = { effort = [\"1 N m\", { sine = { amplitude = \"2 N\", frequency = 3 } }] }\n", "cylindrical");
  CHECK(c.drive->effort == std::vector<Signal>{1.0, Signal::sine(2, 3)});
}

TEST_CASE("motions at a constant rate, and tables with free ends") {
  const auto motion = [](const std::string& keys) {
    return joint("drive = { motion = " + keys + " }\n").drive->motion[0].signal();
  };
  CHECK(motion("{ rate = \"30 rpm\", offset = \"90 deg\" }") == Signal::ramp(std::acos(-1.0), std::acos(-1.0) / 2));
  CHECK(motion("{ rate = 2 }") == Signal::ramp_from_here(2));
  CHECK(motion("{ table = [[0, 1], [2, 3]], ends = \"free\" }") == Signal::table({{0, 1}, {2, 3}}, Signal::Ends::free));
  CHECK(motion("{ table = [[0, 1], [2, 3]], ends = \"rest\" }") == Signal::table({{0, 1}, {2, 3}}));
  const JointParameters effort = joint("drive = { effort = { rate = \"2 N m/s\" } }\n");
  CHECK(effort.drive->effort[0] == Signal::ramp(2, 0));  // from 0 at time 0

  // The motion begins at the joint's initial position.
  const Scenario scenario =
      read(one_body + "[mechanism.body.joint]\nkind = \"revolute\"\nangle = 0.3\ndrive = { motion = { rate = 2 } }\n");
  CHECK(scenario.model[BodyId{0}].q[0] == 0.3);
  CHECK(scenario.model[BodyId{0}].v[0] == 2);
  CHECK(scenario.model[BodyId{0}].joint.parameters.drive->motion[0].at(1).value == doctest::Approx(2.3));
}

TEST_CASE("position control and prescribed motion") {
  const JointParameters p = joint(
      "drive = { effort = 1, pd = { kp = \"3 N m/rad\", kd = \"0.2 N m s\", target = { sine = { amplitude = \"30 deg\", "
      "frequency = 1 } }, "
      "target_speed = 2, max_effort = \"5 N m\" } }\n");
  CHECK(p.effort == Values{1});
  REQUIRE(p.drive);
  CHECK(p.drive->pd.kp == Values{3});
  CHECK(p.drive->pd.kd == Values{0.2});
  CHECK(p.drive->pd.target[0].amplitude() == doctest::Approx(std::acos(-1.0) / 6));
  CHECK(p.drive->pd.target_speed[0] == Signal(2));
  CHECK(p.drive->pd.max_effort == Values{5});
  const Scenario s = read(one_body +
                          "[mechanism.body.joint]\nkind = \"prismatic\"\nposition = \"1 m\"\n"
                          "drive = { motion = { table = [[0, \"1 m\"], [2, \"300 cm\"]] } }\n");
  const BodySpec& moved = s.model[BodyId{0}];
  REQUIRE(moved.joint.parameters.drive);
  CHECK(moved.joint.parameters.drive->motion[0].signal() == Signal::table({{0, 1}, {2, 3}}));
  CHECK(moved.q == Values{1});
  const Scenario t = read(pinned + "drive = { motion = { sine = { amplitude = 0.5, frequency = 1, offset = 2 } } }\n");
  CHECK(t.model[BodyId{0}].q == Values{2});
  CHECK(t.model[BodyId{0}].v[0] == doctest::Approx(std::acos(-1.0)));
}

TEST_CASE("friction, soft stops and strength") {
  const JointParameters p = joint(
      "friction = { coulomb = \"0.5 N m\", speed = \"0.1 rad/s\" }\nstrength = { force = \"2 kN\" }\n"
      "limits = { lower = \"-90 deg\", upper = inf, stiffness = \"100 N m/rad\", damping = 2 }\n");
  CHECK(p.friction.coulomb == Values{0.5});
  CHECK(p.friction.speed == Values{0.1});
  CHECK(p.strength.force == 2000);
  CHECK(std::isinf(p.strength.torque));
  CHECK(p.limits.stiffness == Values{100});
  CHECK(p.limits.damping == Values{2});
  CHECK(std::isinf(p.limits.upper[0]));
  CHECK(p.limits.soft());
}

TEST_CASE("a chain has joint tables for all of its joints") {
  const Scenario s = read(chain +
                          "inertia = 1\nfriction = { coulomb = 1, speed = 0.1 }\nstrength = { force = 5, torque = 6 }\n"
                          "drive = { effort = { sine = { amplitude = 1, frequency = 2 } } }\nstiffness = 3\n");
  for (int k = 0; k < 3; ++k) {
    const JointParameters& p = s.model[BodyId{k}].joint.parameters;
    CHECK(p.friction.coulomb == Values{1});
    CHECK(p.strength.torque == 6);
    CHECK(p.drive->effort[0].frequency() == 2);
    CHECK(p.stiffness == Values{3});
  }
}

TEST_CASE("events set joint parameters, and give them to the joints that they make, with units or without") {
  const Scenario s =
      read(pinned +
           "[[event]]\nat = 1\nset = { joint = \"m/a\", drive = { pd = { kp = \"2 N m\", target = \"10 deg\" } }, "
           "friction = { coulomb = \"1 N m\", speed = 1 }, strength = { force = 3 } }\n"
           "[[event]]\nat = 2\nchange = { joint = \"m/a\", kind = \"prismatic\", limits = { upper = \"3 cm\", stiffness = "
           "\"2 N/m\" }, drive = { effort = { table = [[0, \"1 N\"], [3, 2]] } } }\n");
  const auto& set = dynamic_cast<const actions::Set&>(*s.events[0].actions[0]);
  CHECK(set.parameters.drive->pd.kp == Values{2});
  CHECK(set.parameters.friction.coulomb == Values{1});
  CHECK(set.parameters.strength.force == 3);
  CHECK(texts(s.events[1]) == std::vector<std::string>{"change m/a to prismatic"});
}

TEST_CASE("forces on bodies: constant and changing, in either axes, for every match of a wildcard") {
  const Scenario s =
      read(chain +
           "inertia = 1\n[[force]]\nbody = \"m/2\"\npoint = [\"50 cm\", 0, 0]\naxes = \"body\"\n"
           "force = [\"3 N\", { sine = { amplitude = \"2 N\", frequency = 1 } }, { table = [[0, 1], [1, 2]] }]\n"
           "torque = [0, 0, \"1 N m\"]\n"
           "[[force]]\nbody = \"m/*\"\ndrag = { linear = \"0.1 N s/m\", quadratic = \"0.6 kg/m^3\", area = \"20 cm^2\" }\n");
  REQUIRE(s.model.forces().size() == 4);
  const BodyForce& f = s.model.forces()[0];
  CHECK(f.body == BodyId{1});
  CHECK(f.point == Vec3{0.5, 0, 0});
  CHECK(f.body_axes);
  CHECK(f.force[0] == Signal(3));
  CHECK(f.force[1] == Signal::sine(2, 1));
  CHECK(f.force[2] == Signal::table({{0, 1}, {1, 2}}));
  CHECK(f.torque[2] == Signal(1));
  for (int k = 0; k < 3; ++k) {
    const BodyForce& each = s.model.forces()[static_cast<std::size_t>(k + 1)];
    CHECK(each.body == BodyId{k});
    CHECK(each.drag == Drag{0.1, 0.6, 0.002});
    CHECK(!each.body_axes);
  }
}

TEST_CASE("a wildcard in a condition arms one event for each match, and actions with the wildcard act on that match") {
  const Scenario s = read(chain +
                          "inertia = 1\n[[event]]\nname = \"overload\"\nwhen = { reaction_force = \"m/*\", exceeds = \"3 N\" }\n"
                          "break = \"m/*\"\nset = { joint = \"m/1\", damping = 1 }\n"
                          "[[event]]\nafter = \"overload\"\nlock = \"m/2\"\n"
                          "[[event]]\nwhen = { height = { body = \"m/*\", point = [1, 0, 0] }, below = -2 }\nlock = \"m/*\"\n"
                          "impulse = { body = \"m/*\", force = [1, 0, 0] }\n");
  REQUIRE(s.events.size() == 7);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = "m/" + std::to_string(k + 1);
    CHECK(s.events[k].name == "overload");
    CHECK(s.events[k].wild);
    REQUIRE(s.events[k].condition);
    CHECK(s.events[k].condition->what->joints() == std::vector<std::string>{name});
    CHECK(texts(s.events[k]) == std::vector<std::string>{"break " + name, "set m/1"});
    CHECK(s.events[k + 4].condition->what->bodies() == std::vector<std::string>{name});
    CHECK(texts(s.events[k + 4]) == std::vector<std::string>{"lock " + name, "impulse " + name});
  }
  CHECK(s.events[3].after == "overload");
}

TEST_CASE("each joint of a chain breaks at its own load") {
  // A chain hanging at rest: the upper joints carry more.
  const Scenario s = read(
      "format = 1\n[world]\ngravity = [10, 0, 0]\n[[mechanism]]\nname = \"m\"\n[mechanism.chain]\nlinks = 4\nlength = 1\nmass = "
      "1\n"
      "inertia = 0.1\n[[event]]\nname = \"overload\"\nwhen = { reaction_force = \"m/*\", exceeds = 25 }\nbreak = \"m/*\"\n");
  Simulation simulation(s.model, s.integration);
  std::vector<const ScenarioEvent*> events;
  for (const ScenarioEvent& event : s.events) events.push_back(&event);
  CHECK(schedule(simulation, events).problems.empty());
  REQUIRE(simulation.run_until(0.1) == Status::ok);
  // Joint 1 breaks at its strength of 40 N, and with it all weight is gone.
  REQUIRE(simulation.events().size() == 1);
  CHECK(simulation.events()[0].name == "overload");
  CHECK(simulation.events()[0].action_texts() == std::vector<std::string>{"break m/1"});
}

TEST_CASE("an event may follow the break of a joint by its own strength") {
  const std::string text =
      "format = 1\n[world]\ngravity = [10, 0, 0]\n[[mechanism]]\nname = \"m\"\n[mechanism.chain]\nlinks = 2\nlength = 1\nmass = "
      "1\n"
      "inertia = 0.1\nstrength = { force = 15 }\n[[event]]\nname = \"then\"\n";
  const Scenario s =
      read(text + "after = { event = \"strength of m/1\", delay = 0.05 }\nimpulse = { body = \"m/2\", force = [1, 0, 0] }\n");
  Simulation simulation(s.model, s.integration);
  CHECK(schedule(simulation, {&s.events[0]}).problems.empty());
  REQUIRE(simulation.run_until(0.1) == Status::ok);
  REQUIRE(simulation.events().size() == 2);
  CHECK(simulation.events()[0].name == "strength of m/1");
  CHECK(simulation.events()[1].time == 0.05);
  CHECK(said(read_scenario_text(text + "after = \"strength of m/3\"\nbreak = \"m/2\"\n", "s.toml")) ==
        "s.toml:14:9: error: after: there is no event 'strength of m/3' that could come before; did you mean 'strength of m/1'?");
}
