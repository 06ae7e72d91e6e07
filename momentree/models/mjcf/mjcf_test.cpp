#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

// The results for valid models are compared with MuJoCo itself, in tests/cross.
std::string mujoco(const std::string& bodies, const std::string& before = "", const std::string& after = "") {
  return "<mujoco model='m'>" + before + "\n<worldbody>\n" + bodies + "\n</worldbody>\n" + after + "</mujoco>";
}
std::string errors(const std::string& text) { return errors_of(text, "m.xml"); }
const std::string geom = "<geom size='1'/>";

}  // namespace

TEST_CASE("MJCF: a body with several joints gets massless carriers, a joint without a name that of its body") {
  const Model model = model_of(mujoco("<body name='a'>" + geom +
                                      "<joint name='x' axis='1 0 0'/><joint name='y' axis='0 1 0'/><joint axis='0 0 1'/>"
                                      "<body>" +
                                      geom + "<joint/></body></body>"),
                               "m.xml");
  REQUIRE(model.size() == 4);
  CHECK(model[{0}].name == "m/a.x");
  CHECK(model[{0}].joint_name == "m/x");
  CHECK(model[{0}].mass == 0);
  CHECK(model[{1}].name == "m/a.y");
  CHECK(model[{2}].name == "m/a");
  CHECK(model[{2}].joint_name == "m/a");
  CHECK(model[{3}].name == "m/body1");
  CHECK(model[{3}].parent == BodyId{2});
}

TEST_CASE("MJCF: gravity and title of the file, several roots, limits on request") {
  const std::string text = mujoco("<body name='a'>" + geom + "<joint name='j' range='-90 45'/></body><body name='b'>" + geom +
                                      "<freejoint/></body>"
                                      "<body name='c' pos='0 0 1'>" +
                                      geom + "</body>",
                                  "<option gravity='0 0 -1'/>");
  const ReadResult result = read_scenario_text(text, "m.xml", {"mechanism.m.limits=true"});
  REQUIRE(result.scenario);
  const Model& model = result.scenario->model;
  CHECK(result.scenario->title == "m");
  CHECK(model.gravity() == Vec3{0, 0, -1});
  CHECK(model.mechanism_name({0}) == "m");
  CHECK(model.mechanism_name({1}) == "m/b");
  CHECK(model[{0}].joint.parameters.limits.lower[0] == doctest::Approx(-std::numbers::pi / 2));
  CHECK(model[{1}].joint.kind == Kind::free);
  CHECK(model[{2}].joint.kind == Kind::weld);
  CHECK(
      read_scenario_text(text, "m.xml", {"mechanism.m.root=free", "mechanism.m.limits=false"}).scenario->model[{2}].joint.kind ==
      Kind::free);
}

TEST_CASE("MJCF: shapes are kept, with the colour of their material") {
  const ReadResult result = read_scenario_text(
      mujoco("<body><geom type='capsule' size='.1 .2' material='red'/><geom type='box' size='1 2 3' rgba='0 1 0 1'/></body>",
             "<asset><material name='red' rgba='1 0 0 1'/></asset>"),
      "m.xml");
  REQUIRE(result.scenario);
  const Shape& shape = result.scenario->shapes[0];
  REQUIRE(shape.as<contact::Capsule>());
  CHECK(shape.as<contact::Capsule>()->length == doctest::Approx(0.4));
  CHECK(shape.colour == "#ff0000");
  REQUIRE(shape.more.size() == 1);
  CHECK(shape.more[0].primitive == contact::Primitive(contact::Box{{2, 4, 6}}));
  CHECK(shape.more[0].colour == "#00ff00");
}

TEST_CASE("MJCF: ignored elements are reported once, with their lines") {
  const ReadResult result =
      read_scenario_text(mujoco("<body name='a'>" + geom + "<joint name='j'/></body>", "",
                                "<contact><exclude body1='a' "
                                "body2='a'/></contact>\n<tendon><fixed/>\n<fixed/></tendon>\n<actuator><muscle/></actuator>\n"
                                "<equality><weld body1='a' active='false'/></equality>"),
                         "m.xml");
  REQUIRE(result.scenario);
  CHECK(said(result, Severity::note) ==
        "m.xml:6:9: note: <fixed> in <tendon> is ignored (lines 6 and 7)\n"
        "m.xml:8:11: note: <muscle> in <actuator> is ignored; an event's set = { joint, drive } drives a joint\n"
        "m.xml:9:11: note: <weld> in <equality> is left out: it is not active");
}

