// Meshes and collision elements of model files as colliders.
#include <cmath>
#include <filesystem>

#include <doctest/doctest.h>

#include <momentree/models/mesh/source.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/read/collider_shapes.hpp>
#include <momentree/scenario/read/mesh_test_support.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/bad_input.hpp>
#include <tests/error_of.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;
using namespace momentree::io::test;

namespace {

std::string revolute(const std::string& parent, const std::string& child, const std::string& at) {
  return "<joint name='to_" + child + "' type='continuous'><parent link='" + parent + "'/><child link='" + child +
         "'/><origin xyz='" + at + "'/><axis xyz='0 1 0'/></joint>\n";
}

// An arm of three links, whose first and last overlap, and a ball far out.
std::string arm() {
  const std::string ball = collision("<sphere radius='0.3'/>");
  return "<robot name='arm'>\n" + link("base", ball) + link("mid", ball) + link("end", ball) +
         link("out", collision("<cylinder radius='0.1' length='0.5'/>")) + revolute("base", "mid", "0 0 0.2") +
         revolute("mid", "end", "0 0 0.2") + revolute("end", "out", "3 0 0") + "</robot>\n";
}

}  // namespace

TEST_CASE("colliders: a mesh touches with its hull") {
  test::TemporaryFolder folder;
  write(folder / "box.obj", box_mesh({0.5, 0.25, 0.1}));
  write(folder / "s.toml", a_floor + a_mesh_above + "collision = { mesh = \"box.obj\", scale = [1, 2, 1] }\n");
  const ReadResult result = read_scenario(folder / "s.toml");
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  CHECK(warnings(result) == "");
  const Model& model = result.scenario->model;
  REQUIRE(model.colliders().size() == 2);
  CHECK(model.colliders()[1].solid.vertices.size() == 8);
  CHECK(contact::volume(model.colliders()[1].solid) == doctest::Approx(1 * 1 * 0.2));
  Simulation sim(model, {.step = 1e-2});
  REQUIRE(sim.run_until(1));
  CHECK(std::fabs(sim.world().motions()[0].pose.position.z - 0.1) < 1e-11);
}

TEST_CASE("colliders: meshes that are flat, not convex or have many corners are named") {
  test::TemporaryFolder folder;
  const auto read = [&](const std::string& mesh) {
    write(folder / "m.obj", mesh);
    write(folder / "s.toml", a_floor + a_mesh_above + "collision = { mesh = \"m.obj\" }\n");
    return read_scenario(folder / "s.toml");
  };
  const ReadResult flat = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n");
  CHECK(!flat.scenario);
  CHECK(said(flat).find(": error: collision: the mesh 'm.obj' is flat; a collider has a volume: use a thin box") !=
        std::string::npos);
  // Two boxes, apart from each other.
  std::string two = box_mesh({0.1, 0.1, 0.1});
  for (int i = 0; i < 8; ++i)
    two += "v " + std::to_string((i & 1) != 0 ? 1.1 : 0.9) + " " + std::to_string((i & 2) != 0 ? 0.1 : -0.1) + " " +
           std::to_string((i & 4) != 0 ? 0.1 : -0.1) + "\n";
  two += "f 17 19 20 18\nf 21 22 24 23\nf 17 18 22 21\nf 19 23 24 20\nf 17 21 23 19\nf 18 20 24 22\n";
  const ReadResult concave = read(two);
  REQUIRE(concave.scenario);
  CHECK(warnings(concave).find("is not convex: its hull touches, of which it fills 33 %") != std::string::npos);
  // A box without its top, and a tube: areas of a tube's openings cancel.
  const std::string box = box_mesh({0.1, 0.1, 0.1});
  const std::size_t last = box.rfind("f "), before = box.rfind("f ", last - 1);
  const std::string lidless = box.substr(0, last), tube = box.substr(0, before);
  for (const std::string& open : {lidless, tube}) {
    const ReadResult result = read(open);
    REQUIRE(result.scenario);
    CHECK(warnings(result).find("is not closed: its hull touches; close it, or let boxes") != std::string::npos);
  }
  CHECK(warnings(read(box)) == "");
  std::string round;
  for (int i = 0; i < 500; ++i) {
    const double z = -1 + i / 250.0, r = std::sqrt(1 - z * z);
    round += "v " + std::to_string(r * std::cos(2.4 * i)) + " " + std::to_string(r * std::sin(2.4 * i)) + " " +
             std::to_string(z) + "\n";
  }
  for (int i = 1; i < 499; ++i)
    round += "f " + std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + 2) + "\n";
  const ReadResult many = read(round);
  CHECK(said(many).find("many corners: 64 of them touch") != std::string::npos);
}

