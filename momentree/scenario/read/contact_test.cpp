// Contact in scenarios: what is read, what is refused, and events in results.
#include <doctest/doctest.h>

#include <momentree/results/columns/contact_columns.hpp>
#include <momentree/results/report/contact_rows.hpp>
#include <momentree/results/session.hpp>
#include <momentree/results/summary.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/events/schedule.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/bad_input.hpp>
#include <tests/error_of.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;

namespace {

std::string ball(const std::string& name, double height, const std::string& more = "collision = { sphere = 0.1 }\n") {
  return "[[mechanism]]\nname = \"" + name + "\"\nroot = \"free\"\npose = { xyz = [0, 0, " + std::to_string(height) +
         "] }\n[[mechanism.body]]\nname = \"ball\"\nmass = 1\ninertia = 0.004\n" + more;
}
Scenario read(const std::string& text) {
  ReadResult result = read_scenario_text("format = 1\n" + text, "s.toml");
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return std::move(*result.scenario);
}
std::string refusal(const std::string& text) { return said(read_scenario_text("format = 1\n" + text, "s.toml")); }

}  // namespace

TEST_CASE("contact: shapes, the floor and rules are read") {
  const Scenario scenario =
      read("[world]\nfloor = { height = \"10 cm\", friction = { static = 0.6, kinetic = 0.4 }, restitution = 0.3 }\n" +
           ball("a", 3, "shape = { box = [1, 2, 3] }\ncollision = \"shape\"\n") +
           ball("b", 9, "collision = [{ sphere = 0.1 }, { capsule = { radius = 0.1, length = 1 } }]\n") +
           ball("c", 20, "collision = \"none\"\n") +
           "[[contact]]\nname = \"hit\"\nbetween = [\"a\", \"b/*\"]\nfriction = 0.2\n[[contact]]\nbetween = [\"b\", "
           "\"floor\"]\noff = true\n");
  const Model& model = scenario.model;
  REQUIRE(model.colliders().size() == 4);
  CHECK(model.colliders()[0].plane);
  CHECK(model.colliders()[0].point.z == doctest::Approx(0.1));
  CHECK(model.colliders()[1].solid.vertices.size() == 8);
  CHECK(model.colliders()[2].solid.radius == 0.1);
  CHECK(model.contact_law({0}, ground).friction == 0.4);
  CHECK(model.contact_law({0}, ground).static_friction == 0.6);
  CHECK(model.contact_law({0}, {1}).friction == 0.2);
  CHECK(model.contact_law({1}, ground).off);
  CHECK(!model.contact_law({2}, {1}).off);
}

TEST_CASE("contact: belts of bodies and of the floor are read, and written again") {
  const Scenario scenario = read("[world]\nfloor = { belt = { axis = [0, 2, 0], speed = \"50 cm/s\" } }\n" +
                                 ball("a", 3,
                                      "shape = { sphere = 0.1 }\ncollision = [{ sphere = 0.1 }, { box = [1, 1, 1] }]\n"
                                      "belt = { axis = [3, 0, 4], speed = -1 }\n") +
                                 ball("b", 9));
  const std::string text = to_toml(scenario.model, scenario.shapes, true);
  for (const Scenario& each : {scenario, read(text.substr(text.find('\n') + 1))}) {
    REQUIRE(each.model.colliders().size() == 4);
    CHECK(norm(each.model.colliders()[0].solid.belt - Vec3{0, 0.5, 0}) < 1e-15);
    for (const std::size_t i : {1u, 2u}) CHECK(norm(each.model.colliders()[i].solid.belt - Vec3{-0.6, 0, -0.8}) < 1e-15);
    CHECK(each.model.colliders()[3].solid.belt == Vec3{});
  }
  const auto refused = [](const std::string& what) { return refusal(ball("a", 1, what + "\n")); };
  CHECK(refused("belt = { axis = [0, 1, 0], speed = 1 }")
            .find("s.toml:10:8: error: belt: the body has no collision; give it one") != std::string::npos);
  CHECK(refused("collision = { sphere = 1 }\nbelt = { axis = [0, 0, 0], speed = 1 }").find("axis: must not be zero") !=
        std::string::npos);
  CHECK(refused("collision = { sphere = 1 }\nbelt = { axis = [0, 1, 0] }").find("speed") != std::string::npos);
  CHECK(refused("conveyor = 1").find("belt = { axis = [0, 1, 0], speed = 0.5 }") != std::string::npos);
}

