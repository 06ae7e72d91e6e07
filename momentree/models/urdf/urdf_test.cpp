#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/model/start.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/models.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::models;

namespace {

constexpr double pi = std::numbers::pi;

std::string a_link(const std::string& name, const std::string& inside =
                                                "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' "
                                                "iyy='1' iyz='0' izz='1'/></inertial>") {
  return "<link name='" + name + "'>" + inside + "</link>\n";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& more = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" + more +
         "</joint>\n";
}
std::string robot(const std::string& inside) { return "<robot name='r'>\n" + inside + "</robot>\n"; }

void check_near(const Vec3& a, const Vec3& b) { CHECK(norm(a - b) <= 1e-15 * (1 + norm(b))); }
void check_near(const Pose& a, const Pose& b) {
  check_near(a.position, b.position);
  const Quat d = conjugate(a.rotation) * b.rotation;
  CHECK(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) < 1e-15);
}

}  // namespace

TEST_CASE("URDF: a link's mass, centre of mass and inertia, turned from its axes into the link's") {
  const Model model = model_of(robot(a_link("a",
                                            "<inertial><origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/><mass value='2'/>"
                                            "<inertia ixx='1' ixy='0.1' ixz='0.2' iyy='2' iyz='0.3' izz='2.5'/></inertial>")));
  REQUIRE(model.size() == 1);
  const BodySpec& a = model[{0}];
  CHECK(a.name == "r/a");
  CHECK(a.mass == 2);
  check_near(a.com, {1, 2, 3});
  // x of the inertia's axes is y of the link's, y is −x.
  const Sym3 expected{2, 1, 2.5, -0.1, -0.3, 0.2};
  for (auto m : {&Sym3::xx, &Sym3::yy, &Sym3::zz, &Sym3::xy, &Sym3::xz, &Sym3::yz})
    CHECK(a.inertia.*m == doctest::Approx(expected.*m).epsilon(1e-15));
  CHECK(a.joint.kind == Kind::weld);
  CHECK(a.parent == ground);
}

TEST_CASE("URDF: every type of joint, with axis, origin and dynamics") {
  const std::string origin = "<origin xyz='0.1 0.2 0.3' rpy='0.4 0.5 0.6'/>";
  const Pose placed{{0.1, 0.2, 0.3}, from_rpy(0.4, 0.5, 0.6)};
  std::string text = a_link("base");
  for (const char* name : {"a", "b", "c", "d", "e", "f", "g"}) text += a_link(name);
  text += joint("ja", "revolute", "base", "a",
                origin +
                    "<axis xyz='0 0 2'/><limit lower='-1' upper='2' effort='3' velocity='4'/>"
                    "<dynamics damping='0.5' friction='0.25'/>");
  text += joint("jb", "continuous", "a", "b", "<axis xyz='0 1 0'/>");
  text += joint("jc", "prismatic", "b", "c", "<limit upper='1' effort='1' velocity='1'/><dynamics damping='2'/>");
  text += joint("jd", "fixed", "c", "d", origin);
  text += joint("je", "floating", "d", "e", origin);
  text += joint("jf", "planar", "e", "f", origin + "<axis xyz='0 -1 0'/>");
  text += joint("jg", "planar", "f", "g", "<axis xyz='0 0 -1'/>");
  const Model model = model_of(robot(text));
  const auto of = [&](const char* name) -> const BodySpec& { return model[model.joint(std::string("r/") + name)]; };
  CHECK(of("ja").name == "r/a");
  CHECK(of("ja").joint.kind == Kind::revolute);
  check_near(of("ja").joint.axis, {0, 0, 1});
  check_near(of("ja").at, placed);
  CHECK(of("ja").joint.parameters.damping == Values(0.5));
  CHECK(of("ja").joint.parameters.friction.coulomb == Values(0.25));
  CHECK(of("ja").joint.parameters.friction.speed[0] > 0);
  CHECK(!of("ja").joint.parameters.limits.any());
  CHECK(of("jb").joint.kind == Kind::revolute);
  check_near(of("jb").joint.axis, {0, 1, 0});
  CHECK(of("jc").joint.kind == Kind::prismatic);
  check_near(of("jc").joint.axis, {1, 0, 0});  // the format's default
  CHECK(of("jc").joint.parameters.damping == Values(2));
  CHECK(of("jd").joint.kind == Kind::weld);
  check_near(of("jd").at, placed);
  CHECK(of("je").joint.kind == Kind::free);
  check_near(of("je").at, placed);
  for (const auto& [name, normal, where] : {std::tuple{"jf", Vec3{0, -1, 0}, placed}, {"jg", Vec3{0, 0, -1}, Pose{}}}) {
    const BodySpec& planar = of(name);
    CHECK(planar.joint.kind == Kind::planar);
    check_near(planar.at * inverse(planar.child_at), where);  // at its zero position the child is at the origin
    check_near(rotation_matrix(planar.child_at.rotation) * Vec3{0, 0, 1}, normal);
  }
}