TEST_CASE("colliders: collision elements of a model count where there is something to touch") {
  test::TemporaryFolder folder;
  write(folder / "arm.urdf", arm());
  const std::string mechanism = "[[mechanism]]\nname = \"arm\"\nmodel = \"arm.urdf\"\npose = { xyz = [0, 0, 2] }\n";
  const auto read = [&](const std::string& text) {
    write(folder / "s.toml", text);
    ReadResult result = read_scenario(folder / "s.toml");
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    return result;
  };
  CHECK(read("format = 1\n" + mechanism).scenario->model.colliders().empty());
  CHECK(read(a_floor + mechanism + "collision = \"none\"\n").scenario->model.colliders().size() == 1);
  CHECK(read("format = 1\n" + mechanism + "collision = \"file\"\n").scenario->model.colliders().size() == 4);
  const ReadResult on_floor = read(a_floor + mechanism);
  const Model& model = on_floor.scenario->model;
  REQUIRE(model.colliders().size() == 5);
  CHECK(model.colliders()[4].solid.rim == 0.1);
  const BodyId base = model.body("arm/base"), mid = model.body("arm/mid"), end = model.body("arm/end"),
               out = model.body("arm/out");
  World world(model);
  const auto pass = [&](BodyId one, BodyId other) { return world.gap(one, other)->passes; };
  CHECK(pass(base, ground));  // welded to it
  CHECK(!pass(mid, ground));
  CHECK(pass(base, mid));
  CHECK(pass(base, end));  // they overlap at the start
  CHECK(!pass(base, out));
  CHECK(!model.contact_law(base, ground).off);  // once what connects them has broken
  CHECK(!model.contact_law(base, mid).off);
  CHECK(warnings(on_floor).find("'arm/base' and 'arm/end'") != std::string::npos);
  CHECK(rendered(to_toml(*on_floor.scenario, folder / ".").diagnostics)
            .find("warning: 4 collision elements of model files left out; their bodies no longer touch anything") !=
        std::string::npos);
}

