// Broken and hostile MJCF: each error is reported with its place and a hint.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <tests/models.hpp>

using namespace momentree::io;
using namespace momentree::io::models;

namespace {

const std::string geom = "<geom size='1'/>";
const std::string seven = [] {
  std::string text;
  for (int k = 0; k < 7; ++k) text += "<joint axis='1 0 0'/>";
  return text;
}();

std::string mjcf(const std::string& bodies, const std::string& before = "", const std::string& after = "") {
  return "<mujoco model='m'>" + before + "\n<worldbody>\n" + bodies + "\n</worldbody>\n" + after + "</mujoco>";
}
std::string body(const std::string& text, const std::string& name = "a") {
  return "<body name='" + name + "'>" + text + "</body>";
}
std::string inside(const std::string& text) { return mjcf(body(text)); }
/// A joint, or an <inertial>, on the fourth line.
std::string joint(const std::string& text) { return inside(geom + "\n<joint " + text + "/>"); }
std::string inertial(const std::string& text) { return inside("\n<inertial " + text + "/><joint/>"); }

struct Case {
  std::string text, said;
};
void check(const std::vector<Case>& cases) {
  for (const Case& each : cases) {
    CAPTURE(each.text.substr(0, 500));
    CHECK(errors_of(each.text, "m.xml") == each.said);
  }
}

}  // namespace

TEST_CASE("MJCF: invalid numbers are refused") {
  check({
      {joint("damping='nan'"), "m.xml:4:17: error: damping: 'nan' is not a finite number"},
      {joint("damping='-inf'"), "m.xml:4:17: error: damping: '-inf' is not a finite number"},
      {joint("damping='1e999'"), "m.xml:4:17: error: damping: '1e999' is out of range"},
      {joint("damping='1,5'"),
       "m.xml:4:17: error: damping: '1,5' is not a number; use a point as the decimal sign, and separate numbers by blanks"},
      {joint("damping='1.0kg'"),
       "m.xml:4:17: error: damping: '1.0kg' is not a number; units are not written here: values are in m, kg, s and units "
       "derived from them"},
      {joint("damping='${d}'"),
       "m.xml:4:17: error: damping: '${d}' is not a number; expand the file first: xacro robot.urdf.xacro > robot.urdf"},
      {joint("damping=''"), "m.xml:4:17: error: damping: expected 1 number, found none; separate numbers by blanks"},
      {joint("damping='1 2'"), "m.xml:4:17: error: damping: expected 1 number, found 2"},
      {joint("damping='0x10'"),
       "m.xml:4:17: error: damping: '0x10' is not a number; units are not written here: values are in m, kg, s and units derived "
       "from them"},
      {joint("axis='0 1'"), "m.xml:4:14: error: axis: expected 3 numbers, found 2"},
      {inside("<geom size='inf'/>"), "m.xml:3:28: error: size: 'inf' is not a finite number"},
      {inside("<geom size='1' density='x'/>"), "m.xml:3:40: error: density: 'x' is not a number"},
      {mjcf("<body quat='1 0 0'>" + geom + "</body>"), "m.xml:3:13: error: quat: expected 4 numbers, found 3"},
      {mjcf("<body quat='0 0 0 0'>" + geom + "</body>"),
       "m.xml:3:13: error: quat: has no direction; its length is zero, or two axes are parallel"},
      {mjcf(body(geom), "<option gravity='0 0'/>"), "m.xml:1:36: error: gravity: expected 3 numbers, found 2"},
  });
}

