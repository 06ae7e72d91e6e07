// [mechanism.joint.NAME]: values that a scenario gives to joints of a model or a chain.
#include <doctest/doctest.h>

#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/bad_input.hpp>

namespace momentree::io {
namespace {

using bad_input::said;
using test::TemporaryFolder;

// A base, a revolute joint, a prismatic joint and a plate fixed to its body: the kinds of joint that robots have.
const char* const urdf = R"(<robot name="arm">
<link name="base"/>
<link name="upper"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="lower"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="plate"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
  <dynamics damping="0.5"/><limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
<joint name="slide" type="prismatic"><parent link="upper"/><child link="lower"/><axis xyz="1 0 0"/>
  <limit lower="-0.1" upper="0.2" effort="1" velocity="1"/></joint>
<joint name="flange" type="fixed"><parent link="lower"/><child link="plate"/></joint>
</robot>
)";

class Arm {
 public:
  Arm() { write_text_file(folder_ / "arm.urdf", urdf); }
  ReadResult read(const std::string& more, const std::vector<std::string>& overrides = {}) const {
    write_text_file(folder_ / "s.toml", "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"arm.urdf\"\n" + more);
    return read_scenario(folder_ / "s.toml", overrides);
  }
  std::string says(const std::string& more) const {
    std::string text;
    for (const Diagnostic& each : read(more).diagnostics) {
      std::string message = each.message();
      const std::size_t at = message.find("s.toml");
      text += (text.empty() ? "" : "\n") + (at == std::string::npos ? message : message.substr(at));
    }
    return text;
  }

 private:
  TemporaryFolder folder_;
};

const BodySpec& joint(const ReadResult& result, const char* name) {
  REQUIRE_MESSAGE(result.scenario, said(result));
  return result.scenario->model[result.scenario->model.joint(name)];
}

}  // namespace

TEST_CASE("a mechanism gives joints of its model parameters, drives, limits, strengths and starts") {
  const Arm arm;
  const ReadResult result = arm.read(R"(limits = true
[mechanism.joint.shoulder]
damping = "0.2 N m s"
drive = { pd = { kp = "100 N m/rad", kd = 10, target = "30 deg" } }
strength = { torque = "40 N m" }
angle = "10 deg"
[mechanism.joint.slide]
limits = { lower = "-5 cm", upper = "5 cm", restitution = 0.5 }
stiffness = "200 N/m"
rest = "1 cm"
friction = { coulomb = 1, speed = 0.01 }
armature = 0.1
speed = "2 cm/s"
[mechanism.joint.flange]
strength = { force = "3 kN" }
)");
  CHECK(said(result) == "");
  const JointParameters& shoulder = joint(result, "m/shoulder").joint.parameters;
  CHECK(shoulder.damping == Values(0.2));
  REQUIRE(shoulder.drive);
  CHECK(shoulder.drive->pd.kp == Values(100));
  CHECK(shoulder.strength.torque == 40);
  CHECK(shoulder.limits.upper == Values(2));  // those of the model: no others are given
  CHECK(joint(result, "m/shoulder").q[0] == doctest::Approx(0.17453292519943295));
  const BodySpec& slide = joint(result, "m/slide");
  CHECK(slide.joint.parameters.limits.upper == Values(0.05));
  CHECK(slide.joint.parameters.limits.restitution == Values(0.5));
  CHECK(slide.joint.parameters.stiffness == Values(200));
  CHECK(slide.joint.parameters.rest == Values(0.01));
  CHECK(slide.joint.parameters.friction.coulomb == Values(1));
  CHECK(slide.joint.parameters.armature == Values(0.1));
  CHECK(slide.v == Values(0.02));
  CHECK(joint(result, "m/flange").joint.parameters.strength.force == 3000);
}

TEST_CASE("a joint whose motion is prescribed does not use the model's limits") {
  const Arm arm;
  const ReadResult result =
      arm.read("limits = true\n[mechanism.joint.shoulder]\ndrive = { motion = { table = [[0, 0.5], [1, 3]] } }\n");
  CHECK(said(result).ends_with(
      "s.toml:5:10: note: limits: joint 'shoulder' does not use those of the model: its motion is prescribed"));
  CHECK(joint(result, "m/shoulder").q == Values(0.5));
  CHECK_FALSE(joint(result, "m/shoulder").joint.parameters.limits.any());
  CHECK(joint(result, "m/slide").joint.parameters.limits.any());
}

