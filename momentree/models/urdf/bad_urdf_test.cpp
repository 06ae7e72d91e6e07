// Broken and hostile URDF: each error is reported with its place and a hint.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <tests/models.hpp>

using namespace momentree::io;
using namespace momentree::io::models;

namespace {

const std::string head = "<robot name='r'>\n";
const std::string mass = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";

std::string a_link(const std::string& name) { return "<link name='" + name + "'>" + mass + "</link>\n"; }
std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& more = "<axis xyz='0 0 1'/>", const std::string& type = "continuous") {
  return "<joint name='" + name + "' type='" + type + "'>\n<parent link='" + parent + "'/>\n<child link='" + child + "'/>\n" +
         more + "\n</joint>\n";
}
/// A link with this inertial on its third line.
std::string inertial(const std::string& text) {
  return head + "<link name='a'>\n<inertial>" + text + "</inertial></link></robot>";
}
/// Two links and their joint, whose content `more` is on its fourth line, the eighth of the file.
std::string joined(const std::string& more, const std::string& type = "revolute") {
  return head + a_link("a") + a_link("b") + joint("j", "a", "b", more, type) + "</robot>";
}

struct Case {
  std::string text, said;
};
void check(const std::vector<Case>& cases) {
  for (const Case& each : cases) {
    CAPTURE(each.text.substr(0, 500));
    CHECK(errors_of(each.text) == each.said);
  }
}

}  // namespace

TEST_CASE("URDF: invalid numbers are refused") {
  const std::string inertia = "<inertia ixx='1' iyy='1' izz='1'/>";
  const auto of_mass = [&](const std::string& value) { return inertial("<mass value='" + value + "'/>" + inertia); };
  check({
      {of_mass("nan"), "r.urdf:3:24: error: value: 'nan' is not a finite number"},
      {of_mass("-inf"), "r.urdf:3:24: error: value: '-inf' is not a finite number"},
      {of_mass("1e999"), "r.urdf:3:24: error: value: '1e999' is out of range"},
      {of_mass("1,5"),
       "r.urdf:3:24: error: value: '1,5' is not a number; use a point as the decimal sign, and separate numbers by blanks"},
      {of_mass("1.0kg"),
       "r.urdf:3:24: error: value: '1.0kg' is not a number; units are not written here: values are in m, kg, s and units derived "
       "from them"},
      {of_mass("${m}"),
       "r.urdf:3:24: error: value: '${m}' is not a number; expand the file first: xacro robot.urdf.xacro > robot.urdf"},
      {of_mass(""), "r.urdf:3:24: error: value: expected 1 number, found none; separate numbers by blanks"},
      {of_mass("1 2"), "r.urdf:3:24: error: value: expected 1 number, found 2"},
      {of_mass("0x10"),
       "r.urdf:3:24: error: value: '0x10' is not a number; units are not written here: values are in m, kg, s and units derived "
       "from them"},
      {joined("<origin xyz='1 2'/>"), "r.urdf:7:14: error: xyz: expected 3 numbers, found 2"},
      {joined("<origin xyz='1 2 3 4' rpy='0,0,0'/>"),
       "r.urdf:7:14: error: xyz: expected 3 numbers, found 4\n"
       "r.urdf:7:28: error: rpy: '0,0,0' is not a number; use a point as the decimal sign, and separate numbers by blanks"},
  });
}

TEST_CASE("URDF: what xacro has not expanded is refused, and makes no second complaint") {
  const std::string cure = "; expand the file first: xacro robot.urdf.xacro > robot.urdf";
  check({
      {head + "<xacro:include filename='arm.xacro'/>\n<xacro:arm name='left'/>\n" + a_link("a") + "</robot>",
       "r.urdf:2:1: error: <xacro:include> is not expanded: what it stands for is missing" + cure +
           "\nr.urdf:3:1: error: <xacro:arm> is not expanded: what it stands for is missing" + cure},
      {joined("<limit lower='-${pi}' upper='${pi}' effort='1' velocity='1'/>"),
       "r.urdf:7:15: error: lower: '-${pi}' is not a number" + cure + "\nr.urdf:7:30: error: upper: '${pi}' is not a number" +
           cure},
  });
  const ReadResult result = read_scenario_text(joined("<limit lower='-${pi}' upper='${pi}' effort='1' velocity='1'/>"), "r.urdf");
  CHECK(said(result, Severity::warning).empty());
}

