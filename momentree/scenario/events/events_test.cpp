#include <doctest/doctest.h>

#include <cmath>

#include <momentree/scenario/events/schedule.hpp>
#include <momentree/simulate/actions/attach.hpp>
#include <momentree/simulate/actions/impulse.hpp>
#include <momentree/simulate/actions/lock.hpp>
#include <momentree/simulate/actions/set.hpp>
#include <tests/bad_input.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;

namespace {

const std::string arm = pinned +
                        "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n"
                        "[mechanism.body.joint]\nname = \"j\"\nkind = \"universal\"\naxis2 = [1, 0, 0]\nparent = \"a\"\n"
                        "[[mechanism]]\nname = \"f\"\nroot = \"free\"\npose = { xyz = [2, 0, 0] }\n"
                        "[[mechanism.body]]\nname = \"x\"\nmass = 1\ninertia = 1\n";

Scenario read(const std::string& text) {
  ReadResult result = read_scenario_text(text, "s.toml");
  REQUIRE_MESSAGE(result.scenario.has_value(), said(result));
  CHECK(said(result) == "");
  return std::move(*result.scenario);
}

std::vector<std::string> texts(const ScenarioEvent& event) {
  std::vector<std::string> all;
  for (const Action& action : event.actions) all.push_back(action.text());
  return all;
}

template <class A>
const A& as(const Action& action) {
  const auto* found = dynamic_cast<const A*>(&*action);
  REQUIRE(found != nullptr);
  return *found;
}

}  // namespace

TEST_CASE("every action, in the order of the keys") {
  const Scenario s =
      read(arm +
           "[[event]]\nname = \"dock\"\nat = 1\n"
           "impulse = { body = \"f/x\", force = [\"2 N s\", 0, 0], torque = [0, \"1 N m s\", 0], point = [\"5 cm\", 0, 0] }\n"
           "attach = { body = \"f/x\", to = \"m/b\", kind = \"prismatic\", axis = [0, 2, 0], damping = \"3 N s/m\", "
           "at = { xyz = [0, 1, 0] } }\n"
           "lock = [\"m/a\", { joint = \"m/j\", freedoms = [1] }]\n"
           "set = { joint = \"dock\", stiffness = \"5 N/cm\", rest = [\"1 cm\"], drive = { effort = \"2 N\" } }\n"
           "[[event]]\nat = 2\nunlock = \"m/a\"\nbreak = \"dock\"\nfree = \"m/j\"\n"
           "[[event]]\nat = 3\nweld = { body = \"f/x\" }\nchange = { joint = \"m/j\", kind = \"weld\" }\n");
  REQUIRE(s.events.size() == 3);
  CHECK(s.events[0].named);
  CHECK_FALSE(s.events[1].named);
  CHECK(texts(s.events[0]) ==
        std::vector<std::string>{"impulse f/x", "attach f/x to m/b", "lock m/a", "lock m/j [1]", "set dock"});
  CHECK(texts(s.events[1]) == std::vector<std::string>{"unlock m/a", "break dock", "free m/j"});
  CHECK(texts(s.events[2]) == std::vector<std::string>{"weld f/x to ground", "change m/j to weld"});

  const auto& impulse = as<actions::Impulse>(s.events[0].actions[0]);
  CHECK(impulse.force == Vec3{2, 0, 0});
  CHECK(impulse.torque == Vec3{0, 1, 0});
  CHECK(impulse.point == Vec3{0.05, 0, 0});
  const auto& attach = as<actions::Attach>(s.events[0].actions[1]);
  CHECK(attach.joint.spec.kind == Kind::prismatic);
  CHECK(attach.joint.spec.axis == Vec3{0, 2, 0});
  CHECK(attach.joint.spec.parameters.damping == Values{3});
  REQUIRE(attach.at.has_value());
  CHECK(attach.at->position == Vec3{0, 1, 0});
  CHECK(as<actions::Lock>(s.events[0].actions[3]).dofs == std::vector<int>{1});
  const auto& set = as<actions::Set>(s.events[0].actions[4]);  // in the units of the joint that the event makes
  CHECK(set.parameters.stiffness == Values{500});
  CHECK(set.parameters.rest == Values{0.01});
  CHECK(set.parameters.effort == Values{2});
}