TEST_CASE("colliders: convert keeps the meshes that bodies and links have, in a folder from which they can be named") {
  test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "a/meshes");
  std::filesystem::create_directories(folder / "b");
  write(folder / "a/meshes/box.obj", box_mesh({0.5, 0.3, 0.2}));
  const std::string chain =
      "[[mechanism]]\nname = \"c\"\npose = { xyz = [9, 0, 5] }\n[mechanism.chain]\nlinks = 2\nlength = 1\n"
      "mass = 1\nshape = [{ box = [1, 1, 1] }, { mesh = \"meshes/box.obj\" }]\n";
  const auto read = [&](const std::string& file) {
    ReadResult result = read_scenario(file);
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    return *result.scenario;
  };
  for (const char* touching :
       {"collision = { mesh = \"meshes/box.obj\" }\n", "collision = [{ mesh = \"meshes/box.obj\" }, { sphere = 0.1 }]\n",
        "shape = { mesh = \"meshes/box.obj\" }\ncollision = \"shape\"\n"}) {
    CAPTURE(touching);
    write(folder / "a/s.toml", a_floor + a_mesh_above + touching + chain);
    const Scenario scenario = read(folder / "a/s.toml");
    for (const char* to : {"a", "."}) {
      CAPTURE(to);
      const Converted converted = to_toml(scenario, folder / to);
      CHECK(converted.diagnostics.empty());
      const std::string file = folder / to + "/written.toml";
      write(file, converted.text);
      const Scenario again = read(file);
      REQUIRE(again.model.colliders().size() == scenario.model.colliders().size());
      for (std::size_t i = 0; i < again.model.colliders().size(); ++i)
        CHECK(again.model.colliders()[i].solid == scenario.model.colliders()[i].solid);
      for (const Shape& shape : {again.shapes[1], again.shapes[2]}) {
        REQUIRE(shape.more.size() == 1);
        REQUIRE(shape.more[0].source);
        CHECK(std::filesystem::equivalent(shape.more[0].source->path, std::string(folder / "a/meshes/box.obj")));
      }
    }
    CHECK(error_of([&] {
            (void)to_toml(scenario, folder / "b");
          }).find("with the mesh 'meshes/box.obj', which is not in the folder of the output file or below it") !=
          std::string::npos);
  }
  write(folder / "a/s.toml", "format = 1\n" + chain);
  const Converted without = to_toml(read(folder / "a/s.toml"), folder / "b");
  CHECK(without.text.find("box.obj") == std::string::npos);
  CHECK(without.text.find("shape  = [{ box = [1, 1, 1] }]") != std::string::npos);
  CHECK(rendered(without.diagnostics).find("1 mesh is left out") != std::string::npos);
}

TEST_CASE("colliders: friction and exclusions of SDF and MJCF files") {
  test::TemporaryFolder folder;
  const auto link_of = [](const std::string& name, const std::string& mu, const std::string& z) {
    return "<link name='" + name + "'><pose>0 0 " + z +
           " 0 0 0</pose><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
           "<collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry><surface><friction><ode><mu>" +
           mu + "</mu></ode></friction></surface></collision></link>";
  };
  write(folder / "m.sdf",
        "<sdf version='1.7'><model name='m'>" + link_of("a", "0.3", "1") + link_of("b", "0.7", "2") + "</model></sdf>");
  write(folder / "m.xml",
        "<mujoco><worldbody>"
        "<body name='a' pos='0 0 1'><freejoint/><geom size='0.1' friction='0.3'/></body>"
        "<body name='b' pos='0 0 2'><freejoint/><geom size='0.1' friction='0.7'/></body>"
        "<body name='c' pos='0 0 3'><freejoint/><geom size='0.1'/><geom size='1' contype='0' conaffinity='0' mass='0'/></body>"
        "</worldbody><contact><exclude body1='a' body2='c'/></contact></mujoco>");
  for (const char* file : {"m.sdf", "m.xml"}) {
    write(folder / "s.toml", "format = 1\n[world]\nfloor = { friction = 0.9 }\n[[mechanism]]\nname = \"m\"\nmodel = \"" +
                                 std::string(file) + "\"\n");
    const ReadResult result = read_scenario(folder / "s.toml");
    CAPTURE(file);
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    const Model& model = result.scenario->model;
    const bool larger = std::string(file) == "m.xml";
    CHECK(model.colliders().size() == (larger ? 4 : 3));
    CHECK(model.contact_law(model.body("m/a"), model.body("m/b")).friction == (larger ? 0.7 : 0.3));
    CHECK(model.contact_law(model.body("m/a"), ground).friction == 0.9);
    if (larger) CHECK(model.contact_law(model.body("m/a"), model.body("m/c")).off);
  }
}

