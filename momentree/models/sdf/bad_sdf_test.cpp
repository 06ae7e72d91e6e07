// Broken and hostile SDF: each error is reported with its place and a hint.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <tests/models.hpp>

using namespace momentree::io;
using namespace momentree::io::models;

namespace {

const std::string head = "<sdf version='1.9'>\n<model name='m'>\n", end = "</model></sdf>";
const std::string inertia = "<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>";
const std::string mass = "<inertial><mass>1</mass>" + inertia + "</inertial>";
const std::string axis = "<axis><xyz>0 0 1</xyz></axis>";

std::string a_link(const std::string& name, const std::string& more = "") {
  return "<link name='" + name + "'>" + mass + more + "</link>\n";
}
std::string joint(const std::string& name, const std::string& parent, const std::string& child, const std::string& more = axis,
                  const std::string& type = "revolute") {
  return "<joint name='" + name + "' type='" + type + "'>\n<parent>" + parent + "</parent>\n<child>" + child + "</child>\n" +
         more + "\n</joint>\n";
}
/// A link with this inertial on the fourth line.
std::string inertial(const std::string& text) { return head + "<link name='a'>\n<inertial>" + text + "</inertial></link>" + end; }
/// Two links and their joint, whose content `more` is on its fourth line, the eighth of the file.
std::string joined(const std::string& more, const std::string& type = "revolute") {
  return head + a_link("a") + a_link("b") + joint("j", "a", "b", more, type) + end;
}
std::string mesh(const std::string& uri) {
  return head + "<link name='a'>" + mass + "<visual name='v'><geometry><mesh><uri>" + uri +
         "</uri></mesh></geometry></visual></link>" + end;
}

struct Case {
  std::string text, said;
};
void check(const std::vector<Case>& cases) {
  for (const Case& each : cases) {
    CAPTURE(each.text.substr(0, 500));
    CHECK(errors_of(each.text, "m.sdf") == each.said);
  }
}

}  // namespace

TEST_CASE("SDF: invalid numbers are refused") {
  check({
      {inertial("<mass>nan</mass>" + inertia), "m.sdf:4:17: error: mass: 'nan' is not a finite number"},
      {inertial("<mass>-inf</mass>" + inertia), "m.sdf:4:17: error: mass: '-inf' is not a finite number"},
      {inertial("<mass>1e999</mass>" + inertia), "m.sdf:4:17: error: mass: '1e999' is out of range"},
      {inertial("<mass>1,5</mass>" + inertia),
       "m.sdf:4:17: error: mass: '1,5' is not a number; use a point as the decimal sign, and separate numbers by blanks"},
      {inertial("<mass>1.0kg</mass>" + inertia),
       "m.sdf:4:17: error: mass: '1.0kg' is not a number; units are not written here: values are in m, kg, s and units derived "
       "from them"},
      {inertial("<mass>${m}</mass>" + inertia),
       "m.sdf:4:17: error: mass: '${m}' is not a number; expand the file first: xacro robot.urdf.xacro > robot.urdf"},
      {inertial("<mass></mass>" + inertia), "m.sdf:4:11: error: mass: expected 1 number, found none; separate numbers by blanks"},
      {inertial("<mass>1 2</mass>" + inertia), "m.sdf:4:17: error: mass: expected 1 number, found 2"},
      {inertial("<mass>0x10</mass>" + inertia),
       "m.sdf:4:17: error: mass: '0x10' is not a number; units are not written here: values are in m, kg, s and units derived "
       "from them"},
      {joined("<pose>1 2 3</pose>" + axis), "m.sdf:8:7: error: pose: expected 6 numbers, found 3"},
      {joined("<pose rotation_format='quat_xyzw'>0 0 0 0 0 0 2</pose>" + axis),
       "m.sdf:8:35: error: pose: the length of the quaternion is not 1; the order is x y z qx qy qz qw"},
      {joined("<pose rotation_format='quat'>0 0 0 0 0 0</pose>" + axis),
       "m.sdf:8:24: error: rotation_format: expected euler_rpy or quat_xyzw, found 'quat'"},
      {joined("<pose degrees='yes'>0 0 0 0 0 0</pose>" + axis),
       "m.sdf:8:16: error: degrees: expected true or false, found 'yes'"},
      {joined("<axis><xyz>0 0</xyz></axis>"), "m.sdf:8:12: error: xyz: expected 3 numbers, found 2"},
  });
}