TEST_CASE("URDF: parents may follow their children, trees branch, and links and joints have separate names") {
  const Model model =
      model_of(robot(joint("tip", "continuous", "middle", "tip") + a_link("tip") + joint("base", "continuous", "base", "middle") +
                     a_link("middle") + a_link("base") + joint("side", "fixed", "base", "side") + a_link("side", "")));
  REQUIRE(model.size() == 4);
  CHECK(model[model[model.body("r/tip")].parent].name == "r/middle");
  CHECK(model[model.body("r/tip")].joint_name == "r/tip");
  CHECK(model[model.body("r/middle")].joint_name == "r/base");
  CHECK(model[model.body("r/base")].joint_name == "r/base~root");  // the name is taken
  CHECK(model[model.body("r/side")].mass == 0);
}

TEST_CASE("URDF: a byte order mark, CRLF, comments, foreign namespaces and expanded templates") {
  const ReadResult result = read_scenario_text(
      "\xEF\xBB\xBF<?xml version=\"1.0\" encoding=\"utf-8\"?>\r\n<robot name=\"r\" xmlns:drake=\"http://drake.mit.edu\">\r\n"
      "<!-- ü -->\r\n<drake:joint_filter/>\r\n" +
          a_link("a") + "<link name='b'><drake:x/></link>\n" +
          joint("j", "fixed", "a", "b", "<origin drake:unit='m' xyz='\t+1e0 2\n-.5'/>") + "</robot>",
      "r.urdf");
  REQUIRE(result.scenario);
  check_near(result.scenario->model[{1}].at.position, {1, 2, -0.5});
  CHECK(said(result, Severity::warning) == "");
  CHECK(said(result, Severity::note) ==
        "r.urdf:4:1: note: <drake:joint_filter> in <robot> is ignored; it belongs to another namespace\n"
        "r.urdf:6:16: note: <drake:x> in <link> is ignored; it belongs to another namespace\n"
        "r.urdf:7:73: note: attribute 'drake:unit' of <origin> is ignored; it belongs to another namespace");
}

TEST_CASE("URDF: ignored elements are reported once, with their lines") {
  const std::string inside = "<collision/><visual><geometry><sphere radius='1'/></geometry></visual><colision/>";
  const ReadResult result = read_scenario_text(
      robot(a_link("a", inside) + a_link("b", inside) + joint("j", "fixed", "a", "b", "<dynamics D='1' K='2'/>") +
            "<transmission/>\n<gazebo/>\n<transmission/>\n<unheard/>\n"),
      "r.urdf");
  REQUIRE(result.scenario);
  CHECK(said(result, Severity::note) ==
        "r.urdf:4:75: note: unknown attribute 'D' of <dynamics> is ignored\n"
        "r.urdf:4:81: note: unknown attribute 'K' of <dynamics> is ignored\n"
        "r.urdf:5:1: note: <transmission> is ignored (lines 5 and 7); efforts act on joints directly\n"
        "r.urdf:6:1: note: <gazebo> is ignored; it belongs to another program\n"
        "r.urdf:8:1: note: <unheard> in <robot> is ignored");
  CHECK(said(result, Severity::warning) ==
        "r.urdf:2:86: warning: <colision> in <link> is ignored (lines 2 and 3); did you mean <collision>?");
}