TEST_CASE("contact: torsional and rolling friction are read, written again, and part of state documents") {
  const Scenario scenario = read("[world]\nfloor = { friction = { kinetic = 0.4, rolling = \"2 mm\", torsional = 0.003 } }\n" +
                                 ball("a", 0.1, "collision = { sphere = 0.1 }\n"));
  for (const Scenario& each : {scenario, read(to_toml(scenario.model, scenario.shapes, true).substr(11))}) {
    const ContactLaw law = each.model.contact_law({0}, ground);
    CHECK(law == ContactLaw{.friction = 0.4, .static_friction = 0.4, .torsional = 0.003, .rolling = 0.002});
  }
  CHECK(refusal("[world]\nfloor = { friction = { kinetic = 1, rolling = -1 } }\n" + ball("a", 1)).find("rolling") !=
        std::string::npos);
}

TEST_CASE("contact: links of a chain touch, neighbours do not") {
  const Scenario scenario = read(
      "[[mechanism]]\nname = \"chain\"\n[mechanism.chain]\nlinks = 3\nlength = 0.1\nmass = 1\ninertia = 1e-3\nradius = 0.01\n");
  CHECK(scenario.model.colliders().size() == 3);
  const World world(scenario.model);
  CHECK(world.gap(BodyId{0}, BodyId{1})->passes);
  CHECK(!world.gap(BodyId{0}, BodyId{2})->passes);
}

TEST_CASE("contact: a chain of many links may touch") {
  const Scenario scenario = read(
      "[[mechanism]]\nname = \"c\"\n[mechanism.chain]\nlinks = 2000\nlength = 0.1\nmass = 1\ninertia = 1e-3\nradius = 0.01\n");
  CHECK(scenario.model.colliders().size() == 2000);
}

TEST_CASE("contact: mistakes are refused with their places") {
  const std::string floor = "[world]\nfloor = true\n";
  CHECK(refusal(floor + ball("a", 0.05)) ==
        "s.toml:9:8: error: 'a/ball' and 'ground' overlap by 0.05 m at the start; move one of them, let them pass through each "
        "other by a [[contact]] with off = true, or push them apart by resolve = true in [integrate]");
  CHECK(refusal(ball("a", 1, "collision = \"shape\"\n")).find("the body has no shape") != std::string::npos);
  CHECK(refusal(ball("a", 1, "collision = \"hull\"\n")).find("expected shapes") != std::string::npos);
  CHECK(refusal("[world]\nfloor = { friction = -1 }\n" + ball("a", 1)).find("can't be negative") != std::string::npos);
  CHECK(refusal("[world]\nfloor = { restitution = 1.5 }\n" + ball("a", 1)).find("at most 1") != std::string::npos);
  CHECK(refusal(ball("a", 1) + "[[contact]]\nbetween = [\"x\", \"a\"]\n").find("no body or mechanism") != std::string::npos);
  CHECK(refusal(ball("a", 1) + "[[contact]]\nbetween = [\"a\"]\n").find("expected two names") != std::string::npos);
  CHECK(refusal(floor + ball("a", 1) + "[integrate]\nmethod = \"damped\"\n").find("does not support contact") !=
        std::string::npos);
}

TEST_CASE("contact: events in results") {
  const Scenario scenario =
      read("[world]\nfloor = { restitution = 0.5 }\n" + ball("a", 1) +
           "[[contact]]\nname = \"hard\"\nbetween = [\"a\", \"floor\"]\nrestitution = 0.5\n[integrate]\nuntil = 0.5\n");
  Simulation sim(scenario.model, scenario.integration);
  REQUIRE(sim.run_until(0.5));
  REQUIRE(!sim.events().empty());
  CHECK(sim.events()[0].name == "impact hard");
  const std::string json = event_json(sim.events()[0]);
  CHECK(json.find("\"bodies\": [\"a/ball\", \"ground\"]") != std::string::npos);
  for (const char* key : {"\"point\": [", "\"normal\": [0, 0, 1]", "\"impulse\": [", "\"joint_impulse\": {"})
    CHECK_MESSAGE(json.find(key) != std::string::npos, json);
}