TEST_CASE("SDF: impossible masses and inertias are refused") {
  check({
      {inertial("<mass>-1</mass>" + inertia), "m.sdf:4:17: error: mass: must not be negative"},
      {inertial("<mass>0</mass>" + inertia),
       "m.sdf:4:1: error: inertia: a body without mass has none ('a'); give a mass, or an inertia of 0"},
      {inertial("<mass>1</mass><inertia><ixx>-1</ixx><iyy>1</iyy><izz>1</izz></inertia>"),
       "m.sdf:4:1: error: inertia: no body has a negative principal moment ('a'); the order is xx, yy, zz, xy, xz, yz, about the "
       "centre of mass"},
      {inertial("<mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>3</izz></inertia>"),
       "m.sdf:4:1: error: inertia: the largest principal moment is more than the sum of the others, which no body has ('a'); it "
       "is meant about the centre of mass, and products of inertia as elements of the matrix (xy = −Σ m x y)"},
      {inertial("<mass>1</mass><mass>2</mass>" + inertia),
       "m.sdf:4:25: error: a second <mass> in <inertial>: the first is on line 4; leave one of them out"},
      {head + "<link name='a'>\n<inertial auto='true'/></link>" + end,
       "m.sdf:4:17: error: computing the inertia from collisions is not supported; give mass and inertia as numbers"},
      {inertial("<pose relative_to='b'>0 0 0 0 0 0</pose><mass>1</mass>" + inertia),
       "m.sdf:4:30: error: the pose of an <inertial> is relative to its link and cannot name a frame; leave the attribute out"},
  });
}

TEST_CASE("SDF: impossible joints are refused") {
  check({
      {joined("<axis><xyz>0 0 0</xyz></axis>"),
       "m.sdf:8:12: error: xyz: an axis of length zero has no direction; for example <xyz>0 0 1</xyz>"},
      {joined("<axis><xyz>1e-12 0 0</xyz></axis>"),
       "m.sdf:8:12: error: xyz: an axis of length zero has no direction; for example <xyz>0 0 1</xyz>"},
      {joined("<axis><xyz expressed_in='c'>0 0 1</xyz></axis>"),
       "m.sdf:8:29: error: expressed_in: there is no link, joint, frame or model 'c' here"},
      {joined("<axis><xyz expresed_in='a'>0 0 1</xyz></axis>"),
       "m.sdf:8:12: error: unknown attribute 'expresed_in' of <xyz>; did you mean 'expressed_in'?"},
      {joined("<axis><limit><lower>1</lower><upper>-1</upper></limit></axis>"),
       "m.sdf:8:21: error: limit: 'lower' is greater than 'upper'; swap them"},
      {joined("<axis><limit><lower>nan</lower></limit></axis>"), "m.sdf:8:21: error: lower: 'nan' is not a finite number"},
      {joined("<axis><dynamics><damping>-1</damping></dynamics></axis>"), "m.sdf:8:26: error: damping: must not be negative"},
      {joined("<axis><dynamics><friction>-1</friction></dynamics></axis>"), "m.sdf:8:27: error: friction: must not be negative"},
      {joined("<axis><dynamics><spring_stiffness>-1</spring_stiffness></dynamics></axis>"),
       "m.sdf:8:35: error: spring_stiffness: must not be negative"},
      {joined(""), "m.sdf:5:1: error: <joint> has no <axis>; for example <axis><xyz>0 0 1</xyz></axis>"},
      {joined(axis, "universal"), "m.sdf:5:1: error: <joint> has no <axis2>; for example <axis2><xyz>0 0 1</xyz></axis2>"},
      {joined(axis + "<axis2><xyz>0 0 1</xyz></axis2>", "universal"),
       "m.sdf:5:1: error: axis2: is parallel to 'axis': that would be the same degree of freedom twice; for example "
       "perpendicular to it"},
      {joined(axis, "revolut"), "m.sdf:5:23: error: unknown type of joint 'revolut'; did you mean 'revolute'?"},
      {joined(axis, "floating"),
       "m.sdf:5:23: error: unknown type of joint 'floating'; one of: revolute continuous prismatic fixed ball universal "
       "revolute2 screw"},
      {joined(axis, "gearbox"),
       "m.sdf:5:23: error: a gearbox couples two joints, which is not supported yet; leave it out: the joints then move "
       "independently"},
      {joined(axis + "<thread_pitch>0</thread_pitch>", "screw"),
       "m.sdf:8:44: error: thread_pitch: 0 rad/m is not a thread; it is in rad/m, and positive for a left-handed thread"},
      {head + a_link("a") + "<joint name='j' type='fixed'/>" + end,
       "m.sdf:4:1: error: <joint> has no <parent>; for example <parent>base</parent>\nm.sdf:4:1: error: <joint> has no <child>; "
       "for example <child>base</child>"},
      {joined(axis + "<parent/>"),
       "m.sdf:8:30: error: a second <parent> in <joint>: the first is on line 6; leave one of them out"},
  });
}