TEST_CASE("limits given to a joint apply where those of the model do not") {
  const Arm arm;
  const std::string given = "[mechanism.joint.shoulder]\nlimits = { lower = 0 }\n";
  CHECK(arm.says(given) == "s.toml:4:9: warning: the limits of 1 joint are not used; write limits = true or limits = false");
  const ReadResult result = arm.read("limits = false\n" + given);
  CHECK(said(result) == "");
  CHECK(joint(result, "m/shoulder").joint.parameters.limits.lower == Values(0));
  CHECK_FALSE(joint(result, "m/slide").joint.parameters.limits.any());
}

TEST_CASE("a wildcard is for all joints that match and can have it; exact names win, else the later one") {
  const Arm arm;
  SUBCASE("welds go without") {
    const ReadResult result = arm.read("limits = false\n[mechanism.joint.\"*\"]\ndamping = 3\ndrive = { pd = { kp = 5 } }\n");
    CHECK(said(result) == "");
    for (const char* name : {"m/shoulder", "m/slide"}) {
      CHECK(joint(result, name).joint.parameters.damping == Values(3));
      REQUIRE(joint(result, name).joint.parameters.drive);
    }
    CHECK_FALSE(joint(result, "m/flange").joint.parameters.any());
  }
  SUBCASE("a unit is of some kinds of joint alone, which a note says") {
    const ReadResult result = arm.read("limits = false\n[mechanism.joint.\"s*\"]\ndamping = \"3 N m s\"\n");
    CHECK(
        said(result).find(
            "s.toml:7:11: note: damping: joints that match 's*' and are of kind 'prismatic' cannot have it, and do not get it") !=
        std::string::npos);
    CHECK(joint(result, "m/shoulder").joint.parameters.damping == Values(3));
    CHECK(joint(result, "m/slide").joint.parameters.damping.empty());
  }
  SUBCASE("which wins") {
    const ReadResult result = arm.read(
        "limits = false\n[mechanism.joint.slide]\ndamping = 1\n[mechanism.joint.\"*\"]\ndamping = 2\narmature = 2\n"
        "[mechanism.joint.\"s*\"]\narmature = 3\n");
    CHECK(said(result) == "");
    CHECK(joint(result, "m/slide").joint.parameters.damping == Values(1));
    CHECK(joint(result, "m/shoulder").joint.parameters.damping == Values(2));
    CHECK(joint(result, "m/slide").joint.parameters.armature == Values(3));
  }
  SUBCASE("nothing matches, or nothing can have it") {
    CHECK(
        arm.says("limits = false\n[mechanism.joint.\"q*\"]\ndamping = 1\n") ==
        "s.toml:6:18: error: joint: no joint of this model matches 'q*'; * matches within a name, written without its mechanism");
    CHECK(arm.says("limits = false\n[mechanism.joint.\"f*\"]\ndamping = 1\n") ==
          "s.toml:7:11: error: damping: all joints that match 'f*' are welds, which do not move");
    CHECK(
        arm.says("limits = false\n[mechanism.joint.\"*\"]\ndamping = \"1 kg\"\n") ==
        "s.toml:7:11: error: damping: '1 kg' is a mass (kg), not a rotational damping (N m s/rad); for example 0.1, or \"0.1 N m "
        "s\"");
    CHECK(arm.says("limits = false\n[mechanism.joint.\"*\"]\ndamping = -1\n") ==
          "s.toml:7:11: error: joint 'shoulder': damping: must not be negative");
  }
}