TEST_CASE("MJCF: impossible elements are refused with their places") {
  const auto body = [](const std::string& inside) { return errors(mujoco("<body name='a'>" + inside + "</body>")); };
  CHECK(body("<geom size='nan'/>") == "m.xml:3:28: error: size: 'nan' is not a finite number");
  CHECK(body("<geom size='-1'/>") == "m.xml:3:28: error: size: must be greater than 0");
  CHECK(body("<geom/>") == "m.xml:3:16: error: a sphere has no 'size'; half of its extent along each axis, or a radius");
  CHECK(body("<geom type='bx' size='1'/>") == "m.xml:3:28: error: unknown type of geom 'bx'; did you mean 'box'?");
  CHECK(body("<geom size='1' dnesity='3'/>") ==
        "m.xml:3:31: error: unknown attribute 'dnesity' of <geom>; did you mean 'density'?");
  CHECK(body(geom + "<joint axis='0 0 0'/>") ==
        "m.xml:3:45: error: axis: an axis of length zero has no direction; for example axis=\"0 0 1\"");
  CHECK(body(geom + "<joint type='hing'/>") == "m.xml:3:45: error: unknown type of joint 'hing'; did you mean 'hinge'?");
  CHECK(body(geom + "<joint damping='-1'/>") == "m.xml:3:48: error: damping: must not be negative");
  CHECK(body(geom + "<joint range='1 -1'/>") ==
        "m.xml:3:46: error: range: the first number is not less than the second; swap them");
  CHECK(body(geom + "<joint class='none'/>") == "m.xml:3:46: error: class: there is no default class 'none'");
  CHECK(body(geom + "<frame/>").starts_with("m.xml:3:32: error: <frame> is not supported"));
  CHECK(body("<geom type='mesh' mesh='x'/>").starts_with("m.xml:3:16: error: the inertia of this geom is not computed"));
  CHECK(body("<inertial pos='0 0 0' mass='-1'/>") == "m.xml:3:44: error: mass: must not be negative");
  CHECK(body("<inertial pos='0 0 0' mass='1' diaginertia='1 1 3'/>")
            .starts_with("m.xml:3:16: error: inertia: the largest principal"));
  CHECK(body("<joint/>").starts_with("m.xml:3:16: error: joint 'm/a': the joint-space mass is singular"));
  CHECK(body(geom + "<body name='a'>" + geom + "</body>") ==
        "m.xml:3:44: error: duplicate body 'a': the name is already used by another on line 3");
  CHECK(body(geom + "<body>" + geom + "<freejoint/></body>") ==
        "m.xml:3:54: error: only a body in <worldbody> can have a free joint");
  CHECK(errors("<mujoco/>") ==
        "m.xml:1:1: error: the model has no <body> in a <worldbody>; for example <worldbody><body><geom "
        "size=\"1\"/></body></worldbody>");
  CHECK(errors(mujoco("<body/>", "<compiler angle='grad'/>")) ==
        "m.xml:1:36: error: angle: expected one of degree, radian, found 'grad'");
  CHECK(errors(mujoco("<body/>", "<include file='../x.xml'/>")) ==
        "m.xml:1:34: error: include: '../x.xml' is not in the model's folder or below it; copy it there");
}

TEST_CASE("MJCF: included files replace their <include>, once, and messages name them") {
  const test::TemporaryFolder folder;
  write_text_file(folder / "m.xml", mujoco("<include file='arm.xml'/>", "<include file='defaults.xml'/>"));
  write_text_file(folder / "defaults.xml", "<mujocoinclude><default><geom density='10'/></default></mujocoinclude>");
  write_text_file(folder / "arm.xml", "<mujocoinclude><body name='a'><geom type='box' size='1 1 1'/></body></mujocoinclude>");
  const ReadResult result = read_scenario(folder / "m.xml");
  REQUIRE(result.scenario);
  CHECK(result.scenario->model[{0}].mass == doctest::Approx(80));
  write_text_file(folder / "arm.xml", "<mujocoinclude>\n<body name='a'><geom size='x'/></body></mujocoinclude>");
  CHECK(said(read_scenario(folder / "m.xml"), Severity::error) ==
        (folder / "arm.xml") + ":2:28: error: size: 'x' is not a number");
  write_text_file(folder / "arm.xml", "<mujocoinclude>\n<include file='m.xml'/></mujocoinclude>");
  CHECK(said(read_scenario(folder / "m.xml"), Severity::error)
            .starts_with((folder / "arm.xml") + ":2:16: error: include: 'm.xml' is included already"));
}

TEST_CASE("MJCF: bodies nested to the bound of depth") {
  std::string open, close;
  for (int k = 0; k < 900; ++k) open += "<body pos='1 0 0'><joint/><geom size='.1'/>", close += "</body>";
  CHECK(model_of(mujoco(open + close), "m.xml").size() == 900);
}