TEST_CASE("URDF: legal but unusual input is a warning") {
  const std::string moving = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='2.01'/></inertial>";
  const ReadResult result = read_scenario_text(
      robot(a_link("a") + a_link("b", "") + a_link("c", moving) + a_link("d", "<inertial><mass value='1'/></inertial>") +
            joint("ab", "revolute", "a", "b", "<axis xyz='0 0 3'/><limit lower='0' upper='0' effort='0' velocity='1'/>") +
            joint("bc", "revolute", "b", "c", "<axis xyz='0 1 0'/>") + joint("cd", "fixed", "c", "d")),
      "r.urdf");
  REQUIRE(result.scenario);
  CHECK(said(result, Severity::warning) ==
        "r.urdf:3:1: warning: 'b' moves and carries other bodies, but has no mass; is its inertia missing?\n"
        "r.urdf:4:16: warning: inertia: the largest principal moment is slightly more than the sum of the others ('c'); "
        "rounded values? give more digits\n"
        "r.urdf:5:16: warning: <inertial> has no <inertia>: all the mass is at one point; give ixx, iyy and izz\n"
        "r.urdf:6:88: warning: the limits of this joint are equal: it could not move; they are ignored; use type=\"fixed\" for a "
        "joint that does not move\n"
        "r.urdf:7:1: warning: a revolute joint without <limit>: it is not limited; use type=\"continuous\" for that");
  CHECK(said(result, Severity::note) ==
        "r.urdf:6:80: note: the length of an axis is not 1: only its direction is used\n"
        "r.urdf:6:123: note: an effort limit of 0: nothing could drive this joint; efforts are not limited here");
}

TEST_CASE("URDF: the axis of a joint without one does not matter") {
  for (const char* axis : {"<axis xyz='0 0 0'/>", "<axis xyz='nan'/>", "<axis/>", "<axis xyz='0 0 2'/>"})
    for (const char* type : {"fixed", "floating"}) {
      const ReadResult result =
          read_scenario_text(robot(a_link("a") + a_link("b") + joint("ab", type, "a", "b", axis)), "r.urdf");
      REQUIRE(result.scenario);
      CHECK(result.diagnostics.empty());
    }
}

TEST_CASE("URDF: an impossible inertia of the size of round-off counts as zero") {
  const auto inertial = [](const std::string& xx) {
    return "<inertial><mass value='2'/><inertia ixx='" + xx + "' iyy='0' izz='0'/></inertial>";
  };
  const ReadResult result = read_scenario_text(
      robot(a_link("a", inertial("-5e-20")) + a_link("b", inertial("4e-18")) + joint("ab", "fixed", "a", "b")), "r.urdf");
  REQUIRE(result.scenario);
  CHECK(result.scenario->model[{1}].inertia.xx == 0);
  CHECK(said(result, Severity::warning) ==
        "r.urdf:2:43: warning: an inertia that no body has, of the size of round-off, counts as zero (lines 2 and 3); all the "
        "mass is at one point: is the inertia missing?");
  CHECK(errors_of(robot(a_link("a", inertial("-1e-9")))).find("no body has a negative principal moment") != std::string::npos);
}