TEST_CASE("SDF: links and joints that form no tree are refused") {
  check({
      {head + a_link("a") + a_link("a") + end,
       "m.sdf:4:13: error: duplicate link 'a': the name is already used by another on line 3"},
      {head + a_link("a") + a_link("b") + joint("b", "a", "b") + end,
       "m.sdf:5:14: error: duplicate joint 'b': the name is already used by the <link> on line 4"},
      {head + a_link("base") + a_link("b") + joint("j", "bass", "b") + end,
       "m.sdf:6:9: error: parent: there is no link, joint, frame or model 'bass' here; did you mean 'base'?"},
      {head + a_link("a") + joint("j", "a", "b") + end,
       "m.sdf:6:8: error: child: there is no link, joint, frame or model 'b' here"},
      {head + a_link("a") + joint("j", "a", "world") + end,
       "m.sdf:6:8: error: child: the world cannot be a joint's child; swap parent and child, and reverse the axis"},
      {head + a_link("a") + joint("j", "a", "a") + end, "m.sdf:6:8: error: joint 'j' joins link 'a' to itself"},
      {head + a_link("a") + a_link("b") + joint("j", "a", "b") + joint("k", "a", "b", "<axis><xyz>1 0</xyz></axis>") + end,
       "m.sdf:13:12: error: xyz: expected 3 numbers, found 2"},
      {head + a_link("a") + a_link("b") + joint("j", "a", "b") +
           joint("k", "a", "b", "<axis><xyz>0 0 1</xyz><mimic joint='j'/></axis>") +
           joint("l", "a", "b", "<axis><xyz>0 0 1</xyz></axis>") + "<link name='c'>" + mass + "</link>" +
           joint("m", "b", "c", "<axis><xyz>0 0 1</xyz><mimic joint='k'/></axis>") + end,
       "m.sdf:23:37: error: mimic: joint 'k' closes a loop and can't lead another"},
      {head + end, "m.sdf:2:1: error: there is no <link> in it; for example <link name=\"base\">"},
      {"<sdf version='1.9'/>",
       "m.sdf:1:1: error: the file has no <model> and no <world>; for example <model name=\"arm\">, with its links"},
      {"<sdf version='1.9'><model name='a'/>\n<model name='b'/></sdf>",
       "m.sdf:2:1: error: a second <model> in addition to that on line 1; put models into one <world>"},
      {"<sdf version='1.9'><world><model name='a'><static>1</static>" + a_link("a") + "</model>\n<model name='b'>" + a_link("b") +
           "</model>\n" + joint("j", "b::b", "a::a") + "</world></sdf>",
       "m.sdf:7:8: error: child: 'a::a' belongs to a static model, and the joint would carry it; swap parent and child, or make "
       "the model non-static"},
  });
}