TEST_CASE("units of `set` are those of the joint's kind at that time") {
  const Scenario s = read(arm +
                          "[[event]]\nat = 1\nset = { joint = \"m/a\", damping = \"2 N m s\" }\n"
                          "[[event]]\nat = 2\nchange = { joint = \"m/a\", kind = \"prismatic\" }\n"
                          "[[event]]\nat = 3\nset = { joint = \"m/a\", damping = \"2 N s/m\" }\n");
  CHECK(s.events.size() == 3);
}

TEST_CASE("a wildcard in a table is one event for each match") {
  const Scenario s =
      read(chain + "[[event]]\nname = \"stiffen\"\nat = 1\nset = { joint = \"m/*\", stiffness = \"2 N m\" }\nlock = \"m/2\"\n");
  REQUIRE(s.events.size() == 4);
  CHECK(texts(s.events[0]) == std::vector<std::string>{"lock m/2"});
  for (std::size_t i = 1; i < 4; ++i) {
    CHECK(s.events[i].name == "stiffen");
    CHECK(s.events[i].wild);
    const auto& set = as<actions::Set>(s.events[i].actions.at(0));
    CHECK(set.name == "m/" + std::to_string(i));
    CHECK(set.parameters.stiffness == Values{2});
  }
}

TEST_CASE("later events find joints that earlier ones make, wherever they are in the file") {
  const Scenario s = read(arm +
                          "[[event]]\nat = 2\nbreak = \"grasp\"\n"
                          "[[event]]\nname = \"grasp\"\nat = 1\nweld = { body = \"f/x\", to = \"m/b\" }\n"
                          "[[event]]\nat = 3\nbreak = \"m/j\"\n"
                          "[[event]]\nat = 4\nattach = { body = \"m/b\", kind = \"ball\" }\n"
                          "[[event]]\nat = 5\nbreak = \"ground+m/b\"\n");
  Simulation simulation(s.model, s.integration);
  std::vector<const ScenarioEvent*> events;
  for (const ScenarioEvent& event : s.events) events.push_back(&event);
  const Schedule scheduled = schedule(simulation, events);
  CHECK(scheduled.problems.empty());
  CHECK(scheduled.events[0]->name == "grasp");
  REQUIRE(simulation.run_until(5) == Status::ok);
  REQUIRE(simulation.events().size() == 5);
  CHECK(simulation.events()[1].name == "#1");
  CHECK(simulation.events()[4].action_texts() == std::vector<std::string>{"break ground+m/b"});
  CHECK(simulation.world().mechanism_names() == std::vector<std::string>{"m", "m/b", "f/x"});
}

TEST_CASE("joints that actions make have the names that the actions give them, which later actions use") {
  for (const std::string join :
       {"weld = { body = \"f/x\", to = \"m/b\"", "attach = { body = \"f/x\", to = \"m/b\", kind = \"ball\""}) {
    const std::string capture = arm + "[[event]]\nname = \"capture\"\nat = 1\n" + join + ", name = \"m/clasp\" }\n";
    const Scenario s = read(capture + "[[event]]\nat = 2\nbreak = \"m/clasp\"\n");
    Simulation simulation(s.model, s.integration);
    std::vector<const ScenarioEvent*> events;
    for (const ScenarioEvent& event : s.events) events.push_back(&event);
    CHECK(schedule(simulation, events).problems.empty());
    REQUIRE(simulation.run_until(1) == Status::ok);
    CHECK(simulation.world().find_joint("m/clasp") >= 0);
    CHECK(simulation.world().find_joint("capture") < 0);
    REQUIRE(simulation.run_until(2) == Status::ok);
    CHECK(simulation.events()[1].action_texts() == std::vector<std::string>{"break m/clasp"});
    CHECK(simulation.world().mechanism_names() == std::vector<std::string>{"m", "f/x"});
    check({{capture + "[[event]]\nat = 2\nbreak = \"capture\"\n",
            "s.toml:33:9: error: break: there is no joint 'capture'; the event of that name makes the joint 'm/clasp'"}});
  }
  check({{arm + "[[event]]\nat = 1\nweld = { body = \"*/x\", to = \"m/b\", name = \"clasp\" }\n",
          "s.toml:29:43: error: weld: joints that a wildcard makes can't all be named 'clasp'; leave out the name: each is then "
          "named "
          "after its bodies"}});
}