TEST_CASE("URDF: names that paths cannot contain are changed everywhere, with a warning") {
  const ReadResult result = read_scenario_text(
      robot(a_link("ground") + a_link("foot/left") + a_link("c") + joint("j/1", "continuous", "ground", "foot/left") +
            joint("j\"*,2", "continuous", "foot/left", "c", "<mimic joint='j/1'/>")),
      "r.urdf", {"mechanism.r.mimic=exact", "mechanism.r.state.joints.j_1=0.5"});
  CAPTURE(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  const Model& model = result.scenario->model;
  CHECK(model[model[model.body("r/foot_left")].parent].name == "r/ground_");
  CHECK(World(model).joint(model.joint("r/j___2")).q[0] == 0.5);
  CHECK(said(result, Severity::warning) ==
        "r.urdf:2:13: warning: 'ground' means the ground here: it is renamed 'ground_'\n"
        "r.urdf:3:13: warning: a name with / , \" or * cannot be part of a path: they become _ here (lines 3, 5 and 6); use the "
        "new "
        "name in scenarios");
}

TEST_CASE("URDF: limits that have no effect are reported") {
  const std::string moving = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";
  const ReadResult result =
      read_scenario_text(robot(a_link("a") + a_link("b", moving) + a_link("c", moving) +
                               joint("ab", "revolute", "a", "b", "<limit effort='1' velocity='1'/>") +
                               joint("bc", "continuous", "b", "c", "<limit lower='-1' upper='1' effort='1' velocity='1'/>")),
                         "r.urdf");
  REQUIRE(result.scenario);
  CHECK(said(result, Severity::warning)
            .find("a revolute joint whose <limit> has neither 'lower' nor 'upper': it is not limited; "
                  "use type=\"continuous\" for that") != std::string::npos);
  CHECK(said(result, Severity::note)
            .find("the limits of a continuous joint are not used: it turns without end; use "
                  "type=\"revolute\" for a joint with limits") != std::string::npos);
}

TEST_CASE("URDF: a joint that should follow one that cannot be coupled says so") {
  const ReadResult result =
      read_scenario_text(robot(a_link("a") + a_link("b") + a_link("c") +
                               joint("knee", "continuous", "a", "b", "<mimic joint='hip'/>") + joint("hip", "fixed", "a", "c")),
                         "r.urdf");
  CHECK(said(result, Severity::warning)
            .find("joint 'knee' should follow 'hip', but joints without one degree of freedom can't be "
                  "coupled; let it follow a joint that moves, or leave out the <mimic>") != std::string::npos);
}

TEST_CASE("URDF: a joint that should follow one that does not exist moves independently") {
  const ReadResult result = read_scenario_text(
      robot(a_link("a") + a_link("b") + joint("knee", "continuous", "a", "b", "<mimic joint='kne'/>")), "r.urdf");
  REQUIRE(result.scenario);
  CHECK(said(result, Severity::warning) ==
        "r.urdf:4:87: warning: mimic: there is no joint 'kne': joint 'knee' moves independently; did you mean 'knee'?");
}

TEST_CASE("URDF: visuals are kept, with their colours; meshes may be missing, but not outside the folder") {
  const std::string text = robot(
      "<material name='steel'><color rgba='0.5 0.5 0.5 1'/></material>" +
      a_link(
          "a",
          "<visual name='v'><origin xyz='1 0 0'/><geometry><box size='1 2 3'/></geometry><material name='steel'/></visual>"
          "<visual><geometry><cylinder radius='0.5' length='2'/></geometry><material name='x'><color rgba='1 0 0 1'/></material>"
          "</visual><visual><geometry><mesh filename='package://r/meshes/a.stl' scale='2 2 2'/></geometry></visual>"
          "<visual><geometry><mesh filename='b.stl'/></geometry></visual>"));
  const test::TemporaryFolder folder;
  write_text_file(folder / "r.urdf", text);
  write_text_file(folder / "b.stl", "");
  const ReadResult result = read_scenario(folder / "r.urdf");
  REQUIRE(result.scenario);
  const Shape& first = result.scenario->shapes[0];
  CHECK(first.primitive == contact::Primitive(contact::Box{{1, 2, 3}}));
  CHECK(first.at.position == Vec3{1, 0, 0});
  CHECK(first.colour == "#808080");
  REQUIRE(first.more.size() == 3);
  CHECK(first.more[0].as<contact::Cylinder>());
  CHECK(first.more[0].colour == "#ff0000");
  CHECK(first.more[1].mesh == "r/meshes/a.stl");
  CHECK(first.more[1].scale == Vec3{2, 2, 2});
  CHECK(first.more[2].mesh == "b.stl");
  const std::string noted = said(result, Severity::note);
  CAPTURE(noted);
  CHECK(noted.ends_with(
      "r.urdf:2:350: note: a mesh is not in the model's folder: pictures leave it out; the motion does not depend on it"));
}

TEST_CASE("a mechanism of a scenario places, attaches and initialises a model, and uses its limits") {
  const test::TemporaryFolder folder;
  write_text_file(folder / "arm.urdf", robot(a_link("base") + a_link("a") + a_link("b") +
                                             joint("shoulder", "revolute", "base", "a",
                                                   "<origin xyz='0 0 1'/><limit lower='-1' upper='2' effort='1' velocity='1'/>") +
                                             joint("elbow", "continuous", "a", "b", "<origin xyz='1 0 0'/>")));
  const auto read = [&](const std::string& more) {
    write_text_file(folder / "s.toml", "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"arm.urdf\"\n" + more);
    ReadResult result = read_scenario(folder / "s.toml");
    CAPTURE(rendered(result.diagnostics));
    return result;
  };
  SUBCASE("fixed") {
    const ReadResult result = read(
        "pose = { xyz = [1, 2, 3] }\nstate = { joints = { elbow = \"30 deg\", shoulder = { q = [0.5], v = [2] } } }\n"
        "limits = true\n");
    REQUIRE(result.scenario);
    CHECK(result.diagnostics.empty());
    const Model& model = result.scenario->model;
    CHECK(model[model.body("m/base")].at.position == Vec3{1, 2, 3});
    CHECK(model[model.joint("m/elbow")].q[0] == doctest::Approx(pi / 6).epsilon(1e-15));
    CHECK(model[model.joint("m/shoulder")].v[0] == 2);
    CHECK(model[model.joint("m/shoulder")].joint.parameters.limits.upper == Values(2));
    CHECK(!model[model.joint("m/elbow")].joint.parameters.limits.any());
  }
  SUBCASE("free") {
    const ReadResult result = read(
        "root = \"free\"\npose = { xyz = [1, 2, 3], rpy = [0, 0, \"90 deg\"] }\n"
        "state = { velocity = { linear = [1, 2, 3], angular = [4, 5, 6] } }\nlimits = false\n");
    REQUIRE(result.scenario);
    CHECK(result.diagnostics.empty());
    const World world(result.scenario->model);
    const BodyMotion& base = world.motions()[static_cast<std::size_t>(world.model().body("m/base").index)];
    check_near(base.pose, {{1, 2, 3}, from_rpy(0, 0, pi / 2)});
    check_near(base.linear, {-2, 1, 3});
    check_near(base.angular, {-5, 4, 6});
    CHECK(world.tree().nv() == 8);
  }
  SUBCASE("a start that nobody chose is moved to the nearest limit") {
    write_text_file(folder / "arm.urdf",
                    robot(a_link("base") + a_link("a") + a_link("b") +
                          joint("shoulder", "revolute", "base", "a", "<limit lower='-2' upper='-1' effort='1' velocity='1'/>") +
                          joint("elbow", "revolute", "a", "b", "<limit lower='0.5' upper='2' effort='1' velocity='1'/>")));
    const auto start_of = [](const ReadResult& result, const char* name) {
      REQUIRE(result.scenario);
      return start_coordinates(result.scenario->model[result.scenario->model.joint(name)]);
    };
    const std::string warning =
        "s.toml:5:10: warning: limits: the model rests outside its limits; joints that no loop or coupling moves start at the "
        "nearest limit: ";
    const auto warned = [&](const ReadResult& result, const std::string& joints) {
      return said(result, Severity::warning) ==
             folder / "" + warning + joints + "; choose another start in state = { joints = { … } } or [mechanism.joint.NAME]";
    };
    ReadResult result = read("limits = true\n");
    CHECK(start_of(result, "m/shoulder") == Values(-1));
    CHECK(start_of(result, "m/elbow") == Values(0.5));
    CHECK(warned(result, "'shoulder' at -1 instead of 0, 'elbow' at 0.5 instead of 0"));
    result = read("limits = true\nstate = { joints = { shoulder = { v = [1] }, elbow = 1 } }\n");
    CHECK(start_of(result, "m/shoulder") == Values(-1));
    CHECK(start_of(result, "m/elbow") == Values(1));
    CHECK(warned(result, "'shoulder' at -1 instead of 0"));
    for (const char* given : {"state = { joints = { shoulder = 0, elbow = 1 } }\n", "[mechanism.joint.shoulder]\nq = 0\n",
                              "[mechanism.joint.\"s*\"]\nq = 0\n"}) {
      result = read("limits = true\n" + std::string(given));
      CHECK(!result.scenario);
      CHECK(said(result, Severity::error).find("joint 'shoulder' starts at 0, beyond its limits of -2 and -1") !=
            std::string::npos);
    }
    CHECK(start_of(read("limits = false\n"), "m/shoulder").any() == false);
  }
  SUBCASE("twice in one world") {
    const ReadResult result = read(
        "limits = false\n[[mechanism]]\nname = \"n\"\nmodel = \"arm.urdf\"\nlimits = false\n"
        "[[event]]\nat = 1\nbreak = \"n/elbow\"\n");
    REQUIRE(result.scenario);
    CHECK(result.scenario->model.size() == 6);
    CHECK(result.scenario->events.size() == 1);
  }
  SUBCASE("what does not fit is said where the scenario says it") {
    const auto says = [&](const std::string& more, const std::string& words) {
      const ReadResult result = read(more);
      CAPTURE(rendered(result.diagnostics));
      CHECK(rendered(result.diagnostics).find(words) != std::string::npos);
    };
    says("", "s.toml:4:9: warning: the limits of 1 joint are not used; write limits = true or limits = false");
    says("limits = true\nstate = { joints = { shoulder = -1.5 } }\n",
         "s.toml:5:10: error: limits: joint 'shoulder' starts at -1.5, beyond its limits of -1 and 2");
    says("state = { joints = { elbw = 1 } }\n",
         "s.toml:5:29: error: state: there is no joint 'elbw' in this model; did you mean 'elbow'?");
    says("state = { velocity = { linear = [1, 0, 0] } }\n", "velocity: the root body is not free");
    says("[mechanism.chain]\nlinks = 1\nlength = 1\nmass = 1\n", "only one of them");
    says("[[event]]\nat = 1\nbreak = \"m/elbw\"\n", "did you mean 'm/elbow'?");
  }
}

TEST_CASE("missing model files, and other things than files, are refused where they are named") {
  const test::TemporaryFolder folder;
  const auto says = [&](const std::string& model, const std::string& words) {
    write_text_file(folder / "s.toml",
                    "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"" + model + "\"\n[[event]]\nat = 1\nbreak = \"m/x\"\n");
    const ReadResult result = read_scenario(folder / "s.toml");
    CHECK(!result.scenario);
    CAPTURE(rendered(result.diagnostics));
    CHECK(said(result, Severity::error).find("s.toml:4:9: error: model: " + words) != std::string::npos);
  };
  says("none.urdf", "'" + (folder / "none.urdf") + "': there is no such file");
  says(".", "'" + (folder / ".") + "': is a folder");
  says("/dev/zero", "'/dev/zero': is not a regular file");
  says("", "expected the name of a file");
}

TEST_CASE("URDF: a chain of 100,000 links is read in linear time") {
  const auto chain = [](int links) {
    std::string text = "<robot name='chain'>\n";
    for (int k = 0; k < links; ++k) {
      const std::string n = std::to_string(k);
      text += "<link name='l" + n +
              "'><inertial><origin xyz='0.5 0 0'/><mass value='1'/><inertia ixx='0' ixy='0' ixz='0' iyy='0.1' "
              "iyz='0' izz='0.1'/></inertial></link>\n";
      if (k > 0)
        text += "<joint name='j" + n + "' type='continuous'><parent link='l" + std::to_string(k - 1) + "'/><child link='l" + n +
                "'/><origin xyz='1 0 0'/><axis xyz='0 0 1'/></joint>\n";
    }
    return text + "</robot>\n";
  };
  const ReadResult result = read_scenario_text(chain(100'000), "chain.urdf");
  REQUIRE(result.scenario);
  CHECK(result.scenario->model.size() == 100'000);
}