TEST_CASE("URDF: impossible masses and inertias are refused") {
  check({
      {inertial("<inertia ixx='1' iyy='1' izz='1'/>"),
       "r.urdf:3:1: error: <inertial> has no <mass>; for example <mass value=\"1.5\"/>, in kg"},
      {inertial("<mass value='-1'/>"), "r.urdf:3:24: error: value: must not be negative"},
      {inertial("<mass/>"), "r.urdf:3:11: error: <mass> has no 'value'; the mass in kg"},
      {inertial("<mass value='0'/><inertia ixx='1' iyy='1' izz='1'/>"),
       "r.urdf:3:1: error: inertia: a body without mass has none ('a'); give a mass, or an inertia of 0"},
      {inertial("<mass value='1'/><inertia ixx='1' iyy='1'/>"),
       "r.urdf:3:28: error: <inertia> has no 'izz'; about the centre of mass, in the axes of <origin>"},
      {inertial("<mass value='1'/><inertia ixx='-1' iyy='1' izz='1'/>"),
       "r.urdf:3:1: error: inertia: no body has a negative principal moment ('a'); the order is xx, yy, zz, xy, xz, yz, about "
       "the "
       "centre of mass"},
      {inertial("<mass value='1'/><inertia ixx='1' iyy='1' izz='3'/>"),
       "r.urdf:3:1: error: inertia: the largest principal moment is more than the sum of the others, which no body has ('a'); it "
       "is "
       "meant about the centre of mass, and products of inertia as elements of the matrix (xy = −Σ m x y)"},
      {inertial("<mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixyy='0.5'/>"),
       "r.urdf:3:61: error: unknown attribute 'ixyy' of <inertia>; did you mean 'ixy'?"},
      // A joint can move nothing for other reasons than a missing mass.
      {head + a_link("a") + "<link name='b'/>\n" + joint("j", "a", "b") + "</robot>",
       "r.urdf:4:1: error: joint 'r/j': the joint-space mass is singular: degree of freedom 1 of 1 of this revolute joint moves "
       "no mass; "
       "give the "
       "bodies outboard of it a mass or an inertia about its axis, or give the joint an armature"},
  });
}