TEST_CASE("the free joint of a separated part has its body's name") {
  const auto done = [](const std::string& text) {
    const Scenario s = read(text);
    Simulation simulation(s.model, s.integration);
    std::vector<const ScenarioEvent*> events;
    for (const ScenarioEvent& event : s.events) events.push_back(&event);
    CHECK(schedule(simulation, events).problems.empty());
    REQUIRE(simulation.run_until(2) == Status::ok);
    std::vector<std::string> all;
    for (const Event& event : simulation.events())
      for (const std::string& action : event.action_texts()) all.push_back(action);
    return all;
  };
  CHECK(done(arm + "[[event]]\nat = 1\nbreak = \"m/j\"\n"
                   "[[event]]\nat = 2\nset = { joint = \"m/b\", damping = [1, 1, 1, 1, 1, 1] }\n") ==
        std::vector<std::string>{"break m/j", "set m/b"});
  // A joint has the body's name already.
  CHECK(done(one_body +
             "[mechanism.body.joint]\nname = \"h\"\nkind = \"revolute\"\n[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = "
             "1\n[mechanism.body.joint]\nname = \"a\"\nkind = \"revolute\"\nparent = \"a\"\n[[event]]\nat = 1\nbreak = \"m/h\"\n"
             "[[event]]\nat = 2\nlock = \"m/a~free\"\n") == std::vector<std::string>{"break m/h", "lock m/a~free"});
}

TEST_CASE("matches of an event with an unknown instant happen together") {
  const Scenario s = read(
      "format = 1\n[world]\ngravity = [0, -10, 0]\n[[mechanism]]\nname = \"m\"\n[mechanism.chain]\nlinks = 3\nlength = 1\n"
      "mass = 1\ninertia = 0.1\n[[event]]\nname = \"low\"\nwhen = { height = \"m/3\", below = -0.5 }\nlock = \"m/*\"\n"
      "[[event]]\nafter = { event = \"low\", delay = 0.1 }\nunlock = \"m/*\"\n"
      "[[event]]\nname = \"slow\"\nevery = 0.25\nset = { joint = \"m/*\", damping = 0.01 }\n");
  REQUIRE(s.events.size() == 3);
  Simulation simulation(s.model, s.integration);
  std::vector<const ScenarioEvent*> events;
  for (const ScenarioEvent& event : s.events) events.push_back(&event);
  CHECK(schedule(simulation, events).problems.empty());
  REQUIRE(simulation.run_until(0.6) == Status::ok);
  int set = 0;
  double low = -1;
  for (const Event& event : simulation.events()) {
    if (event.name == "slow") {
      ++set;
      CHECK(event.action_texts() == std::vector<std::string>{"set m/1", "set m/2", "set m/3"});
    } else if (event.name == "low") {
      low = event.time;
      CHECK(event.action_texts() == std::vector<std::string>{"lock m/1", "lock m/2", "lock m/3"});
    } else {
      CHECK(event.time == doctest::Approx(low + 0.1).epsilon(1e-12));
      CHECK(event.action_texts() == std::vector<std::string>{"unlock m/1", "unlock m/2", "unlock m/3"});
    }
  }
  CHECK(low > 0);
  CHECK(set == 3);
}

TEST_CASE("repeated matches of a wildcard are not an error") {
  const Scenario s = read(arm + "[[event]]\nat = 1\nbreak = \"m/j\"\n[[event]]\nat = 2\nlock = \"m/*\"\n");
  CHECK(s.events.size() == 3);
}

TEST_CASE("limits of joints, infinite where there is no stop") {
  const Scenario s = read(pinned +
                          "limits = { lower = \"-90 deg\", upper = inf, restitution = 0.5, rest_speed = \"1 mrad/s\" }\n"
                          "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n"
                          "[mechanism.body.joint]\nkind = \"cylindrical\"\nparent = \"a\"\nlimits = { upper = [inf, \"5 cm\"] }\n"
                          "[[event]]\nat = 1\nset = { joint = \"m/b\", limits = { lower = [\"-1 deg\", -inf] } }\n");
  const JointLimits& one = s.model[{0}].joint.parameters.limits;
  CHECK(one.lower_of(0) == doctest::Approx(-1.5707963267948966));
  CHECK(std::isinf(one.upper_of(0)));
  CHECK(one.restitution_of(0) == 0.5);
  CHECK(one.rest_speed == 0.001);
  const JointLimits& two = s.model[{1}].joint.parameters.limits;
  CHECK(std::isinf(two.lower_of(1)));
  CHECK(std::isinf(two.upper_of(0)));
  CHECK(two.upper_of(1) == 0.05);
  CHECK(as<actions::Set>(s.events.at(0).actions.at(0)).parameters.limits.lower.size() == 2);
}