TEST_CASE(
    "colliders: exclusions of an MJCF file name the world and bodies; others are reported, and bounce of SDF is a note; "
    "moments") {
  test::TemporaryFolder folder;
  write(folder / "m.xml",
        "<mujoco><worldbody><body name='a' pos='0 0 1'><freejoint/><geom size='0.1' condim='6'/></body></worldbody>"
        "<contact><exclude body1='a' body2='world'/><exclude body1='a' body2='nobody'/></contact></mujoco>");
  write(folder / "m.sdf",
        "<sdf version='1.7'><model name='m'><link name='a'><pose>0 0 1 0 0 0</pose><inertial><mass>1</mass></inertial>"
        "<collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry><surface>"
        "<friction><torsional><coefficient>0.1</coefficient></torsional></friction><bounce>"
        "<restitution_coefficient>0.5</restitution_coefficient></bounce></surface></collision></link></model></sdf>");
  const auto read = [&](const std::string& file) {
    write(folder / "s.toml", a_floor + "[[mechanism]]\nname = \"m\"\nmodel = \"" + file + "\"\n");
    return read_scenario(folder / "s.toml");
  };
  const ReadResult mjcf = read("m.xml");
  REQUIRE(mjcf.scenario);
  CHECK(mjcf.scenario->model.contact_law(mjcf.scenario->model.body("m/a"), ground).off);
  CHECK(warnings(mjcf).find("<exclude> names 'nobody', which is not a body of the model") != std::string::npos);
  CHECK(warnings(mjcf).find("torsional and rolling friction of geoms are left out") != std::string::npos);
  const ReadResult sdf = read("m.sdf");
  REQUIRE(sdf.scenario);
  CHECK(rendered(sdf.diagnostics).find("<torsional> is ignored; friction = { kinetic, torsional, rolling }") !=
        std::string::npos);
  INFO(rendered(sdf.diagnostics));
  CHECK(rendered(sdf.diagnostics).find("<bounce> is ignored; [[contact]] gives pairs their restitution") != std::string::npos);
}

TEST_CASE("colliders: ellipsoids of MJCF, SDF and scenarios are read, drawn, written, and touch") {
  test::TemporaryFolder folder;
  write(folder / "m.xml",
        "<mujoco><worldbody><body name='a' pos='0 0 1'><freejoint/>"
        "<geom type='ellipsoid' size='0.3 0.2 0.1' pos='1 0 0' euler='0 0 90' mass='5'/></body></worldbody></mujoco>");
  write(folder / "m.sdf",
        "<sdf version='1.10'><model name='m'><link name='a'><pose>0 0 1 0 0 0</pose><inertial><mass>5</mass></inertial>"
        "<collision name='c'><pose>1 0 0 0 0 1.5707963267948966</pose><geometry><ellipsoid><radii>0.3 0.2 0.1</radii></ellipsoid>"
        "</geometry></collision></link></model></sdf>");
  const std::string own =
      "[[mechanism]]\nname = \"m\"\nroot = \"free\"\npose = { xyz = [0, 0, 1] }\n[[mechanism.body]]\nname = \"a\"\nmass = 5\n"
      "inertia = 0.1\ncollision = { ellipsoid = [0.3, 0.2, 0.1], at = { xyz = [1, 0, 0], rpy = [0, 0, \"90 deg\"] } }\n";
  const auto of_file = [](const char* file) { return "[[mechanism]]\nname = \"m\"\nmodel = \"" + std::string(file) + "\"\n"; };
  for (const std::string& mechanism : {of_file("m.xml"), of_file("m.sdf"), own}) {
    CAPTURE(mechanism);
    write(folder / "s.toml", a_floor + mechanism);
    const ReadResult result = read_scenario(folder / "s.toml");
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    const Model& model = result.scenario->model;
    REQUIRE(model.colliders().size() == 2);
    const contact::Solid& egg = model.colliders()[model.colliders()[0].plane ? 1 : 0].solid;
    CHECK(norm(egg.centre - Vec3{1, 0, 0}) < 1e-12);
    CHECK(norm(egg.axes[0] - Vec3{0, 0.3, 0}) < 1e-12);
    CHECK(norm(egg.axes[1] - Vec3{-0.2, 0, 0}) < 1e-12);
    CHECK(norm(egg.axes[2] - Vec3{0, 0, 0.1}) < 1e-12);
    const std::string again = to_toml(model, {}, true);
    const ReadResult second = read_scenario_text(again, "again.toml");
    INFO(again);
    REQUIRE(second.scenario);
    REQUIRE(second.scenario->model.colliders().size() == 2);
    for (std::size_t k = 0; k < 3; ++k) CHECK(norm(second.scenario->model.colliders()[1].solid.axes[k] - egg.axes[k]) < 1e-12);
    const std::vector<Shape> drawn = drawn_shapes(model, result.scenario->shapes);
    REQUIRE(!drawn.empty());
    REQUIRE(drawn[0].as<contact::Ellipsoid>());
    CHECK(norm(drawn[0].as<contact::Ellipsoid>()->semi_axes - Vec3{0.3, 0.2, 0.1}) < 1e-12);
  }
  CHECK(rendered(read_scenario_text(
                     "format = 1\n" + own.substr(0, own.find("collision")) + "collision = { ellipsoid = [1, 1, 0] }\n", "s.toml")
                     .diagnostics)
            .find("ellipsoid: its three semi-axes must be greater than 0") != std::string::npos);
}