TEST_CASE("errors in a joint table are reported at its place") {
  const Arm arm;
  const auto of = [&arm](const std::string& table) { return arm.says("limits = false\n" + table); };
  CHECK(of("[mechanism.joint.shouldr]\ndamping = 1\n") ==
        "s.toml:6:18: error: joint: there is no joint 'shouldr' in this model; did you mean 'shoulder'?");
  CHECK(of("[mechanism.joint.upper]\ndamping = 1\n") ==
        "s.toml:6:18: error: joint: there is no joint 'upper' in this model; the joint of that body is 'shoulder'");
  CHECK(of("[mechanism.joint.\"m/slide\"]\ndamping = 1\n") ==
        "s.toml:6:18: error: joint: there is no joint 'm/slide' in this model; leave out the mechanism's name here: 'slide'");
  CHECK(of("[mechanism.joint.shoulder]\naxis = [0, 0, 1]\n") ==
        "s.toml:7:1: error: unknown key 'axis' in [mechanism.joint.shoulder]; the model file defines it; an event may `change` "
        "the joint");
  CHECK(of("[mechanism.joint.shoulder]\ndamper = 1\n") ==
        "s.toml:7:1: error: unknown key 'damper' in [mechanism.joint.shoulder]; write 'damping', as in damping = \"0.1 N m s\"");
  CHECK(of("[mechanism.joint.shoulder]\n") ==
        "s.toml:6:18: warning: [mechanism.joint.shoulder] is empty; give the joint a parameter, such as damping = 0.1");
  CHECK(of("[mechanism.joint.flange]\ndamping = 1\n") ==
        "s.toml:7:11: error: damping: a weld joint does not move; leave it out; a weld has at most a strength");
  CHECK(of("[mechanism.joint.shoulder]\nposition = 3\nlimits = { upper = 1 }\n") ==
        "s.toml:7:12: error: joint 'shoulder': q: starts beyond its limits");
  CHECK(of("[mechanism.joint]\nshoulder = 3\n") ==
        "s.toml:7:1: error: joint: expected a table under 'shoulder', found a number; these are names of joints: write "
        "[mechanism.joint.elbow] with 'damping = 0.1'");
  CHECK(of("[[mechanism.joint]]\nname = \"shoulder\"\n") ==
        "s.toml:6:1: error: joint: expected tables by the names of joints, found a list; write [mechanism.joint.elbow], or "
        "[mechanism.joint.\"*\"] for all");
  CHECK(
      of("state = { joints = { shoulder = 0.1 } }\n[mechanism.joint.shoulder]\nangle = 0.2\n") ==
      "s.toml:6:33: error: state: joint 'shoulder' has its start in [mechanism.joint.shoulder], on line 8; give it in one of the "
      "two");
  CHECK(of("[mechanism.joint.shoulder]\nangle = 1\ndrive = { motion = 0.5 }\n") ==
        "s.toml:7:9: error: the joint's motion starts at the position 0.5, not 1; leave the start position out: the motion gives "
        "it");
  const ReadResult bodies = read_scenario_text(bad_input::pinned + "[mechanism.joint.a]\ndamping = 1\n", "s.toml");
  CHECK(said(bodies) ==
        "s.toml:10:1: error: joint: a mechanism of bodies has its joints in the tables of the bodies; write it in "
        "[mechanism.body.joint], which --set reaches by mechanism.m.body.BODY.joint.damping=0.1");
}

TEST_CASE("the mechanism's state wins over a wildcard, and --set reaches a joint") {
  const Arm arm;
  const ReadResult result = arm.read("limits = false\nstate = { joints = { slide = 0.1 } }\n[mechanism.joint.\"*\"]\nq = [0.3]\n",
                                     {"mechanism.m.joint.shoulder.damping=7", "mechanism.m.joint.*.armature=2"});
  CHECK(said(result) == "");
  CHECK(joint(result, "m/slide").q == Values(0.1));
  CHECK(joint(result, "m/shoulder").q == Values(0.3));
  CHECK(joint(result, "m/shoulder").joint.parameters.damping == Values(7));
  CHECK(joint(result, "m/slide").joint.parameters.armature == Values(2));
  const ReadResult wrong = arm.read("limits = false\n", {"mechanism.m.joint.sholder.damping=7"});
  CHECK(said(wrong) ==
        "--set mechanism.m.joint.sholder.damping=7: error: joint: there is no joint 'sholder' in this model; did you "
        "mean 'shoulder'?");
}

TEST_CASE("joint tables apply to the links of a chain") {
  const ReadResult result =
      read_scenario_text(bad_input::chain +
                             "damping = 1\ninertia = 1\n[mechanism.joint.2]\ndamping = 5\nangle = \"20 deg\"\n"
                             "[mechanism.joint.\"*\"]\nstrength = { force = 100 }\n",
                         "s.toml");
  CHECK(said(result) == "");
  CHECK(joint(result, "m/1").joint.parameters.damping == Values(1));
  CHECK(joint(result, "m/2").joint.parameters.damping == Values(5));
  CHECK(joint(result, "m/2").q[0] == doctest::Approx(0.3490658503988659));
  for (const char* name : {"m/1", "m/2", "m/3"}) CHECK(joint(result, name).joint.parameters.strength.force == 100);
  const ReadResult wrong = read_scenario_text(bad_input::chain + "inertia = 1\n[mechanism.joint.4]\ndamping = 5\n", "s.toml");
  CHECK(said(wrong) == "s.toml:9:18: error: joint: there is no joint '4' in this chain; the joints are 1 to 3");
}