TEST_CASE("SDF: more loops than memory could hold are refused") {
  std::string many = head, longer = head;
  for (int i = 0; i < 20'000; ++i) {
    const std::string name = std::to_string(i);
    many += a_link("l" + name);
    longer += a_link("l" + name);
    if (i == 0) continue;
    many += joint("j" + name, "l" + std::to_string(i - 1), "l" + name) + joint("k" + name, "l0", "l" + name);
    longer += joint("j" + name, "l" + std::to_string(i - 1), "l" + name);
  }
  for (int i = 0; i < 1000; ++i) longer += joint("k" + std::to_string(i), "l" + std::to_string(19'000 + i), "l0");
  CHECK(
      errors_of(many + end, "m.sdf") ==
      "m.sdf:11005:1: error: a scenario has loops of at most 5000 equations in total; they are solved together, which would need "
      "too much memory");
  CHECK(errors_of(longer + end, "m.sdf").find("error: the loops are too long: their equations concern too many bodies; they") !=
        std::string::npos);
}

TEST_CASE("SDF: invalid names are refused") {
  check({
      {head + "<link>" + mass + "</link>" + end, "m.sdf:3:1: error: <link> has no 'name'; for example name=\"upper_arm\""},
      {head + a_link("") + end, "m.sdf:3:13: error: name: a link cannot be named '': it is empty"},
      {head + a_link("a/b") + end,
       "m.sdf:3:13: error: name: a link cannot be named 'a/b': it has a character that is not allowed; a name has no / , \" * "
       "and no control characters"},
      {head + a_link("world") + end, "m.sdf:3:13: error: name: a link cannot be named 'world': the format reserves that name"},
      {head + a_link("__model__") + end,
       "m.sdf:3:13: error: name: a link cannot be named '__model__': the format reserves that name"},
      {head + a_link("a::b") + end,
       "m.sdf:3:13: error: name: a link cannot be named 'a::b': '::' separates the names of a model and its parts"},
      {head + "<link nmae='a'>" + mass + "</link>" + end,
       "m.sdf:3:1: error: <link> has no 'name'; for example name=\"upper_arm\"\nm.sdf:3:7: error: unknown attribute 'nmae' of "
       "<link>; did you mean 'name'?"},
      {"<sdf version='1.9'><model>" + a_link("a") + end,
       "m.sdf:1:20: error: <model> has no 'name'; for example name=\"upper_arm\""},
  });
}

TEST_CASE("SDF: frames that are not attached are refused") {
  check({
      {head + a_link("a", "<pose relative_to='b'/>") + end,
       "m.sdf:3:125: error: pose: there is no link, joint, frame or model 'b' here"},
      {head + a_link("a", "<pose relative_to='world'/>") + end,
       "m.sdf:3:125: error: pose: there is no link, joint, frame or model 'world' here; within a model only a joint's parent can "
       "be the world"},
      {head + a_link("a", "<pose relative_to='b'/>") + a_link("b", "<pose relative_to='a'/>") + end,
       "m.sdf:3:13: error: frames form a cycle: 'a' relative to 'b' relative to 'a'; one of them must lead to the model"},
      {head + a_link("a", "<pose relative_to='a'/>") + end,
       "m.sdf:3:13: error: frames form a cycle: 'a' relative to 'a'; one of them must lead to the model"},
      {head + a_link("a") + "<frame name='f' attached_to='g'/>\n<frame name='g' attached_to='f'/>" + end,
       "m.sdf:4:14: error: frames form a cycle: 'f' attached to 'g' attached to 'f'; one of them must lead to the model"},
      {head + a_link("a") + "<frame name='f' attached_to='b'/>" + end,
       "m.sdf:4:30: error: attached_to: there is no link, joint, frame or model 'b' here"},
      {head + a_link("a") + "<frame name='a'/>" + end,
       "m.sdf:4:14: error: duplicate frame 'a': the name is already used by the <link> on line 3"},
      {"<sdf version='1.9'><model name='m' placement_frame='b' canonical_link='c'>" + a_link("a") + end,
       "m.sdf:1:72: error: canonical_link: there is no link, joint, frame or model 'c' here"},
      {head + a_link("a", "<pose frame='b'/>") + end,
       "m.sdf:3:119: error: pose: 'frame' is 'relative_to' in SDF 1.9; write relative_to=…"},
      {"<sdf version='1.6'><model name='m'>" + a_link("a", "<pose relative_to='b'/>") + end,
       "m.sdf:1:160: error: pose: 'relative_to' is 'frame' in SDF 1.6; write frame=…"},
  });
}

TEST_CASE("SDF: files that are not SDF, or of an unsupported version, are refused") {
  check({
      {"", "m.sdf:1:1: error: the file is empty: there is no element in it"},
      {"<sfd/>", "m.sdf:1:1: error: no model begins with '<sfd>'; did you mean <sdf>?"},
      {head + a_link("a"), "m.sdf:4:1: error: the file ends within <model>, opened on line 2; is it complete?"},
      {head + a_link("a") + end + "\n<sdf/>",
       "m.sdf:5:1: error: something follows the end of the document; a file holds one root element"},
      {head + "\xff" + end, "m.sdf:3:1: error: the text is not UTF-8; save the file with the encoding UTF-8"},
      {"<!DOCTYPE sdf [<!ENTITY a SYSTEM 'file:///etc/passwd'>]>\n" + head + a_link("&a;") + end,
       "m.sdf:1:1: error: a document type (<!DOCTYPE …>) is not supported: no entity is declared, expanded or fetched; leave it "
       "out: "
       "a model needs none"},
      {"<sdf></sdf>",
       "m.sdf:1:1: error: <sdf> has no 'version'; versions 1.4 to 1.10 are read, for example version=\"1.9\"\nm.sdf:1:1: error: "
       "the file has no <model> and no <world>; for example <model name=\"arm\">, with its links"},
      {"<sdf version='1.3'><model name='m'>" + a_link("a") + end,
       "m.sdf:1:15: error: version: SDF 1.3 is too old: versions 1.4 to 1.10 are read; gz sdf -p writes a newer one"},
      {"<sdf version='2'><model name='m'>" + a_link("a") + end,
       "m.sdf:1:15: error: version: expected a version of SDF, found '2'; versions 1.4 to 1.10 are read"},
      {"<sdf version='x'><model name='m'>" + a_link("a") + end,
       "m.sdf:1:15: error: version: expected a version of SDF, found 'x'; versions 1.4 to 1.10 are read"},
      {"<sdf version='1.99999999999'><model name='m'>" + a_link("a") + end,
       "m.sdf:1:15: error: version: expected a version of SDF, found '1.99999999999'; versions 1.4 to 1.10 are read"},
  });
}

TEST_CASE("SDF: meshes elsewhere are not opened, with a note") {
  for (const char* uri :
       {"/etc/passwd", "/dev/zero", "../../secret.stl", "file:///dev/stdin", "model://r/../../x.stl", "..\\x.stl"}) {
    const ReadResult result = read_scenario_text(mesh(uri), "m.sdf");
    REQUIRE(result.scenario);
    CHECK(said(result, Severity::note) ==
          "m.sdf:3:144: note: a mesh is not in the model's folder or below it: pictures leave it out; the motion does not "
          "depend on it");
  }
  check({{mesh(""), "m.sdf:3:139: error: a mesh has no file name"}});
}

TEST_CASE("SDF: all problems of a file are reported at once, up to a readable number") {
  std::string text = head;
  for (int i = 0; i < 1000; ++i) text += "<link name='a'><inertial><mass>x" + std::to_string(i) + "</mass></inertial></link>\n";
  const ReadResult result = read_scenario_text(text + end, "m.sdf");
  CHECK(!result.scenario);
  CHECK(result.diagnostics.size() == 102);  // one of them a warning
  CHECK(said(result, Severity::error).ends_with("m.sdf: error: and 1 or more further errors"));
}

TEST_CASE("SDF: endlessly nested models are refused") {
  std::string open, close;
  for (int k = 0; k < 150; ++k) open += "<model name='m'>\n", close += "</model>";
  CHECK(errors_of("<sdf version='1.9'>" + open + a_link("a") + close + "</sdf>", "m.sdf") ==
        "m.sdf:102:1: error: models are nested more than 100 deep; no mechanism needs that");
}

TEST_CASE("SDF: a chain of 100,000 links in each other's frames is read in linear time, and so are its errors") {
  const auto chain = [](int links, const std::string& first) {
    std::string text = head;
    for (int k = 0; k < links; ++k) {
      const std::string n = std::to_string(k), before = std::to_string(k - 1);
      text += a_link("l" + n, k == 0 ? first : "<pose relative_to='j" + n + "'/>");
      if (k > 0)
        text += "<joint name='j" + n + "' type='continuous'><pose relative_to='l" + before + "'>1 0 0 0 0 0</pose><parent>l" +
                before + "</parent><child>l" + n + "</child>" + axis + "</joint>\n";
    }
    return text + end;
  };
  const ReadResult result = read_scenario_text(chain(100'000, ""), "m.sdf");
  REQUIRE(result.scenario);
  CHECK(result.scenario->model.size() == 100'000);
  CHECK(result.scenario->model[{99'999}].at.position == momentree::Vec3{1, 0, 0});
  const std::string circle = errors_of(chain(100'000, "<pose relative_to='l99999'/>"), "m.sdf");
  CHECK(circle.find("frames form a cycle: 'l0' relative to 'l99999' relative to 'j99999' relative to") != std::string::npos);
}