TEST_CASE("contact: conditions are read, and what touches nothing is refused") {
  const std::string world = "[world]\nfloor = true\n" + ball("a", 1) + ball("b", 2) + ball("c", 3, "");
  const auto event = [&](const std::string& when) { return world + "[[event]]\nwhen = { " + when + " }\nbreak = \"a/ball\"\n"; };
  for (const char* when :
       {"touch = [\"a/ball\", \"floor\"]", "touch = [\"a/ball\", \"b/ball\"]", "gap = [\"ground\", \"a/ball\"], below = 0.1",
        "contact_force = [\"a/ball\", \"ground\"], exceeds = \"3 N\"", "slip = [\"b/ball\", \"a/ball\"], exceeds = 1",
        "contact_impulse = [\"a/ball\", \"floor\"], exceeds = \"1 N s\"", "touch = [\"a\", \"floor\"]",
        "slip = [\"a\", \"b/ball\"]", "gap = [\"ground\", \"b\"], below = 0.1"})
    CHECK(read(event(when)).events.size() == 1);
  CHECK(refusal(event("touch = [\"a/ball\", \"floor\"], exceeds = 1")).find("touch takes no threshold; leave it out") !=
        std::string::npos);
  CHECK(refusal(event("touch = \"a/ball\"")).find("touch: expected a list of two bodies or mechanisms") != std::string::npos);
  CHECK(refusal(event("gap = [\"a/ball\", \"c/ball\"], below = 1"))
            .find("gap: 'c/ball' touches nothing; give the body a collision") != std::string::npos);
  CHECK(refusal(event("gap = [\"a/ball\", \"d\"], below = 1")).find("gap: there is no body or mechanism 'd'") !=
        std::string::npos);
  CHECK(refusal(event("gap = [\"a\", \"floor\"]")).find("when: has no threshold") != std::string::npos);
  CHECK(refusal(event("touch = [\"c\", \"floor\"]")).find("'c' touches nothing; give one of its bodies a collision") !=
        std::string::npos);
  const std::string off = "[[contact]]\nbetween = [\"a\", \"floor\"]\noff = true\n";
  CHECK(refusal(event("touch = [\"a\", \"floor\"]") + off) ==
        "s.toml:31:18: error: touch: 'a' and the ground pass through each other; the last [[contact]] that names them says off = "
        "true");
  CHECK(refusal(ball("a", 1) + "[[event]]\nwhen = { touch = [\"a/ball\", \"ground\"] }\nbreak = \"a/ball\"\n")
            .find("touch: the ground touches nothing; give the world a floor") != std::string::npos);
}

TEST_CASE("contact: a rule for a body whose collision cannot be read is no second error") {
  const std::string said =
      refusal(ball("a", 1, "collision = { mesh = \"none.obj\" }\n") + "[[contact]]\nbetween = [\"a/ball\", \"floor\"]\n");
  CHECK(said.find("'none.obj' cannot be read") != std::string::npos);
  CHECK(said.find("between") == std::string::npos);
}

TEST_CASE("contact: runs with reactions have a table of the points that touch") {
  const Scenario scenario = read("[world]\nfloor = { friction = 0.5 }\n" + ball("a", 0.1) + "[integrate]\nuntil = 0.1\n");
  Simulation simulation(scenario.model, scenario.integration);
  REQUIRE(simulation.run_until(0.05));
  std::string text;
  contact_header(text);
  contact_rows(text, simulation.world());
  CHECK(text.find("time,one,other,point.x,point.y,point.z,normal.x,normal.y,normal.z,force.x,force.y,force.z,slip\n0.05,a/"
                  "ball,ground,0,0,0") == 0);
  const std::vector<ContactPoint> points = simulation.world().contacts();
  REQUIRE(points.size() == 1);
  CHECK(points[0].force.z == doctest::Approx(9.81).epsilon(1e-12));
  test::TemporaryFolder folder;
  write_text_file(folder / "contacts.csv", text + "0.06,a/ball,ground,1,2");  // a line that was being written
  const std::vector<ContactRow> rows = read_contact_rows(folder / "contacts.csv");
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].one == "a/ball");
  CHECK(rows[0].numbers[8] == points[0].force.z);
  write_text_file(folder / "contacts.csv", "time\n1,2\n");
  CHECK(error_of([&] { static_cast<void>(read_contact_rows(folder / "contacts.csv")); }).find("contacts.csv:2") !=
        std::string::npos);
}

TEST_CASE("contact: a file that asks for momenta gets a warning, as worlds with contact are integrated in velocities") {
  const auto said = [](const std::string& variables) {
    return rendered(
        read_scenario_text("format = 1\n[world]\nfloor = true\n" + ball("a", 1) + "[integrate]\n" + variables, "s.toml")
            .diagnostics);
  };
  CHECK(said("variables = \"momenta\"\n")
            .find("warning: variables: worlds with contact or cables are integrated in velocities; leave it out") !=
        std::string::npos);
  CHECK(said("variables = \"velocities\"\n") == "");
}

TEST_CASE("contact: bodies that overlap are pushed apart, with a warning") {
  const std::string floor = "[world]\nfloor = true\n", resolve = "[integrate]\nresolve = true\n";
  ReadResult result = read_scenario_text("format = 1\n" + floor + ball("a", 0.05) + ball("b", 3) + resolve, "s.toml");
  REQUIRE(result.scenario);
  CHECK(rendered(result.diagnostics)
            .find("s.toml:9:8: warning: bodies that overlap are pushed apart at the start, farthest "
                  "'a/ball', by 0.05 m") != std::string::npos);
  Simulation sim(result.scenario->model, result.scenario->integration);
  CHECK(std::fabs(sim.world().motions()[0].pose.position.z - 0.1) < 1e-14);
  CHECK(sim.run_until(0.1));
  CHECK(read_scenario_text("format = 1\n" + floor + ball("a", 1) + resolve, "s.toml").diagnostics.empty());
  const std::string welded =
      "[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\ncollision = { sphere = 0.1 }\n"
      "[mechanism.body.joint]\nkind = \"prismatic\"\naxis = [1, 0, 0]\nat = { xyz = [0, 0, 0.05] }\n"
      "[[contact]]\nbetween = [\"m\", \"floor\"]\n";
  CHECK(
      refusal(floor + welded + resolve) ==
      "s.toml:7:8: error: 'm/b' and 'ground' can't be pushed apart: they still overlap by 0.05 m; move one of them, or let them "
      "pass through each other: [[contact]] with off = true");
}