TEST_CASE("a scenario with joint tables is converted to one with the same motion") {
  const Arm arm;
  const std::string tables =
      "limits = false\n[mechanism.joint.\"*\"]\ndamping = 3\nq = [0.1]\n[mechanism.joint.shoulder]\n"
      "drive = { pd = { kp = 5, target = { sine = { amplitude = 1, frequency = 2 } } } }\n";
  const ReadResult of_model = arm.read(tables);
  REQUIRE(of_model.scenario);
  const ReadResult again = read_scenario_text(to_toml(*of_model.scenario, "").text, "again.toml");
  CHECK(said(again) == "");
  for (const char* name : {"m/shoulder", "m/slide", "m/flange"}) {
    CHECK(joint(again, name).joint.parameters == joint(of_model, name).joint.parameters);
    CHECK(joint(again, name).q == joint(of_model, name).q);
  }
  const ReadResult of_chain = read_scenario_text(
      bad_input::chain + "inertia = 1\n[mechanism.joint.2]\ndamping = 5\n[mechanism.joint.\"*\"]\nstrength = { force = 100 }\n",
      "s.toml");
  REQUIRE(of_chain.scenario);
  const std::string text = to_toml(*of_chain.scenario, "").text;
  CAPTURE(text);
  const ReadResult chain_again = read_scenario_text(text, "again.toml");
  CHECK(said(chain_again) == "");
  for (const char* name : {"m/1", "m/2", "m/3"})
    CHECK(joint(chain_again, name).joint.parameters == joint(of_chain, name).joint.parameters);
}

TEST_CASE("angles of more than a turn are written with their unit, and read back without a warning") {
  const ReadResult first = read_scenario_text(
      bad_input::pinned +
          "angle = \"9 rad\"\nlimits = { lower = \"-7 rad\", upper = \"10 rad\" }\nstiffness = 1\nrest = \"8.5 rad\"\n",
      "s.toml");
  REQUIRE(first.scenario);
  const std::string text = to_toml(first.scenario->model);
  CAPTURE(text);
  const ReadResult again = read_scenario_text(text, "again.toml");
  CHECK(said(again) == "");
  CHECK(joint(again, "m/a").q == Values(9));
  CHECK(joint(again, "m/a").joint.parameters == joint(first, "m/a").joint.parameters);
}

TEST_CASE("set under a wildcard skips welds and other joints that cannot have the parameter") {
  const Arm arm;
  const ReadResult result = arm.read(
      "limits = false\n[[event]]\nname = \"on\"\nat = 0\nset = { joint = \"m/*\", drive = { pd = { kp = 5, kd = 1 } } }\n");
  CHECK(said(result) == "");
  REQUIRE(result.scenario);
  CHECK(result.scenario->events.size() == 2);
  const ReadResult late = arm.read(
      "limits = false\n[[event]]\nwhen = { speed = \"m/*\", exceeds = 5 }\nset = { joint = \"m/*\", damping = 2 "
      "}\n[[event]]\nevery = 1\n"
      "set = { joint = \"m/*\", damping = 2 }\n");
  CHECK(said(late) == "");
  REQUIRE(late.scenario);
  CHECK(late.scenario->events.size() == 3);  // the condition is evaluated on two joints
  CHECK(late.scenario->events.back().actions.size() == 2);
  const ReadResult turned =
      arm.read("limits = false\n[[event]]\nwhen = { position = \"m/*\", exceeds = \"10 deg\" }\nbreak = \"m/*\"\n");
  CHECK(said(turned) == "");
  REQUIRE(turned.scenario);
  CHECK(turned.scenario->events.size() == 1);  // the prismatic joint has no angle
  CHECK(arm.says("limits = false\n[[event]]\nwhen = { position = \"m/*\", exceeds = \"10 kg\" }\nbreak = \"m/*\"\n") ==
        "s.toml:7:38: error: exceeds: '10 kg' is a mass (kg), not an angle (rad); for example 0.5236, or \"30 deg\"");
  CHECK(arm.says("limits = false\n[[event]]\nat = 0\nset = { joint = \"m/f*\", damping = 1 }\n") ==
        "s.toml:8:35: error: damping: all joints that match 'm/f*' are welds, which do not move");
  CHECK(arm.says("limits = false\n[[event]]\nat = 0\nset = { joint = \"m/flange\", damping = 1 }\n") ==
        "s.toml:8:39: error: damping: a weld joint does not move; leave it out; a weld has at most a strength");
  CHECK(arm.says("limits = false\n[[event]]\nat = 0\nset = { joint = \"m/*\", dampng = 1 }\n").find("did you mean 'damping'?") !=
        std::string::npos);
  CHECK(arm.says("limits = false\n[[event]]\nwhen = { speed = \"m/f*\", exceeds = 1 }\nbreak = \"m/slide\"\n") ==
        "s.toml:7:18: error: when: no joint that matches 'm/f*' has one degree of freedom; position and speed need a joint with "
        "one degree of freedom");
}

}  // namespace momentree::io