TEST_CASE("events depend on conditions, follow others, and repeat") {
  const Scenario s =
      read(arm +
           "[[event]]\nname = \"snap\"\nwhen = { reaction_force = \"m/a\", exceeds = \"40 N\" }\nfor = \"5 ms\"\n"
           "break = \"m/a\"\n"
           "[[event]]\nafter = { event = \"snap\", delay = \"0.5 s\" }\nlock = \"m/j\"\n"
           "[[event]]\nevery = \"1 s\"\nfrom = 2\nimpulse = { body = \"f/x\", force = [1, 0, 0] }\n"
           "[[event]]\nwhen = { distance = [{ body = \"m/b\", point = [0, 0, 1] }, \"f/x\"], below = \"10 cm\" }\n"
           "repeat = true\nhysteresis = \"1 cm\"\nlocate = \"per step\"\nimpulse = { body = \"f/x\", force = [1, 0, 0] }\n");
  REQUIRE(s.events.size() == 4);
  REQUIRE(s.events[0].condition.has_value());
  CHECK(s.events[0].condition->threshold == 40);
  CHECK(s.events[0].condition->duration == 0.005);
  CHECK(s.events[0].condition->above);
  CHECK(s.events[1].after == "snap");
  CHECK(s.events[1].delay == 0.5);
  CHECK(s.events[2].period == 1);
  CHECK(s.events[2].time == 2);
  CHECK(s.events[3].condition->repeats);
  CHECK(s.events[3].condition->hysteresis == 0.01);
  CHECK_FALSE(s.events[3].condition->exact);
  Simulation simulation(s.model, {.step = 1e-2});
  std::vector<const ScenarioEvent*> events;
  for (const ScenarioEvent& event : s.events) events.push_back(&event);
  CHECK(schedule(simulation, std::move(events)).problems.empty());
  CHECK(simulation.dry_run().issues.empty());
  REQUIRE(simulation.run_until(2.5) == Status::ok);
}

TEST_CASE("an event without delay after another may concern the same joint: it is another impact") {
  const Scenario scenario =
      read(arm + "[[event]]\nname = \"hold\"\nat = 0.1\nlock = \"m/j\"\n[[event]]\nafter = \"hold\"\nbreak = \"m/j\"\n");
  CHECK(scenario.events.size() == 2);
}

TEST_CASE("what an event at an unknown instant sets may fit any kind that the joint can have") {
  const std::string change = "[[event]]\nat = 1.5\nbreak = \"m/a\"\n";
  const auto set = [](const std::string& what) {
    return "[[event]]\nwhen = { speed = \"m/a\", exceeds = 0.2 }\nset = { joint = \"m/a\", " + what + " }\n";
  };
  for (const char* what : {"damping = \"1 N m s\"", "damping = 2", "drive = { effort = 2 }", "limits = { lower = -1, upper = 2 }",
                           "stiffness = 3, rest = \"30 deg\"", "damping = [1, 1, 1, 2, 2, 2]"}) {
    CAPTURE(what);
    for (const std::string& events : {set(what) + change, change + set(what)})
      CHECK(read(pinned + events + "[integrate]\nuntil = 2\n").events.size() == 2);
  }
  const auto refusal = [&](const std::string& events) { return said(read_scenario_text(pinned + events, "s.toml")); };
  CHECK(refusal(set("damping = \"1 m\"") + change).find("'1 m' is a length (m), not a rotational damping") != std::string::npos);
  CHECK(refusal(change + set("limits = { lower = 2, upper = -1 }")).find("limits") != std::string::npos);
  // At a known instant the kind is known: a free joint.
  const std::string known = "[[event]]\nat = 1.6\nset = { joint = \"m/a\", damping = \"1 N m s\" }\n";
  CHECK(refusal(change + known).find("not a damping (N s/m)") != std::string::npos);
}