TEST_CASE("colliders: what of the world of an MJCF file is left out is said, with its place") {
  const auto said_of = [](const std::string& geom) {
    return warnings(read_scenario_text(
        "<mujoco><worldbody>\n" + geom + "<body name='a' pos='0 0 1'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>",
        "m.xml"));
  };
  CHECK(said_of("<geom type='plane' size='1 1 1'/>").empty());
  CHECK(said_of("<geom type='plane' size='1 1 1' pos='3 0 0'/>").empty());
  CHECK(said_of("<geom type='plane' size='1 1 1' pos='0 0 0.5' euler='0 90 0' contype='0' conaffinity='0'/>").empty());
}

TEST_CASE("colliders: contype and conaffinity decide which bodies touch, as in MuJoCo") {
  // All pairs of masks of two bits, on spheres side by side: MuJoCo's rule, bit by bit.
  test::TemporaryFolder folder;
  std::string bodies;
  const auto name = [](int own, int others) { return "b" + std::to_string(own) + std::to_string(others); };
  for (int own = 0; own < 4; ++own)
    for (int others = 0; others < 4; ++others)
      bodies += "<body name='" + name(own, others) + "' pos='" + std::to_string(own) + " " + std::to_string(others) +
                " 1'><freejoint/><geom size='0.1' contype='" + std::to_string(own) + "' conaffinity='" + std::to_string(others) +
                "'/></body>";
  const auto is_set = [](int mask, int bit) { return (mask >> bit) % 2 == 1; };
  for (const int plane : {-1, 0, 2}) {
    const std::string ground_mask =
        plane < 0 ? "" : "<geom type='plane' size='1 1 1' contype='" + std::to_string(plane) + "' conaffinity='0'/>";
    write(folder / "m.xml", "<mujoco><worldbody>" + ground_mask + bodies + "</worldbody></mujoco>");
    for (const char* floor : {"true", "{ friction = 0.9 }"}) {
      write(folder / "s.toml",
            "format = 1\n[world]\nfloor = " + std::string(floor) + "\n[[mechanism]]\nname = \"m\"\nmodel = \"m.xml\"\n");
      const ReadResult result = read_scenario(folder / "s.toml");
      INFO(rendered(result.diagnostics));
      REQUIRE(result.scenario);
      CHECK(warnings(result) == "");
      const Model& model = result.scenario->model;
      CHECK(model.colliders().size() == 16);  // 15 spheres and the floor
      for (int i = 1; i < 16; ++i) {
        const int own = i / 4, others = i % 4;
        const BodyId body = model.body("m/" + name(own, others));
        const int own_of_plane = plane < 0 ? 1 : plane, others_of_plane = plane < 0 ? 1 : 0;
        bool on_floor = false;
        for (const int bit : {0, 1})
          on_floor = on_floor || (is_set(own, bit) && is_set(others_of_plane, bit)) ||
                     (is_set(own_of_plane, bit) && is_set(others, bit));
        CHECK(model.contact_law(body, ground).off != on_floor);
        for (int j = 1; j < i; ++j) {
          bool touch = false;
          for (const int bit : {0, 1})
            touch = touch || (is_set(own, bit) && is_set(j % 4, bit)) || (is_set(j / 4, bit) && is_set(others, bit));
          CHECK(model.contact_law(body, model.body("m/" + name(j / 4, j % 4))).off != touch);
        }
      }
    }
  }
}