TEST_CASE("URDF: impossible joints are refused") {
  const std::string limit = "<limit lower='0' upper='1' effort='1' velocity='1'/>";
  check({
      {joined("<axis xyz='0 0 0'/>" + limit),
       "r.urdf:7:12: error: xyz: an axis of length zero has no direction; for example xyz=\"0 0 1\""},
      {joined("<axis xyz='1e-12 0 0'/>" + limit),
       "r.urdf:7:12: error: xyz: an axis of length zero has no direction; for example xyz=\"0 0 1\""},
      {joined("<axis xyz='0 0 0'/>", "planar"),
       "r.urdf:7:12: error: xyz: an axis of length zero has no direction; for example xyz=\"0 0 1\""},
      {joined("<limit lower='1' upper='-1' effort='1' velocity='1'/>"),
       "r.urdf:7:15: error: limit: 'lower' is greater than 'upper'; swap them"},
      {joined("<limit lower='0' upper='1' effort='-1' veloctiy='1'/>"),
       "r.urdf:7:36: error: effort: must not be negative\n"
       "r.urdf:7:40: error: unknown attribute 'veloctiy' of <limit>; did you mean 'velocity'?"},
      {joined("<dynamics damping='-0.1'/>" + limit), "r.urdf:7:20: error: damping: must not be negative"},
      {joined("<dynamics friction='-0.1'/>" + limit), "r.urdf:7:21: error: friction: must not be negative"},
      {joined(limit, "revolut"), "r.urdf:4:23: error: unknown type of joint 'revolut'; did you mean 'revolute'?"},
      {joined(limit, "gearbox"),
       "r.urdf:4:23: error: unknown type of joint 'gearbox'; one of: revolute continuous prismatic fixed floating planar"},
      {joined(limit + "<axis/>"), "r.urdf:7:53: error: <axis> has no 'xyz'; for example xyz=\"0 0 1\""},
      {joined(limit + limit), "r.urdf:7:53: error: a second <limit> in <joint>: the first is on line 7; leave one of them out"},
      {joined("<mimic joint='j'/>", "continuous"),
       "r.urdf:7:1: error: mimic: joint 'j' follows itself; one of them must lead and follow no other"},
      {head + a_link("a") + "<joint name='j' type='fixed'/></robot>",
       "r.urdf:3:1: error: <joint> has no <parent>; for example <parent link=\"base\"/>\n"
       "r.urdf:3:1: error: <joint> has no <child>; for example <child link=\"base\"/>"},
  });
}

TEST_CASE("URDF: links and joints that form no tree are refused") {
  check({
      {head + a_link("a") + a_link("a") + "</robot>",
       "r.urdf:3:13: error: duplicate link 'a': the name is already used by another on line 2"},
      {head + a_link("a") + a_link("b") + a_link("c") + joint("j", "a", "b") + joint("j", "b", "c") + "</robot>",
       "r.urdf:10:14: error: duplicate joint 'j': the name is already used by another on line 5"},
      {head + a_link("base") + a_link("b") + joint("j", "bass", "b") + "</robot>",
       "r.urdf:5:15: error: parent: there is no link 'bass'; did you mean 'base'?"},
      {head + a_link("a") + joint("j", "a", "b") + "</robot>", "r.urdf:5:14: error: child: there is no link 'b'"},
      {head + a_link("a") + a_link("b") + joint("j", "b", "b") + joint("k", "a", "b") + "</robot>",
       "r.urdf:6:14: error: joint 'j' joins link 'b' to itself"},
      {head + a_link("a") + a_link("b") + joint("j", "a", "b") + joint("k", "b", "a") + "</robot>",
       "r.urdf:10:15: error: the joints form a cycle: 'a' on 'b' on 'a'; the format describes trees: leave out one of "
       "these joints, and close the loop by a [[loop]] of the scenario"},
      {head + a_link("a") + a_link("b") + "</robot>",
       "r.urdf:3:1: error: a second root: link 'b' is not the child of any joint, like 'a' on line 2; join one to the other, or "
       "make two files"},
      {head + a_link("a") + a_link("b") + a_link("c") + joint("j", "a", "c") + joint("k", "b", "c") + "</robot>",
       "r.urdf:12:14: error: link 'c' has two parents: joint 'k' joins it to 'b', and 'j' on line 5 to 'a'; the format "
       "describes trees: leave out one of these joints, and close the loop by a [[loop]] of the scenario"},
      {head + a_link("a") + a_link("b") + a_link("c") + joint("ab", "a", "b") + joint("ac", "a", "c") + joint("bc", "b", "c") +
           "</robot>",
       "r.urdf:17:14: error: link 'c' has two parents: joint 'bc' joins it to 'b', and 'ac' on line 10 to 'a'. That closes the "
       "loop "
       "'a' – 'c' – 'b' – 'a' of the joints 'ac' (line 10), 'bc' (line 15), 'ab' (line 5); the format describes trees: leave "
       "out one of these joints, and close the loop by a [[loop]] of the scenario"},
      {head + "</robot>", "r.urdf:1:1: error: the robot has no <link>"},
      {head + "<link>" + mass + "</link></robot>", "r.urdf:2:1: error: <link> has no 'name'; for example name=\"upper_arm\""},
      {head + a_link("") + "</robot>", "r.urdf:2:13: error: name: a link cannot be named '': it is empty"},
      {head + a_link("..") + "</robot>", "r.urdf:2:13: error: name: a link cannot be named '..': it means a folder"},
      {head + a_link("a/b") + a_link("a_b") + "</robot>",
       "r.urdf:3:13: error: duplicate link 'a_b': the name is already used by another on line 2"},
      {head + "<link nmae='a'>" + mass + "</link></robot>",
       "r.urdf:2:1: error: <link> has no 'name'; for example name=\"upper_arm\"\n"
       "r.urdf:2:7: error: unknown attribute 'nmae' of <link>; did you mean 'name'?"},
  });
}

