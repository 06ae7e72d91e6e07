// Scenarios with closed loops: mistakes, conversion, state documents.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/integrate/integrator.hpp>
#include <momentree/results/session.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <tests/bad_input.hpp>

namespace momentree::io {
namespace {

using namespace bad_input;
using Json = nlohmann::json;

std::string bar(const std::string& name, const std::string& length, const std::string& joint) {
  return "[[mechanism.body]]\nname = \"" + name + "\"\nmass = 1\ncom = [" + length +
         ", 0, 0]\ninertia = [1e-4, 0.02, 0.02]\n[mechanism.body.joint]\nkind = \"revolute\"\naxis = [0, 1, 0]\n" + joint + "\n";
}

// A four-bar linkage in the plane of x and z: lines 1 to 37.
const std::string bars = "format = 1\n[[mechanism]]\nname = \"m\"\nroots = 2\n" +
                         bar("crank", "0.15", "angle = -1.2\nspeed = 3") +
                         bar("coupler", "0.35", "parent = \"crank\"\nat = { xyz = [0.3, 0, 0] }\nangle = 0.8807815291820409") +
                         bar("rocker", "0.25", "at = { xyz = [0.8, 0, 0] }\nangle = -1.6241336005080826");
const std::string open_pin =
    "[[loop]]\nname = \"pin\"\nkind = \"revolute\"\nbody = \"m/coupler\"\nto = \"m/rocker\"\naxis = [0, 1, 0]\n";
const std::string pin = open_pin + "at = { xyz = [0.5, 0, 0] }\nchild_at = { xyz = [0.7, 0, 0] }\n";
const std::string linkage = bars + pin;

std::string loop(const std::string& what) { return bars + "[[loop]]\n" + what + "\n"; }

Session session_of(const std::string& text) { return load_text(text, "s.toml"); }

std::string document(const Session& session) {
  const Simulation& sim = session.simulation();
  return state_json(sim.world(), {}, step_memory(sim));
}

// The document of a simulation, read back by a simulation of the same scenario: the same text, and the same future.
void check_document(const std::string& scenario, Simulation& sim, double until) {
  const ReadResult read = read_scenario_text(scenario, "s.toml");
  REQUIRE(read.scenario);
  const bool adaptive = is_adaptive(read.scenario->integration.method);
  const auto memory = [adaptive](const Simulation& of) { return adaptive ? step_memory(of) : StepMemory{}; };
  const std::string text = state_json(sim.world(), {}, memory(sim));
  CAPTURE(text);
  Simulation again(read.scenario->model, read.scenario->integration);
  const RestoredState state = read_state(text, "s.json", first_model(again.world()));
  restore(again, {state});
  resume(again, {}, state.memory);
  CHECK(state_json(again.world(), {}, memory(again)) == text);
  REQUIRE(again.run_until(until) == Status::ok);
  REQUIRE(sim.run_until(until) == Status::ok);
  CHECK(state_json(again.world(), {}, memory(again)) == state_json(sim.world(), {}, memory(sim)));
}

}  // namespace

TEST_CASE("mistakes in loops are reported with their places") {
  const std::string least =
      "add undetermined = \"least_norm\" to take the least of all possible reactions, or let loops block fewer directions, for "
      "example by a ball and a universal joint instead of revolute ones (explain counts the equations)";
  check({
      {loop("kind = \"ball\"\nbody = \"m/rocker\""),
       "s.toml:36:1: error: [[loop]] has no 'name'; a name, by which events and results refer to it"},
      {loop("name = \"pin\"\nkind = \"ball\""), "s.toml:36:1: error: [[loop]] has no 'body'; a body, for example \"arm/hand\""},
      {loop("name = \"pin\"\nkind = \"ball\"\nbody = \"m/roker\""),
       "s.toml:39:8: error: loop 'pin': body: there is no body 'm/roker'; did you mean 'm/rocker'?"},
      {loop("name = \"pin\"\nkind = \"ball\"\nbody = \"rocker\""),
       "s.toml:39:8: error: loop 'pin': body: there is no body 'rocker'; did you mean 'm/rocker'?"},
      {loop("name = \"pin\"\nkind = \"ball\"\nbody = \"ground\"\nto = \"m/rocker\""),
       "s.toml:39:8: error: loop 'pin': body: the ground can't be the child of a joint; write body = 'm/rocker', leave 'to' out, "
       "and exchange 'at' and 'child_at'"},
      {loop("name = \"pin\"\nkind = \"ball\"\nbody = \"ground\""),
       "s.toml:39:8: error: loop 'pin': body: both ends are the ground; name a body here; leave 'to' out for a joint to the "
       "ground"},
      {loop("name = \"pin\"\nkind = \"ball\"\nbody = \"ground\"\nto = \"ground\""),
       "s.toml:39:8: error: loop 'pin': body: both ends are the ground; name a body here; leave 'to' out for a joint to the "
       "ground"},
      {loop("name = \"pin\"\nkind = \"ball\"\nbody = \"m/rocker\"\nto = \"m/rocker\""),
       "s.toml:40:6: error: loop 'pin': to: a loop can't join a body to itself; name another body, or leave 'to' out for the "
       "ground"},
      {loop("name = \"pin\"\nkind = \"free\"\nbody = \"m/rocker\""),
       "s.toml:38:8: error: loop 'pin': a free joint constrains nothing, so it can't close a loop; use any other kind"},
      {loop("name = \"m/crank\"\nkind = \"ball\"\nbody = \"m/rocker\""),
       "s.toml:37:8: error: duplicate joint 'm/crank': the name is already used by another on line 6"},
      {linkage + "limits = { lower = 2, upper = 3 }\n",
       "s.toml:37:8: error: loop 'pin': it starts beyond its limits, at 1.3; give start values that close the loop within them"},
      {linkage + "armature = -1\n", "s.toml:44:12: error: armature: must not be negative"},
      {bars + "drive = { motion = { rate = 1, offset = -1.6241336005080826 } }\n" + pin +
           "drive = { motion = { rate = 2, offset = 1.3 } }\n",
       "s.toml:38:8: error: joint 'pin': its prescribed motion contradicts the one of 'm/rocker': through the loops, these "
       "joints "
       "move together; leave out one of these motions, or drive that joint by 'effort' or 'pd'"},
      {linkage + "angle = 1\n",
       "s.toml:44:1: error: unknown key 'angle' in [[loop]]; the coordinates of a loop joint follow from those of its bodies: "
       "give start "
       "values to the joints of the tree"},
      {linkage + "parent = \"m/rocker\"\n",
       "s.toml:44:1: error: unknown key 'parent' in [[loop]]; write 'to', as in to = \"linkage/rocker\""},
      {bars + open_pin + "at = { xyz = [0.5, 0, 0] }\nchild_at = { xyz = [0.7, 0, 0.01] }\nassemble = false\n",
       "s.toml:37:8: error: loop 'pin': it is open at the start, by 0.0029 of its size; give start values at which it is closed, "
       "or leave "
       "out 'assemble = false'"},
      {bars + open_pin + "at = { xyz = [5, 0, 0] }\n",
       "s.toml:37:8: error: loop 'pin': it can't be closed from these start values: it stays open by 0.4 of its size; check its "
       "bodies, "
       "'at', 'child_at' and axes, or give start values nearer to a closed position"},
      {linkage + "[[event]]\nwhen = { reaction_force = \"pin\", exceeds = 5 }\nbreak = \"pin\"\n",
       "s.toml:44:1: error: when: reaction_force: the closed loops do not determine the reaction of joint 'pin', but its "
       "components fx fz my; " +
           least},
      {linkage + "[[event]]\nname = \"e\"\nwhen = { reaction_force = \"pin\", exceeds = 5 }\nbreak = \"pin\"\n"
                 "[[event]]\nafter = \"e\"\nlock = \"m/crank\"\n",
       "s.toml:44:1: error: when: reaction_force: the closed loops do not determine the reaction of joint 'pin', but its "
       "components fx fz my; " +
           least},
      {linkage + "strength = { force = 5 }\n",
       "s.toml:37:8: error: joint 'pin': strength: the closed loops do not determine its reaction; let loops block fewer "
       "directions, for example by a ball and a universal joint instead of revolute ones (explain counts the equations), "
       "or use "
       "an event whose condition says undetermined = \"least_norm\""},
      {linkage + "[[event]]\nwhen = { reaction_force = \"pin\", exceeds = 5, undetermined = \"all\" }\nbreak = \"pin\"\n",
       "s.toml:45:62: error: undetermined: there is no 'all'; \"least_norm\""},
      {linkage + "[[coupling]]\njoint = \"pin\"\nfollows = \"m/crank\"\nstiffness = 1\n",
       "s.toml:45:9: error: joint: joint 'pin' closes a loop, where it can't be coupled; let another joint of the loop be the "
       "one that "
       "closes it"},
  });
}

TEST_CASE("a start in a singular position is a warning that names the loop") {
  const auto parallelogram = [](const std::string& angle) {
    return "format = 1\n[[mechanism]]\nname = \"m\"\nroots = 2\n" + bar("crank", "0.15", "angle = " + angle) +
           bar("coupler", "0.4", "parent = \"crank\"\nat = { xyz = [0.3, 0, 0] }\nangle = -" + angle) +
           bar("rocker", "0.15", "at = { xyz = [0.8, 0, 0] }\nangle = " + angle) + open_pin +
           "at = { xyz = [0.3, 0, 0] }\nchild_at = { xyz = [0.8, 0, 0] }\n";
  };
  const ReadResult in_line = read_scenario_text(parallelogram("0.0"), "s.toml");
  REQUIRE(in_line.scenario);
  CHECK(said(in_line).find("s.toml:36:8: warning: the start is a singular position of loop 'pin'") != std::string::npos);
  CHECK(said(read_scenario_text(parallelogram("0.3"), "s.toml")).empty());
  CHECK(said(read_scenario_text(linkage, "s.toml")).empty());
}

TEST_CASE("start values that the loops do not allow are a warning with what is given and what is used") {
  std::string far = linkage;
  far.replace(far.find("-1.6241336005080826"), 19, "-2.2");
  CHECK(said(read_scenario_text(far, "s.toml")).find("'m/rocker' starts at -") != std::string::npos);
  CHECK(said(read_scenario_text(far, "s.toml")).find(" rad, not at -2.2 rad; ") != std::string::npos);
  std::string rounded = linkage;
  rounded.replace(rounded.find("-1.6241336005080826"), 19, "-1.62413");
  CHECK(said(read_scenario_text(rounded, "s.toml")).find(" rad, not at -1.62413 rad; ") != std::string::npos);
  // Only the crank's start is given: it is kept.
  std::string free = linkage;
  for (const std::string key : {"angle = 0.8807815291820409\n", "angle = -1.6241336005080826\n"})
    free.erase(free.find(key), key.size());
  const ReadResult read = read_scenario_text(free, "s.toml");
  CHECK(said(read).empty());
  REQUIRE(read.scenario);
  const World world(read.scenario->model);
  CHECK(world.joint({0}).q[0] == -1.2);
  CHECK(world.joint({0}).v[0] == doctest::Approx(3).epsilon(1e-14));
  // Speeds that contradict each other.
  std::string both = free;
  both.insert(both.find("speed = 3"), "damping = 0\n");
  const std::size_t rocker = both.rfind("[mechanism.body.joint]\n") + 23;
  both.insert(rocker, "speed = 7\n");
  const ReadResult contradicting = read_scenario_text(both, "s.toml");
  CHECK(said(contradicting).find("rad/s, not at 3 rad/s") != std::string::npos);
  CHECK(said(contradicting).find("rad/s, not at 7 rad/s") != std::string::npos);
}

TEST_CASE("limits that exclude zero choose where a loop closes, and joints of no loop start at the nearest one") {
  const auto limited = [](const std::string& limits) {  // only the crank has start values
    std::string text = linkage;
    for (const std::string key : {"angle = 0.8807815291820409\n", "angle = -1.6241336005080826\n"})
      text.replace(text.find(key), key.size(), key == "angle = -1.6241336005080826\n" ? limits : "");
    return text;
  };
  const std::string text = limited("limits = { lower = -2, upper = -1 }\n");
  const ReadResult read = read_scenario_text(text, "s.toml");
  CHECK(said(read).empty());
  REQUIRE(read.scenario);
  Simulation sim(read.scenario->model, read.scenario->integration);
  CHECK(sim.world().joint({0}).q[0] == -1.2);
  CHECK(sim.world().joint({2}).q[0] == doctest::Approx(-1.6241336005080826).epsilon(1e-12));
  check_document(text, sim, 0.05);
  const ReadResult again = read_scenario_text(to_toml(*read.scenario, ".").text, "s.toml");
  REQUIRE_MESSAGE(again.scenario, said(again));
  CHECK(World(again.scenario->model).joint({2}).q[0] == World(read.scenario->model).joint({2}).q[0]);
  CHECK(said(read_scenario_text(limited("limits = { lower = -1, upper = -0.5 }\n"), "s.toml"))
            .starts_with("s.toml:26:8: error: joint 'm/rocker': it starts beyond its limits, at -"));

  const auto start = [](const std::string& limits) {
    const ReadResult one = read_scenario_text(pinned + limits, "s.toml");
    REQUIRE_MESSAGE(one.scenario, said(one));
    return World(one.scenario->model).joint({0}).q[0];
  };
  CHECK(start("limits = { lower = 0.5, upper = 1.2 }\n") == 0.5);
  CHECK(start("limits = { lower = -2, upper = -1 }\n") == -1);
  CHECK(start("limits = { lower = -2, upper = 1 }\n") == 0);
  CHECK(start("limits = { lower = 0.5, upper = 1.2, stiffness = 100 }\n") == 0);  // a soft stop pushes
}

TEST_CASE("the first step is judged from where the loops are closed") {  // far from the values given
  std::string text = "format = 1\n[[mechanism]]\nname = \"m\"\n";
  for (int k = 0; k < 100; ++k) {
    const std::string outer = k == 0 ? "" : "parent = \"b" + std::to_string(k - 1) + "\"\nat = { xyz = [0.1, 0, 0] }\n";
    text += bar("b" + std::to_string(k), "0.05", outer + "angle = -0.0628");
  }
  text +=
      "[[loop]]\nname = \"end\"\nkind = \"revolute\"\naxis = [0, 1, 0]\nbody = \"m/b99\"\nat = { xyz = [0.9, 0, 0.2] }\n"
      "child_at = { xyz = [0.1, 0, 0] }\n";
  const ReadResult read = read_scenario_text(text, "s.toml");
  REQUIRE(read.scenario);
  CHECK(said(read).find("step") == std::string::npos);
}

TEST_CASE("a scenario with a loop is assembled, and its loop joint is one of the joints") {
  const Session session = session_of(linkage + "damping = 0.5\n");
  const World& world = session.simulation().world();
  CHECK(session.simulation().world().state().variables() == Variables::velocities);
  REQUIRE(world.loops().size() == 1);
  const JointId number = world.loops()[0];
  CHECK(world.joint_name(number) == "pin");
  CHECK(world.joint(number).parameters->damping.of(0) == 0.5);
  CHECK(world.loop_status().rows == 5);
  CHECK(world.loop_status().rank == 2);
  CHECK(world.loop_status().residual < 1e-12);
  const Json text = Json::parse(document(session));
  const Json& joint = text.at("joints").at("pin");
  CHECK(joint.at("loop") == true);
  CHECK(joint.at("p").empty());
  CHECK(joint.at("q").size() == 1);
  CHECK(joint.at("reaction").at("determined") == false);
  CHECK(text.at("joints").at("m/crank").at("reaction").contains("determined"));
  CHECK(text.at("loops").at("rows") == 5);
}

TEST_CASE("a planar linkage determines the components of reactions in its plane, which conditions may have") {
  std::string ball = linkage;
  ball.replace(ball.rfind("revolute"), 8, "ball");
  if (const std::size_t axis = ball.rfind("axis = "); axis > ball.rfind("ball")) ball.erase(axis, ball.find('\n', axis) - axis);
  const Session redundant = session_of(linkage), fewer = session_of(ball);
  constexpr ReactionParts fx = 1, fy = 2, fz = 4, mx = 8, my = 16, mz = 32;
  const auto open = [](const World& world, const std::string& name) {
    ReactionParts parts = 0;
    for (unsigned part = 0; part < 6; ++part)
      if (!world.loops_determine({world.find_joint(name)}, 1u << part)) parts |= 1u << part;
    return parts;
  };
  const World &one = redundant.simulation().world(), &other = fewer.simulation().world();
  CHECK(open(one, "pin") == (fy | mx | mz));
  CHECK(open(other, "pin") == fy);
  for (const std::string name : {"m/crank", "m/coupler", "m/rocker", "pin"}) {
    CHECK((open(one, name) & (fx | fz | my)) == 0);
    CHECK(!one.loops_determine({one.find_joint(name)}));
    const Wrench a = one.reaction({one.find_joint(name)}), b = other.reaction({other.find_joint(name)});
    CHECK(a.force.x == doctest::Approx(b.force.x).epsilon(1e-9));
    CHECK(a.force.z == doctest::Approx(b.force.z).epsilon(1e-9));
    CHECK(std::fabs(a.torque.y - b.torque.y) < 1e-9);
    const std::string when = linkage + "[[event]]\nwhen = { reaction = { joint = \"" + name + "\", component = \"f";
    CHECK(read_scenario_text(when + "x\" }, exceeds = 5 }\nbreak = \"pin\"\n", "s.toml").scenario);
    const ReadResult refused = read_scenario_text(when + "y\" }, exceeds = 5 }\nbreak = \"pin\"\n", "s.toml");
    CHECK(said(refused).find("but its components fx fz my") != std::string::npos);
  }
}

TEST_CASE("conversion keeps loops, and refuses them for URDF") {
  const std::string text =
      linkage +
      "damping = 0.5\nfriction = { coulomb = 1, speed = 0.1 }\nstrength = { force = 1e9 }\nassemble = true\n"
      "[[loop]]\nname = \"rope\"\nkind = \"universal\"\naxis2 = [0, 1, 0]\nbody = \"m/rocker\"\nat = { xyz = [0.8, 0, 0] }\n";
  // The strength of a joint that loops leave open would be an error.
  const ReadResult read =
      read_scenario_text(text.substr(0, text.find("strength")) + text.substr(text.find("assemble")), "s.toml");
  INFO(said(read));
  REQUIRE(read.scenario);
  const std::string written = to_toml(*read.scenario, "").text, of_model = to_toml(read.scenario->model, read.scenario->shapes);
  for (const std::string& each : {written, of_model}) {
    CAPTURE(each);
    const ReadResult again = read_scenario_text(each, "again.toml");
    REQUIRE(again.scenario);
    CHECK(to_toml(again.scenario->model, again.scenario->shapes) == of_model);
    const std::vector<LoopSpec>&one = read.scenario->model.loops(), &two = again.scenario->model.loops();
    REQUIRE(two.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
      CHECK(one[i].name == two[i].name);
      CHECK(one[i].body == two[i].body);
      CHECK(one[i].to == two[i].to);
      CHECK(one[i].joint.kind == two[i].joint.kind);
      CHECK(one[i].joint.parameters == two[i].joint.parameters);
      CHECK(one[i].at.position.x == two[i].at.position.x);
    }
  }
  std::string why;
  try {
    static_cast<void>(to_urdf(*read.scenario, "m", ""));
  } catch (const Error& error) {
    why = error.what();
  }
  CHECK(why.find("URDF has no closed loops: 'pin'") != std::string::npos);
}

TEST_CASE("documents of worlds with loops read back to the same text and continue to the same bits") {
  struct Change {
    const char* what;
    std::vector<Action> actions;
  };
  JointSpec ball, slide;
  ball.kind = Kind::ball, ball.parameters.damping = 0.1, ball.parameters.stiffness = 2;
  slide.kind = Kind::cylindrical, slide.axis = {0, 1, 0};
  const std::vector<Change> changes{
      {"nothing", {}},
      {"a loop joint breaks", {break_joint("pin")}},
      {"a loop joint takes the place of a joint", {break_joint("m/coupler")}},
      {"a loop joint takes the place of a root joint", {break_joint("m/crank")}},
      {"a loop is made", {attach("m/rocker", "m/crank", ball)}},
      {"a loop is made on the ground", {weld("m/coupler")}},
      {"a loop joint is locked", {lock("pin")}},
      {"a loop joint becomes another", {change_joint("pin", slide)}},
      {"a loop joint becomes free", {free_joint("pin")}},
      {"new parameters", {set_parameters("pin", {.damping = 3, .armature = 0.2})}},
      {"a prescribed motion begins", {set_parameters("pin", {.drive = motion_drive(Signal::ramp_from_here(0.8))})}},
  };
  for (const char* method : {"rk4", "midpoint", "dopri5", "dop853"}) {
    CAPTURE(method);
    const std::string scenario = linkage + "damping = 0.1\n[integrate]\nmethod = \"" + method + "\"\n";
    for (const Change& change : changes) {
      CAPTURE(change.what);
      Session session = session_of(scenario);
      Simulation& sim = session.simulation();
      REQUIRE(sim.run_until(0.1) == Status::ok);
      if (!change.actions.empty()) sim.apply(change.actions, "clasp");
      check_document(scenario, sim, 0.2);
      sim.apply(break_joint("m/rocker"), "cut");
      check_document(scenario, sim, 0.3);
    }
  }
}

TEST_CASE("documents of loop joints that rest on a stop, or follow a motion from the start, continue to the same bits") {
  const std::string stopped = linkage + "limits = { lower = 1.2, upper = 1.4, restitution = 0 }\n";
  Session session = session_of(stopped);
  Simulation& sim = session.simulation();
  REQUIRE(sim.run_until(0.2) == Status::ok);
  const JointView pin = sim.world().joint(sim.world().loops()[0]);
  CHECK(pin.resting == 1);
  CHECK(pin.locked == 0);
  CHECK(document(session).find("\"resting\": [") != std::string::npos);
  check_document(stopped, sim, 0.4);
  sim.apply(break_joint("m/coupler"), "cut");  // the stop stays with the joint
  check_document(stopped, sim, 0.6);

  const std::string moved = linkage + "armature = 0.1\ndrive = { motion = { rate = -0.5, offset = 1.3 } }\n";
  Session other = session_of(moved);
  REQUIRE(other.simulation().run_until(0.1) == Status::ok);
  const World& world = other.simulation().world();
  CHECK(world.joint(world.loops()[0]).driven);
  CHECK(world.joint(world.loops()[0]).q[0] == doctest::Approx(1.25).epsilon(1e-12));
  CHECK(world.loop_status().rank == 3);
  check_document(moved, other.simulation(), 0.3);
}

TEST_CASE("stepping keeps the motion of a loop joint's armature, although the file locks the joint later") {
  // A motor of 0.1 N m turns a wheel against a hub with inertia 0.01 and armature 0.06 kg m².
  Session session = session_of(
      "format = 1\n[world]\nfloor = { friction = 0 }\n[[mechanism]]\nname = \"m\"\nroot = \"free\"\npose = { xyz = [0, 0, 0.05] "
      "}\n"
      "[[mechanism.body]]\nname = \"hub\"\nmass = 1\ninertia = 0.01\ncollision = { sphere = 0.05 }\n"
      "[[mechanism.body]]\nname = \"wheel\"\nmass = 1\ninertia = 0.01\n"
      "joint = { kind = \"revolute\", parent = \"hub\", drive = { effort = 0.1 } }\n"
      "[[loop]]\nname = \"bearing\"\nkind = \"cylindrical\"\nbody = \"m/hub\"\narmature = 0.06\n"
      "[[event]]\nat = 0.9\nlock = \"bearing\"\n[integrate]\nmethod = \"stepping\"\n");
  Simulation& sim = session.simulation();
  REQUIRE(sim.run_until(0.5) == Status::ok);
  CHECK(sim.world().motions()[0].angular.z == doctest::Approx(-0.1 * 0.5 / 0.07).epsilon(1e-9));
  CHECK(std::fabs(sim.energy().error) < 1e-9);
}

TEST_CASE("the balance of a loop joint's soft stop closes however fast the joint leaves it") {
  // The stop throws a wheel: at some 150 rad/s a step goes from far inside the stop to far outside.
  Session session = session_of(
      "format = 1\n[world]\ngravity = [0, 0, 0]\n[[mechanism]]\nname = \"m\"\nroot = \"free\"\n"
      "pose = { rpy = [0, 0, 2.5] }\n[[mechanism.body]]\nname = \"wheel\"\nmass = 1\ninertia = 0.004\n"
      "[[loop]]\nname = \"bearing\"\nkind = \"revolute\"\naxis = [0, 0, 1]\nbody = \"m/wheel\"\n"
      "limits = { upper = 1.1, stiffness = 50, damping = 0.01 }\n"
      "[integrate]\nmethod = \"dop853\"\nrtol = 1e-10\natol = 1e-12\n");
  Simulation& sim = session.simulation();
  REQUIRE(sim.run_until(0.05) == Status::ok);
  CHECK(sim.energy().dissipated > 1);
  CHECK(std::fabs(sim.energy().error) < 1e-8);
}

TEST_CASE("a loop joint's points move together while a foot of the loop slides over the floor") {
  Session session = session_of(
      "format = 1\n[world]\nfloor = { friction = 0.3, normal = [0, 0.3, 1] }\n[[mechanism]]\nname = \"m\"\n"
      "pose = { xyz = [0, 0, 0.35] }\nroot = \"free\"\n[[mechanism.body]]\nname = \"arm\"\nmass = 5\n"
      "inertia = [0.014, 0.018, 0.016]\n[[mechanism.body]]\nname = \"foot\"\nmass = 1\ninertia = 0.002\n"
      "collision = { sphere = 0.1 }\njoint = { kind = \"revolute\", parent = \"arm\", at = { xyz = [0.3, 0, -0.2] }, v = 2 }\n"
      "[[loop]]\nname = \"pin\"\nkind = \"ball\"\nbody = \"m/arm\"\nat = { xyz = [-0.3, 0, 0.45] }\n"
      "child_at = { xyz = [-0.3, 0, 0.1] }\n[integrate]\nmethod = \"dopri5\"\nrtol = 1e-6\n");
  Simulation& sim = session.simulation();
  int slides = 0;
  for (int k = 1; k <= 40; ++k) {
    REQUIRE(sim.run_until(0.02 * k) == Status::ok);
    for (const ContactPoint& point : sim.world().contacts()) slides += norm(point.slip) > 0.01 ? 1 : 0;
    const JointView joint = sim.world().joint(sim.world().loops().at(0));
    CHECK(norm(velocity_of(sim.world().motions()[0], joint.child_at.position)) < 1e-13);
  }
  CHECK(slides > 5);
}

TEST_CASE("what is pushed apart at the start stays within its hard stops, also where loops are closed afterwards") {
  const Session session = session_of(
      "format = 1\n[world]\ngravity = [0, 0, 0]\nfloor = { friction = 0.1 }\n[integrate]\nresolve = true\n"
      "[[mechanism]]\nname = \"m1\"\npose = { xyz = [-0.6, 0, 0.4] }\nroot = \"free\"\n[[mechanism.body]]\n"
      "name = \"b1\"\nmass = 0.3\ninertia = 0.001\n[[mechanism.body]]\nname = \"b2\"\nmass = 0.1\n"
      "com = [0.05, 0.07, 0.11]\ninertia = 0.006\n"
      "joint = { kind = \"ball\", parent = \"b1\", at = { xyz = [-0.12, -0.29, -0.5] }, q = [0.8, 0.6, 0, 0] }\n"
      "[[mechanism.body]]\nname = \"b3\"\nmass = 0.3\ninertia = 0.03\ncollision = { sphere = 0.13 }\n"
      "joint = { kind = \"revolute\", axis = [0, 0, 1], parent = \"b2\", at = { xyz = [0.33, -0.17, -0.35] }, child_at = { xyz = "
      "[-0.3, 0.23, 0.25] }, limits = { lower = -0.776, upper = 0.895 } }\n"
      "[[mechanism]]\nname = \"m2\"\npose = { xyz = [0.793, -0.801, 0.024] }\nroot = \"free\"\n[[mechanism.body]]\n"
      "name = \"b1\"\nmass = 0.3\ncom = [-0.1, 0.24, 0.25]\ninertia = 0.0135\n[[loop]]\nname = \"loop 1\"\n"
      "body = \"m1/b3\"\nto = \"m2/b1\"\nkind = \"planar\"\nat = { xyz = [0.105, -0.261, 0.0587] }\n");
  const double q = session.simulation().world().joint({2}).q[0];  // of b3
  CHECK(q < -0.7);
  CHECK(q >= -0.776 - 1e-12);
}

TEST_CASE("a loop that leaves no mobility stands still beside hard stops") {
  const std::string place = "at = { xyz = [-0.3, 0.1, 0], rpy = [1.1, -1.4, 3] }, child_at = { xyz = [0.1, 0, 0.1] }";
  Session session = session_of(
      "format = 1\n[world]\ngravity = [0, 0, 0]\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 4\n"
      "joint = { kind = \"planar\", limits = { upper = [0.09, 0.2, inf] } }\n"
      "[[mechanism.body]]\nname = \"b\"\nmass = 2\ninertia = 0.01\njoint = { kind = \"revolute\", parent = \"a\", " +
      place + ", v = [2.8] }\n[[loop]]\nname = \"L\"\nkind = \"weld\"\nbody = \"m/b\"\n" +
      "at = { xyz = [-0.3, 0.1, 0], rpy = [1.1, -1.4, 3] }\nchild_at = { xyz = [0.1, 0, 0.1] }\n");
  Simulation& sim = session.simulation();
  REQUIRE(sim.run_until(0.2) == Status::ok);
  for (const BodyMotion& motion : sim.world().motions())
    CHECK(dot(motion.linear, motion.linear) + dot(motion.angular, motion.angular) < 1e-18);
}

TEST_CASE("bad loop joints in documents are refused") {
  const Session session = session_of(linkage);
  const std::string text = document(session);
  const auto says = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t loop = changed.find("\"pin\": {"), at = changed.find(from, loop);
    REQUIRE(at != std::string::npos);
    changed.replace(at, from.size(), to);
    try {
      static_cast<void>(read_state(changed, "s.json", first_model(session.simulation().world())));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(says("\"m/coupler\"", "\"m/rocker\"").find("a loop can't join a body to itself") != std::string::npos);
  CHECK(says("\"m/coupler\"", "\"m/couple\"").find("m/couple") != std::string::npos);
  CHECK(says("\"parameters\": {}", "\"parameters\": {\"armature\": -1}").find("armature") != std::string::npos);
}

}  // namespace momentree::io