TEST_CASE("colliders: pairs of MJCF touch whatever their masks are; masks that differ within a body are reported") {
  test::TemporaryFolder folder;
  const auto body = [](const std::string& name, const std::string& x, const std::string& geoms) {
    return "<body name='" + name + "' pos='" + x + " 0 1'><freejoint/>" + geoms + "</body>";
  };
  const std::string none = " contype='0' conaffinity='0'", two = " contype='2' conaffinity='2'";
  write(folder / "m.xml",
        "<mujoco><default><default class='smooth'><pair friction='0.2 0.2'/></default></default><worldbody>"
        "<geom name='ground' type='plane' size='1 1 1'/>" +
            body("a", "0", "<geom name='ga' size='0.1' friction='0.4'" + none + "/>") +
            body("b", "1", "<geom name='gb' size='0.1' friction='0.6'" + none + "/>") +
            body("c", "2", "<geom name='gc' size='0.1'" + none + "/>") + body("d", "3", "<geom name='gd' size='0.1'/>") +
            body("e", "4", "<geom name='ge' size='0.1'/><geom size='0.05'" + two + "/>") +
            "</worldbody><contact><pair geom1='ga' geom2='gb'/><pair geom1='gb' geom2='gd' class='smooth'/>"
            "<pair geom1='ground' geom2='ga' condim='1'/><exclude body1='b' body2='d'/>"
            "<pair geom1='ga' geom2='nothing'/><pair geom1='ge' geom2='gd' friction='0.3 0.1'/></contact></mujoco>");
  write(folder / "s.toml", a_floor + "[[mechanism]]\nname = \"m\"\nmodel = \"m.xml\"\n");
  const ReadResult result = read_scenario(folder / "s.toml");
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  const Model& model = result.scenario->model;
  const auto law = [&model](const char* one, const char* other) {
    return model.contact_law(model.body(one), std::string(other) == "ground" ? ground : model.body(other));
  };
  CHECK(model.colliders().size() == 6);  // c is in no pair
  CHECK(!law("m/a", "m/b").off);
  CHECK(law("m/a", "m/b").friction == 0.6);
  CHECK(!law("m/b", "m/d").off);
  CHECK(law("m/b", "m/d").friction == 0.2);
  CHECK(!law("m/a", "ground").off);
  CHECK(law("m/a", "ground").friction == 0);
  CHECK(law("m/b", "ground").off);
  CHECK(law("m/a", "m/d").off);
  CHECK(!law("m/d", "m/e").off);
  CHECK(law("m/d", "m/e").friction == 0.3);
  const std::string said = warnings(result);
  CHECK(said.find("<pair> names 'nothing', which is no geom: ignored") != std::string::npos);
  CHECK(said.find("different friction along two tangents is not represented") != std::string::npos);
  CHECK(said.find("let only some geoms of two bodies touch, such as those of 'm/e' and the ground") != std::string::npos);
  write(folder / "m.xml", "<mujoco><worldbody>" + body("a", "0", "<geom size='0.1' contype='0.5'/>") + "</worldbody></mujoco>");
  CHECK(rendered(read_scenario(folder / "s.toml").diagnostics).find("contype: must be an integer of 32 bits") !=
        std::string::npos);
}