TEST_CASE("MJCF: impossible masses and inertias are refused") {
  check({
      {inertial("pos='0 0 0'"), "m.xml:4:1: error: <inertial> has no 'mass'; in kg"},
      {inertial("mass='1' diaginertia='1 1 1'"), "m.xml:4:1: error: <inertial> has no 'pos'; its centre of mass"},
      {inertial("pos='0 0 0' mass='-1'"), "m.xml:4:29: error: mass: must not be negative"},
      {inertial("pos='0 0 0' mass='0' diaginertia='1 1 1'"),
       "m.xml:4:1: error: inertia: a body without mass has none ('a'); give a mass, or an inertia of 0"},
      {inertial("pos='0 0 0' mass='1' diaginertia='1 1 3'"),
       "m.xml:4:1: error: inertia: the largest principal moment is more than the sum of the others, which no body has ('a'); it "
       "is meant about the centre of mass, and products of inertia as elements of the matrix (xy = −Σ m x y)"},
      {inertial("pos='0 0 0' mass='1' fullinertia='1 1 1 2 0 0'"),
       "m.xml:4:1: error: inertia: no body has a negative principal moment ('a'); the order is xx, yy, zz, xy, xz, yz, about the "
       "centre of mass"},
      {inertial("pos='0 0 0' mass='1' fullinertia='1 1 1 0 0 0' diaginertia='1 1 1'"),
       "m.xml:4:71: error: diaginertia and fullinertia give the inertia twice; leave one of them out"},
      {inside(geom + "<geom size='1' mass='-1'/>"), "m.xml:3:53: error: mass: must not be negative"},
      {inside("<geom size='1' density='-1'/>"), "m.xml:3:40: error: density: must not be negative"},
      {inside("<geom size='-1'/>"), "m.xml:3:28: error: size: must be greater than 0"},
      {inside("<geom type='box' size='1 1'/>"), "m.xml:3:39: error: size: expected 3 numbers, found 2"},
      {inside("<geom type='capsule' size='1' fromto='1 2 3 1 2 3'/>"), "m.xml:3:54: error: fromto: the two ends coincide"},
      {inside("<geom type='mesh' mesh='x'/>"),
       "m.xml:3:16: error: the inertia of this geom is not computed; give the body an <inertial>, or the geom mass=\"0\""},
      {inside("<joint/>"),
       "m.xml:3:16: error: joint 'm/a': the joint-space mass is singular: degree of freedom 1 of 1 of this revolute joint moves "
       "no mass; "
       "give the bodies outboard of it a mass or an inertia about its axis, or give the joint an armature"},
      {inside(geom + "<inertial pos='0 0 0' mass='1'/><inertial pos='0 0 0' mass='1'/>"),
       "m.xml:3:64: error: a second <inertial> in one body; leave one of them out"},
  });
}

TEST_CASE("MJCF: impossible joints are refused") {
  check({
      {joint("axis='0 0 0'"), "m.xml:4:14: error: axis: an axis of length zero has no direction; for example axis=\"0 0 1\""},
      {joint("axis='1e-12 0 0'"), "m.xml:4:14: error: axis: an axis of length zero has no direction; for example axis=\"0 0 1\""},
      {joint("range='1 -1'"), "m.xml:4:15: error: range: the first number is not less than the second; swap them"},
      {joint("limited='true'"), "m.xml:4:17: error: limited: the joint has no 'range'; give one, or limited=\"false\""},
      {joint("limited='yes' range='0 1'"), "m.xml:4:17: error: limited: expected true, false or auto, found 'yes'"},
      {joint("damping='-1'"), "m.xml:4:17: error: damping: must not be negative"},
      {joint("stiffness='-1'"), "m.xml:4:19: error: stiffness: must not be negative"},
      {joint("armature='-1'"), "m.xml:4:18: error: armature: must not be negative"},
      {joint("frictionloss='-1'"), "m.xml:4:22: error: frictionloss: must not be negative"},
      {joint("springdamper='1 1'"),
       "m.xml:4:22: error: springdamper is not supported: it depends on the whole model; give stiffness and damping themselves"},
      {joint("type='hing'"), "m.xml:4:14: error: unknown type of joint 'hing'; did you mean 'hinge'?"},
      {joint("damp='1'"), "m.xml:4:8: error: unknown attribute 'damp' of <joint>; did you mean 'name'?"},
      {joint("stifness='1'"), "m.xml:4:8: error: unknown attribute 'stifness' of <joint>; did you mean 'stiffness'?"},
      {joint("class='none'"), "m.xml:4:15: error: class: there is no default class 'none'"},
      {inside(geom + "<joint/><freejoint/>"), "m.xml:3:40: error: a free joint must be the only joint of its body"},
      {inside(geom + "<body>" + geom + "<freejoint/></body>"),
       "m.xml:3:54: error: only a body in <worldbody> can have a free joint"},
      {inside(geom + seven), "m.xml:3:158: error: a body has more than 6 joints"},
  });
}