TEST_CASE("URDF: meshes elsewhere are not opened, with a note") {
  const auto visual = [](const std::string& file) {
    return head + "<link name='a'>" + mass + "<visual><geometry><mesh filename='" + file +
           "'/></geometry></visual></link></robot>";
  };
  for (const char* file : {"/etc/passwd", "/dev/zero", "../../secret.stl", "file:///dev/stdin", "package://r/../../x.stl",
                           "package:///r/../../x.stl", "meshes/../../x.stl", "..\\x.stl"}) {
    const ReadResult result = read_scenario_text(visual(file), "r.urdf");
    REQUIRE(result.scenario);
    CHECK(result.scenario->shapes.at(0).kind == Shape::Kind::none);
    CHECK(said(result, Severity::note) ==
          "r.urdf:2:122: note: a mesh is not in the model's folder or below it: pictures leave it out; the motion does not "
          "depend on it");
  }
  for (const char* file : {"", "package://", "package:///"})
    CHECK(errors_of(visual(file)) == "r.urdf:2:122: error: a mesh has no file name");
}

TEST_CASE("files that are not URDF are refused") {
  check({
      {"", "r.urdf:1:1: error: the file is empty: there is no element in it"},
      {"<robt/>", "r.urdf:1:1: error: no model begins with '<robt>'; did you mean <robot>?"},
      {head + a_link("a"), "r.urdf:3:1: error: the file ends within <robot>, opened on line 1; is it complete?"},
      {head + a_link("a") + "</robot>\n" + head + a_link("a") + "</robot>",
       "r.urdf:4:1: error: something follows the end of the document; a file holds one root element"},
      {"<html><body/></html>",
       "r.urdf:1:1: error: no model begins with '<html>'; known are <mujoco> (MJCF), <sdf> (SDF), <robot> (URDF)"},
  });
}

TEST_CASE("URDF: all problems of a file are reported at once, up to a readable number") {
  std::string text = head;
  for (int i = 0; i < 1000; ++i)
    text += "<link name='a'><inertial><mass value='x" + std::to_string(i) + "'/></inertial></link>\n";
  const ReadResult result = read_scenario_text(text + "</robot>", "r.urdf");
  CHECK(!result.scenario);
  CHECK(result.diagnostics.size() == 101);
  CHECK(result.diagnostics.back().message() == "r.urdf: error: and 1 or more further errors");
}

TEST_CASE("URDF: thousands of loops are reported quickly") {
  std::string text = head;
  const int n = 20'000;
  for (int i = 0; i < n; ++i) text += a_link("l" + std::to_string(i));
  for (int i = 1; i < n; ++i) {
    text += joint("j" + std::to_string(i), "l" + std::to_string(i - 1), "l" + std::to_string(i));
    text += joint("k" + std::to_string(i), "l0", "l" + std::to_string(i));
  }
  const ReadResult result = read_scenario_text(text + "</robot>", "r.urdf");
  CHECK(!result.scenario);
  CHECK(result.diagnostics.size() == 101);
}