TEST_CASE("colliders: friction in <gazebo> elements of URDF; a second coefficient that differs is a warning, in SDF too") {
  test::TemporaryFolder folder;
  const std::string ball = collision("<sphere radius='0.1'/>");
  const auto read = [&](const std::string& gazebo) {
    write(folder / "m.urdf", "<robot name='m'>\n" + link("base", std::string()) + link("a", ball) + link("b", ball) +
                                 revolute("base", "a", "1 0 0") + revolute("base", "b", "-1 0 0") + gazebo + "</robot>\n");
    write(folder / "s.toml", a_floor + "[[mechanism]]\nname = \"m\"\nmodel = \"m.urdf\"\npose = { xyz = [0, 0, 1] }\n");
    ReadResult result = read_scenario(folder / "s.toml");
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    return result;
  };
  const std::string of_a = "<gazebo reference='a'><kp>1e6</kp><mu1>0.3</mu1><mu2>0.3</mu2></gazebo>\n";
  const ReadResult both = read(of_a + "<gazebo reference='b'><mu1 value='0.7'/></gazebo>\n");
  const Model& model = both.scenario->model;
  CHECK(warnings(both) == "");
  CHECK(rendered(both.diagnostics).find("<gazebo>") == std::string::npos);
  CHECK(model.contact_law(model.body("m/a"), ground).friction == 0.3);
  CHECK(model.contact_law(model.body("m/b"), ground).friction == 0.7);
  CHECK(model.contact_law(model.body("m/a"), model.body("m/b")).friction == 0.3);  // the smaller one, as in Gazebo
  const ReadResult different =
      read("<gazebo reference='a'><mu1>0.3</mu1><mu2>0.5</mu2></gazebo><gazebo reference='x'><mu1>1</mu1></gazebo>");
  CHECK(warnings(different).find("different friction along two tangents is not represented") != std::string::npos);
  CHECK(warnings(different).find("<gazebo>: there is no link 'x': its friction is ignored") != std::string::npos);
  CHECK(
      rendered(read("<gazebo reference='a'><selfCollide>true</selfCollide></gazebo>").diagnostics).find("<gazebo> is ignored") !=
      std::string::npos);
  write(folder / "m.urdf", "<robot name='m'>" + link("base", ball) + "<gazebo reference='base'><mu1>-1</mu1></gazebo></robot>");
  CHECK(rendered(read_scenario(folder / "s.toml").diagnostics).find("mu1: must not be negative") != std::string::npos);

  write(folder / "m.sdf",
        "<sdf version='1.7'><model name='m'><link name='a'><pose>0 0 1 0 0 0</pose><inertial><mass>1</mass><inertia><ixx>1</ixx>"
        "<iyy>1</iyy><izz>1</izz></inertia></inertial><collision "
        "name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry>"
        "<surface><friction><ode><mu>0.3</mu><mu2>0.5</mu2></ode></friction></surface></collision></link></model></sdf>");
  write(folder / "s.toml", a_floor + "[[mechanism]]\nname = \"m\"\nmodel = \"m.sdf\"\n");
  const ReadResult sdf = read_scenario(folder / "s.toml");
  REQUIRE(sdf.scenario);
  CHECK(sdf.scenario->model.contact_law({0}, ground).friction == 0.3);
  CHECK(warnings(sdf).find("different friction along two tangents is not represented") != std::string::npos);
}

TEST_CASE("colliders: robots of the repository above a floor") {
  test::TemporaryFolder folder;
  const std::string models = MOMENTREE_SOURCE_DIR "/scenarios/models/";
  const std::pair<const char*, std::size_t> cases[] = {{"simple_humanoid/simple_humanoid.urdf", 1}, {"cassie/cassie_v2.sdf", 1}};
  for (const auto& [file, least] : cases) {
    write(folder / "s.toml", a_floor + "[[mechanism]]\nname = \"m\"\nlimits = false\nroot = \"free\"\nmodel = \"" + models +
                                 file + "\"\npose = { xyz = [0, 0, 3] }\n");
    const ReadResult result = read_scenario(folder / "s.toml");
    CAPTURE(file);
    INFO(rendered(result.diagnostics));
    REQUIRE(result.scenario);
    CHECK(result.scenario->model.colliders().size() > least);
    Simulation sim(result.scenario->model, {.step = 1e-3});
    REQUIRE(sim.run_until(0.01));
    CHECK(std::fabs(sim.energy().error) < 1e-6);
  }
}