TEST_CASE("MJCF: names and what they refer to") {
  check({
      {mjcf(body(geom) + "\n" + body(geom)),
       "m.xml:4:13: error: duplicate body 'a': the name is already used by another on line 3"},
      {inside(geom + "<joint name='j'/>\n<joint name='j' axis='1 0 0'/>"),
       "m.xml:4:14: error: duplicate joint 'j': the name is already used by another on line 3"},
      {mjcf(body(geom, "a/b")),
       "m.xml:3:13: error: name: a body cannot be named 'a/b': it has a character that is not allowed; a name has no / , \" * "
       "and no control characters"},
      {mjcf(body(geom, "")), "m.xml:3:13: error: name: a body cannot be named '': it is empty"},
      {mjcf(body(geom, "ground")), "m.xml:3:13: error: name: a body cannot be named 'ground': it means the ground"},
      {mjcf("<body nmae='a'>" + geom + "</body>"), "m.xml:3:7: error: unknown attribute 'nmae' of <body>; did you mean 'name'?"},
      {mjcf("<body childclass='x'>" + geom + "</body>"), "m.xml:3:19: error: childclass: there is no default class 'x'"},
      {mjcf(body(geom), "<default><default/></default>"),
       "m.xml:1:28: error: <default> within <default> has no 'class'; give it a name"},
      {mjcf(body(geom), "<default><default class='x'/>\n<default class='x'/></default>"),
       "m.xml:2:1: error: duplicate default class 'x': the name is already used by another on line 1"},
      {mjcf(body(geom), "<compiler angle='grad'/>"), "m.xml:1:36: error: angle: expected one of degree, radian, found 'grad'"},
      {mjcf(body(geom), "<compiler eulerseq='xyq'/>"),
       "m.xml:1:39: error: eulerseq: expected three of the letters x, y, z, X, Y, Z, found 'xyq'"},
      {mjcf(body(geom), "<compiler coordinate='global'/>"),
       "m.xml:1:41: error: coordinates in the world's frame are not supported; save the model in local coordinates"},
  });
}

TEST_CASE("MJCF: impossible equalities and non-rigid bodies are refused") {
  const auto equality = [](const std::string& text) {
    return mjcf(body(geom + "<joint name='j'/><site name='s'/><site name='t' fromto='0 0 0 1 0 0'/>") +
                    body(geom + "<joint name='k' type='ball'/>", "b"),
                "", "<equality>\n" + text + "</equality>");
  };
  check({
      {equality("<connect body1='a' body2='c' anchor='0 0 0'/>"), "m.xml:6:27: error: there is no body 'c'"},
      {equality("<connect body1='a' body2='b'/>"),
       "m.xml:6:1: error: <connect> has no 'anchor'; the point in the frame of body1, for example anchor=\"0 0 0.5\""},
      {equality("<weld body2='b'/>"),
       "m.xml:6:1: error: <weld> has no 'body1'; the name of a body, or two sites: site1 and site2"},
      {equality("<weld body1='a' body2='a'/>"), "m.xml:6:1: error: <weld> joins a body to itself"},
      {equality("<weld body1='world'/>"), "m.xml:6:1: error: <weld> joins the world to itself"},
      {equality("<weld site1='s'/>"), "m.xml:6:1: error: <weld> has no 'site2'; both ends are sites, or both are bodies"},
      {equality("<weld site1='s' site2='u'/>"), "m.xml:6:24: error: there is no site 'u'"},
      {equality("<weld site1='s' site2='t'/>"),
       "m.xml:3:88: error: a site of <equality> is not placed by fromto here; give it pos, and quat or the like"},
      {equality("<weld body1='a' body2='b' relpose='0 0 0 1e-12 0 0 0'/>"),
       "m.xml:6:36: error: relpose: the quaternion has no direction"},
      {equality("<weld body1='a' body2='b' relpose='0 0 0'/>"), "m.xml:6:36: error: relpose: expected 7 numbers, found 3"},
      {equality("<weld name='w' body1='a' body2='b'/>\n<weld name='w' body1='b' body2='a'/>"),
       "m.xml:7:13: error: duplicate equality 'w': the name is already used by another on line 6"},
      {equality("<weld name='w/x' body1='a' body2='b'/>"),
       "m.xml:6:13: error: name: an equality cannot be named 'w/x': it has a character that is not allowed; a name has no / , \" "
       "* "
       "and no control characters"},
      {equality("<joint joint1='j' joint2='l'/>"), "m.xml:6:27: error: there is no joint 'l'"},
      {equality("<joint joint1='k' joint2='j'/>"),
       "m.xml:6:16: error: joint1: joint 'k' is a ball joint; it needs one degree of freedom"},
      {mjcf(body(geom + "<site name='s'/>\n<site name='s'/>")),
       "m.xml:4:13: error: duplicate site 's': the name is already used by another on line 3"},
      {mjcf(body(geom + "<freejoint/>"), "", "<equality><connect body1='a' anchor='nan 0 0'/></equality>"),
       "m.xml:5:38: error: anchor: 'nan' is not a finite number"},
      {mjcf(body(geom), "", "<deformable/>"), "m.xml:5:1: error: <deformable> is not supported: bodies are rigid; leave it out"},
      {inside(geom + "<composite type='rope'/>"),
       "m.xml:3:32: error: <composite> is not supported; save the model as MuJoCo compiled it (mj_saveLastXML)"},
      {mjcf("<body mocap='true'>" + geom + "</body>"),
       "m.xml:3:14: error: bodies with a motion imposed from outside (mocap) are not supported; leave it out"},
  });
}