TEST_CASE("contact: motions that press what can hardly give way end the run before its energy grows without bounds") {
  Session session = load_text(R"(format = 1
[world]
gravity = [0.0, 0.0, -9.81]
floor = { friction = 0.5, restitution = 0.2 }
[[mechanism]]
name = "m0"
root = "free"
pose = { xyz = [0.08, -0.07, 1.025], rpy = [0.911, -0.086, 0.474] }
[[mechanism.body]]
name = "b0"
mass = 1.625
[[mechanism.body]]
name = "b1"
mass = 2.278
inertia = [0.018764, 0.019575000000000002, 0.021432]
[mechanism.body.joint]
kind = "prismatic"
parent = "b0"
[[mechanism]]
name = "m2"
pose = { xyz = [1.596, 0.074, 0.75], rpy = [-0.749, 0.465, 0.535] }
[[mechanism.body]]
name = "b0"
mass = 0.62
[mechanism.body.joint]
kind = "revolute"
[[mechanism.body]]
name = "b1"
mass = 0.911
[mechanism.body.joint]
kind = "helical"
pitch = 0.093
parent = "b0"
at = { xyz = [0.124, 0.025, -0.15] }
child_at = { xyz = [0.233, -0.162, -0.202] }
[[mechanism.body]]
name = "b2"
mass = 1.092
[mechanism.body.joint]
kind = "prismatic"
parent = "b1"
at = { xyz = [0.152, 0.259, 0.107], rpy = [-0.921, -0.667, -0.986] }
drive = { motion = { rate = 0.682 } }
[[mechanism.body]]
name = "b3"
mass = 3.607
collision = { capsule = { radius = 0.06, length = 0.179 } }
[mechanism.body.joint]
kind = "prismatic"
parent = "b2"
at = { xyz = [-0.145, 0.287, 0.086] }
child_at = { xyz = [0.03, 0.051, -0.188] }
drive = { motion = { sine = { amplitude = 0.22, frequency = 1.251 } } }
[[spring]]
name = "sp1"
from = { body = "m2/b3", point = [0.155, -0.02, -0.135] }
to = { body = "m2/b0", point = [-0.153, 0.136, 0.058] }
stiffness = 28.962
[[event]]
at = 0.03
lock = "m2/b1"
[integrate]
method = "stepping"
step = 0.001
until = 0.6
)",
                              "s.toml");
  const RunResult run = session.simulation().run_until(0.6);
  CHECK(run.status == Status::stalled);
  CHECK(run.reason.find("the prescribed motion of 'm2/b2', 'm2/b3' presses bodies against others") != std::string::npos);
  CHECK(run.reason.find("smaller step") == std::string::npos);
  CHECK(session.simulation().energy().largest_kinetic < 100);  // the bodies fall by 1 m
  for (const Event& event : session.simulation().events()) CHECK(std::fabs(event.lost) < 100);
}

TEST_CASE("a run that continues from a document compares what contacts gain with the kinetic energy of the whole run") {
  const std::string scenario = R"(format = 1
[world]
floor = true
[[mechanism]]
name = "box"
root = "free"
pose = { xyz = [0, 0, 0.6] }
[[mechanism.body]]
name = "box"
mass = 2
inertia = 0.0133
collision = { box = [0.2, 0.2, 0.2] }
[integrate]
method = "dop853"
until = 1
)";
  Session whole = load_text(scenario, "s.toml");
  REQUIRE(whole.simulation().run_until(1));
  CHECK(whole.simulation().energy().largest_kinetic == doctest::Approx(2 * 9.81 * 0.5).epsilon(1e-6));
  const std::string text = state_json(whole.simulation().world(), {}, step_memory(whole.simulation()));
  Session again = load_text(scenario, "s.toml");
  const RestoredState state = read_state(text, "state.json", again.scenario().model);
  restore(again.simulation(), {state});
  resume(again.simulation(), {}, state.memory);
  CHECK(again.simulation().energy().largest_kinetic == whole.simulation().energy().largest_kinetic);
  CHECK(state_json(again.simulation().world(), {}, step_memory(again.simulation())) == text);
}