TEST_CASE("MJCF: files that are not MJCF, or leave their folder, are refused") {
  check({
      {"", "m.xml:1:1: error: the file is empty: there is no element in it"},
      {"<mujco/>", "m.xml:1:1: error: no model begins with '<mujco>'; did you mean <mujoco>?"},
      {"<mujoco/>",
       "m.xml:1:1: error: the model has no <body> in a <worldbody>; for example <worldbody><body><geom "
       "size=\"1\"/></body></worldbody>"},
      {"<mujoco><worldbody/></mujoco>",
       "m.xml:1:1: error: the model has no <body> in a <worldbody>; for example <worldbody><body><geom "
       "size=\"1\"/></body></worldbody>"},
      {"<mujoco><worldbody><body>" + geom, "m.xml:1:42: error: the file ends within <body>, opened on line 1; is it complete?"},
      {inside(geom) + "<mujoco/>", "m.xml:5:10: error: something follows the end of the document; a file holds one root element"},
      {"<!DOCTYPE x [<!ENTITY a 'b'>]>\n" + inside(geom),
       "m.xml:1:1: error: a document type (<!DOCTYPE …>) is not supported: no entity is declared, expanded or fetched; leave it "
       "out: "
       "a model needs none"},
      {inside("\xff"), "m.xml:3:16: error: the text is not UTF-8; save the file with the encoding UTF-8"},
      {mjcf("<include file='/etc/passwd'/>"),
       "m.xml:3:16: error: include: '/etc/passwd' is not in the model's folder or below it; copy it there"},
      {mjcf("<include file='../x.xml'/>"),
       "m.xml:3:16: error: include: '../x.xml' is not in the model's folder or below it; copy it there"},
      {mjcf("<include file='a/../../x.xml'/>"),
       "m.xml:3:16: error: include: 'a/../../x.xml' is not in the model's folder or below it; copy it there"},
      {mjcf("<include file=''/>"), "m.xml:3:16: error: include: the name of a file is missing"},
      {mjcf("<include/>"), "m.xml:3:1: error: <include> has no 'file'; for example <include file=\"arm.xml\"/>"},
  });
}

TEST_CASE("MJCF: all problems of a file are reported at once, up to a readable number") {
  std::string bodies;
  for (int i = 0; i < 1000; ++i) bodies += "<body><geom size='x" + std::to_string(i) + "'/></body>\n";
  const ReadResult result = read_scenario_text(mjcf(bodies), "m.xml");
  CHECK(!result.scenario);
  CHECK(result.diagnostics.size() == 101);
  CHECK(result.diagnostics.back().message().ends_with("or more further errors"));
}
